"""Rolling and sliding, proven; not there yet: a drop that comes to it is left undecided."""

from typing import NoReturn

from engine.certified.balls import UndecidedError
from engine.certified.scene import Surface


def follow_contact(surface: Surface) -> NoReturn:
    """Raises UndecidedError, naming the surface."""
    raise UndecidedError(f"contact phase on {surface.name}")
