"""Checks whether a requested proof is possible here."""

from functools import cache
from importlib.util import find_spec

from plinko.app.computing.tasks import Ask
from plinko.app.errors import InvalidValueError
from plinko.engine.errors import MissingPartError
from plinko.engine.parameters import Exact


@cache
def _is_installed() -> bool:
    return find_spec("flint") is not None


def require_certifier() -> None:
    """Raise MissingPartError if the packages for proofs are not installed."""
    if not _is_installed():
        raise MissingPartError(
            "this server cannot prove drops; `pip install 'plinko-sim[certify]'` adds proofs",
            field="certified",
        )


def check_certified(ask: Ask) -> None:
    """Raise MissingPartError or InvalidValueError if this drop cannot be proven here."""
    require_certifier()
    if not isinstance(ask.solver, Exact):
        raise InvalidValueError(
            f"certified true needs the solver 'exact', not {ask.solver.name!r}",
            field="certified",
        )
