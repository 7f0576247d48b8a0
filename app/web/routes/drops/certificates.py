"""Which proofs may be asked for."""

from functools import cache
from importlib.util import find_spec

from app.computing.tasks import Ask
from app.errors import InvalidValueError, MissingPartError
from engine.parameters import Exact


@cache
def _is_installed() -> bool:
    return find_spec("flint") is not None


def require_certifier() -> None:
    """Raise MissingPartError unless proofs can be made here."""
    if not _is_installed():
        raise MissingPartError(
            "this server makes no proofs: pip install 'plinko-server[certify]' adds them",
            field="certified",
        )


def check_certified(ask: Ask) -> None:
    """Raise the errors of a drop of which no proof can be asked for."""
    require_certifier()
    if not isinstance(ask.solver, Exact):
        raise InvalidValueError(
            f"certified true belongs to the exact solver, not to {ask.solver.name!r}",
            field="certified",
        )
