"""The engine's error tree. Every message names the bad value and says what would be right.

EngineError (a ValueError)
├── BoardError        a board that cannot be played; `field` says where
├── SeedError         not an integer 0 <= seed < 2^64
├── EffortError       a call that would compute longer than allowed
├── ParameterError    an invalid parameter, such as a solver's or a drop's; `field` says which
├── RecordError       a malformed record, snapshot or result; `field` says where
├── JsonSyntaxError   text that is not JSON
├── JsonValueError    JSON with a refused value; `field` says where
└── ClusterError      a cluster that cannot compute
"""

from typing import NamedTuple


class EngineError(ValueError):
    """Base of all errors that the engine raises about its input."""

    def __init__(self, message: str, *, field: str = "") -> None:
        super().__init__(message)
        self.field = field


class Fault(NamedTuple):
    """One fault of a board: its path in the JSON form, and the message."""

    field: str
    message: str


class BoardError(EngineError):
    """A board that cannot be played. `field` is a path in its JSON form, such as `pegs[3].radius`.

    `faults` lists all faults that were found together. Overlapping parts and traps are only found
    on a board whose values are all valid.
    """

    def __init__(self, message: str, *, field: str = "", faults: tuple[Fault, ...] = ()) -> None:
        super().__init__(message, field=field)
        self.faults = faults or (Fault(field, message),)


class EffortError(EngineError):
    """A call would compute longer than this process allows; see `limit_calls`."""


class SeedError(EngineError):
    """A seed that is not an integer 0 <= seed < 2^64."""


class ParameterError(EngineError):
    """A parameter, such as a solver's, a drop's or an arena's, that is invalid."""


class RecordError(EngineError):
    """A record, snapshot or result with a field that is missing or invalid."""


class JsonSyntaxError(EngineError):
    """Text that is not JSON, or is nested too deeply."""


class JsonValueError(EngineError):
    """JSON with a duplicate key, or a value that readers could understand differently.

    `field` is its path.
    """


class ClusterError(EngineError):
    """A cluster that does not answer, has no workers, or has workers with other physics."""
