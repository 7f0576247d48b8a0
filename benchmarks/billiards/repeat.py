"""The kernels' arrays of a billiard that repeats: one cell, and copies of its pegs around it."""

from functools import lru_cache
from math import ceil, hypot

from benchmarks.billiards.billiard import Billiard
from benchmarks.billiards.flow_many import Repeat
from plinko.engine.board.parts import Peg
from plinko.engine.errors import BoardError
from plinko.engine.exact.board_arrays import BoardArrays, arrays_of

HOP_OF_OPEN_BOARD = 100_000.0
"""Search windows without an impact after which a ball on an open board has escaped. A board with
the largest allowed number of pegs is some hundred windows wide."""

MAX_COPIES = 20_000


@lru_cache(maxsize=16)
def arrays_and_repeat(billiard: Billiard) -> tuple[BoardArrays, Repeat]:
    """The kernels' form of `billiard`; cached for the latest billiards.

    The copies reach as far as a ball from the first cell can touch a peg within one hop and one
    search window.
    """
    if billiard.cell is None:
        board = arrays_of(billiard.fields)
        hop = HOP_OF_OPEN_BOARD * board.travel
        return board, Repeat(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0, hop)
    (ax, ay), (bx, by) = billiard.cell
    area = ax * by - ay * bx
    longest = max(hypot(ax, ay), hypot(bx, by), hypot(ax + bx, ay + by), hypot(ax - bx, ay - by))
    narrowest = abs(area) / longest
    contact = billiard.ball.radius + max(peg.radius for peg in billiard.pegs)
    spread = max(hypot(peg.x, peg.y) for peg in billiard.pegs)
    # The first cell's far corner, one hop, and one search window, which is shorter than a hop.
    reach = 3.0 * longest + contact + spread
    around = ceil(reach / narrowest)
    side = 2 * around + 1
    if side * side * len(billiard.pegs) > MAX_COPIES:
        raise BoardError(
            f"cell {billiard.cell!r} needs {side} by {side} copies of {len(billiard.pegs)} pegs "
            f"around a ball, more than {MAX_COPIES}: choose vectors of similar length that are far "
            "from parallel, and pegs near the origin",
            field="cell",
        )
    steps = range(-around, around + 1)
    copies = tuple(
        Peg(peg.x + i * ax + j * bx, peg.y + i * ay + j * by, peg.radius)
        for i in steps
        for j in steps
        for peg in billiard.pegs
    )
    board = arrays_of(billiard.with_pegs(copies))
    return board, Repeat(
        ax, ay, bx, by, by / area, -bx / area, -ay / area, ax / area,
        len(billiard.pegs), side, longest,
    )  # fmt: skip
