"""An independent oracle of a drop: the laws of physics at fifty digits, without the kernels."""

from tools.oracle.drop import CUT, Event, OracleDrop, oracle_drop
from tools.oracle.roots import OracleError

__all__ = ["CUT", "Event", "OracleDrop", "OracleError", "oracle_drop"]
