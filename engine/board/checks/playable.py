"""Checks a board as a whole, after its values were checked: this file has the order of the checks.

One error names all faults, simple ones first: overlaps and invalid starts. Only a board without
these is checked further: whether a ball can land in time, what it can reach, and where it would
get stuck.
"""

import math
from typing import Final

from plinko.engine.board.checks.obstacles import close_discs, obstacles
from plinko.engine.board.checks.overlap import check_overlaps, check_start_above_bins, check_starts
from plinko.engine.board.checks.reach import check_hits_bins, check_passes, find_reach
from plinko.engine.board.checks.separators import separators
from plinko.engine.board.checks.shelves import check_shelves
from plinko.engine.board.checks.traps import check_traps
from plinko.engine.board.faults import Faults
from plinko.engine.board.fields import BoardFields
from plinko.engine.constants import MAX_TIME
from plinko.engine.errors import BoardError

SLIGHT_DRAG: Final = 1e-4
"""Limit of drag times the fall's duration. Below it the equation for the root loses digits by
cancellation, and t = t0 (1 + u / 6) is exact to 1e-9."""


def check(board: BoardFields) -> None:
    """Raise BoardError if `board`, whose values are already checked, cannot be played."""
    obs = obstacles(board)
    pairs = close_discs(obs)
    faults = Faults()
    faults.take(check_start_above_bins, board)
    faults.take(check_overlaps, board, pairs)
    faults.take(check_starts, board, obs)
    faults.end()
    faults.take(check_fall_time, board)
    lines = separators(obs, pairs, board.drop.y, board.bins.y)
    reach = faults.take(find_reach, board, obs, lines)
    if reach is not None:
        faults.take(check_passes, board, reach)
        faults.take(check_hits_bins, board, obs, reach)
        faults.take(check_traps, board, obs, pairs, reach)
    faults.take(check_shelves, board, obs)
    faults.end()


def check_fall_time(board: BoardFields) -> None:
    """Raise BoardError naming gravity or drag if a free fall to the bins takes too long."""
    way = board.bins.y - board.drop.y
    least = fall_time(board.gravity, board.drag, way)
    if least <= MAX_TIME:
        return
    field = "gravity" if fall_time(board.gravity, 0.0, way) > MAX_TIME else "drag"
    raise BoardError(
        f"{field} is {getattr(board, field)!r}: even in free fall a ball takes {least:.6g} s from "
        f"drop.y = {board.drop.y!r} to bins.y = {board.bins.y!r}, and a drop ends after "
        f"{MAX_TIME:g} s",
        field=field,
    )


def fall_time(gravity: float, drag: float, way: float) -> float:
    """Time in s in which a ball that starts at rest falls `way` m > 0.

    It is the root t of way = (g/k) (t - (1 - e^(-kt)) / k). With u = kt and a = way k^2 / g this
    is u - 1 + e^(-u) = a. The left side is convex, and the first guess is above the root (because
    1 - e^(-w - a) <= w for w = sqrt(2a)). So Newton's steps fall to the root without passing it.
    """
    free = math.sqrt(2.0 * way / gravity)
    if drag * free < SLIGHT_DRAG:
        return free * (1.0 + drag * free / 6.0)
    a = 0.5 * (drag * free) ** 2
    u = drag * free + a
    while True:
        better = u - (u + math.expm1(-u) - a) / -math.expm1(-u)
        if not better < u:
            return u / drag
        u = better
