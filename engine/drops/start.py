"""Where a drop starts: at an explicit x, or where its seed says, around the board's x or an aim."""

from math import isfinite

from plinko.engine.board.model import Board
from plinko.engine.errors import ParameterError
from plinko.engine.parameters import number
from plinko.engine.seeding import start_x


def unsigned_zero(x: object) -> object:
    """Return `x`, with a negative zero replaced by 0: both are the same place, so the same start.

    For new drops only. A replay must keep the negative zero, because the drop's digest covers its
    bits.
    """
    return 0.0 if isinstance(x, float) and x == 0.0 else x


def start_of(board: Board, seed: int | None, x: object, aim: object = None) -> float:
    """Return the x in m of a drop's start: `x` if given, otherwise what `seed` draws around `aim`.

    Raises ParameterError if neither x nor seed is given, if both x and aim are, if x is not a
    finite number in the drop zone, and for an invalid aim (`aim_of`).
    """
    if x is None:
        if seed is None:
            raise ParameterError("a drop needs a seed or an explicit x", field="seed")
        return start_x(seed, aim_of(board, aim), board.drop.jitter)
    if aim is not None:
        raise ParameterError(
            f"aim is {aim!r}, but x is {x!r}: give either x, the exact start, or an aim, around "
            "which the seed draws it",
            field="aim",
        )
    if isinstance(x, float) and not isfinite(x):
        raise ParameterError(f"x {x!r} is not a finite number", field="x")
    zone = board.drop
    low = min((zone.x - zone.span, *zone.slots))
    high = max((zone.x + zone.span, *zone.slots))
    return number(x, "x", low, high)


def aim_of(board: Board, aim: object) -> float:
    """Return the middle of the starts that seeds draw, m: `aim`, or the board's own x if None.

    Raises ParameterError if `aim` is not a number, if a ball could start outside the drop zone, or
    if the board has slots and `aim` is not one of them.
    """
    zone = board.drop
    if aim is None:
        return zone.x
    middle = number(aim, "aim", zone.x - zone.aim_span, zone.x + zone.aim_span) + 0.0
    if zone.slots and middle not in zone.slots:
        slots = ", ".join(f"{slot:g}" for slot in zone.slots)
        raise ParameterError(f"aim {aim!r} is not a slot: the slots are {slots}", field="aim")
    return middle
