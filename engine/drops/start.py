"""Where a drop starts: where its seed says about the board's middle or a player's aim, or at x."""

from math import isfinite

from engine.board.model import Board
from engine.errors import ParameterError
from engine.parameters import number
from engine.seeding import start_x


def unsigned_zero(x: object) -> object:
    """`x`, but 0 where it is a negative zero: the two are one place, and so one start.

    Whoever takes a new start asks this. What replays an old one does not: its digest has the bits
    that it was once made of.
    """
    return 0.0 if isinstance(x, float) and x == 0.0 else x


def start_of(board: Board, seed: int | None, x: object, aim: object = None) -> float:
    """Start of a drop in m: `x` if given, else what `seed` says about `aim`, or about the board's.

    Raises ParameterError if neither x nor seed is given, for both x and an aim, unless x is a
    finite number in the drop zone, and what `aim_of` raises.
    """
    if x is None:
        if seed is None:
            raise ParameterError("a drop needs a seed or an explicit x", field="seed")
        return start_x(seed, aim_of(board, aim), board.drop.jitter)
    if aim is not None:
        raise ParameterError(
            f"aim {aim!r} beside x {x!r}: x says where the ball starts, an aim that the seed "
            "draws it near there",
            field="aim",
        )
    if isinstance(x, float) and not isfinite(x):
        raise ParameterError(f"x {x!r} is not a finite number", field="x")
    zone = board.drop
    low = min((zone.x - zone.span, *zone.slots))
    high = max((zone.x + zone.span, *zone.slots))
    return number(x, "x", low, high)


def aim_of(board: Board, aim: object) -> float:
    """Middle of the starts that seeds draw, m: `aim`, or the board's own where that is None.

    Raises ParameterError for what is no number, lets a ball start outside the drop zone, or is
    none of the board's slots where it has some.
    """
    zone = board.drop
    if aim is None:
        return zone.x
    middle = number(aim, "aim", zone.x - zone.aim_span, zone.x + zone.aim_span) + 0.0
    if zone.slots and middle not in zone.slots:
        slots = ", ".join(f"{slot:g}" for slot in zone.slots)
        raise ParameterError(f"aim {aim!r} is none of the slots, which are {slots}", field="aim")
    return middle
