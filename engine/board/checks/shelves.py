"""Finds shelves: level walls straight below a start, on which a ball comes to rest.

A ball that falls straight onto a level wall bounces on one spot until it lies there, and nothing
moves it on. On the slightest slope it would roll off. It also rolls off if it hit anything before
the wall, because that gives it a speed along the wall. So only the first obstacle below a start
matters.
"""

from typing import Final

import numpy as np

from plinko.engine.board.checks.obstacles import Floats, Obstacles
from plinko.engine.board.checks.traps import LEAN
from plinko.engine.board.faults import Faults
from plinko.engine.board.fields import BoardFields

SLACK: Final = 1e-9
"""Lengths below this fraction of the ball's radius are rounding."""


def check_shelves(board: BoardFields, obs: Obstacles) -> None:
    """Raise BoardError naming the level walls onto which a ball falls straight from a start.

    `check_starts` has already checked that no start touches an obstacle.
    """
    zone = board.drop
    # A zone narrower than rounding counts as one start.
    span = zone.span if zone.span > SLACK * obs.radius else 0.0
    starts = [(zone.x - span, zone.x + span), *((x, x) for x in zone.slots)]
    level = np.abs(obs.ty) <= LEAN
    level &= (obs.y1 > zone.y) & (obs.y1 - obs.radius < board.bins.y)
    faults = Faults()
    for k in np.flatnonzero(level).tolist():
        if faults.full:
            break
        rest = float(obs.y1[k]) - obs.radius
        covered = _covered(obs, zone.y, rest - SLACK * obs.radius)
        left, right = sorted((float(obs.x1[k]), float(obs.x2[k])))
        for first, last in starts:
            x = _uncovered(covered, max(left, first), min(right, last), SLACK * obs.radius)
            if x is not None:
                faults.add(
                    f"walls[{k}]",
                    f"walls[{k}] is level: a ball that starts above it, at x = {x:.6g}, can come "
                    "to rest there; a wall under a start must slope",
                )
                break
    faults.end()


def _covered(obs: Obstacles, top: float, bottom: float) -> Floats:
    """Intervals of x in which a ball falling from `top` hits something above `bottom`; (n, 2) in m.

    It hits discs and the upper sides of the walls' strips. `top` and `bottom` are heights of its
    centre.
    """
    depth = np.maximum(obs.y - bottom, 0.0)
    below = (obs.y > top) & (depth < obs.reach)
    half = np.sqrt(obs.reach[below] ** 2 - depth[below] ** 2)
    discs = np.column_stack((obs.x[below] - half, obs.x[below] + half))

    up = np.where(obs.tx > 0.0, 1.0, -1.0) * obs.radius  # across the wall, to its upper side
    ax, ay = obs.x1 + up * obs.ty, obs.y1 - up * obs.tx
    bx, by = obs.x2 + up * obs.ty, obs.y2 - up * obs.tx
    steep = np.abs(by - ay) > LEAN * obs.length
    rise = np.where(steep, by - ay, 1.0)
    from_top, from_bottom = (top - ay) / rise, (bottom - ay) / rise
    between = (ay > top) & (ay < bottom)
    begin = np.where(steep, np.minimum(from_top, from_bottom), np.where(between, 0.0, 1.0))
    end = np.where(steep, np.maximum(from_top, from_bottom), 1.0)
    begin, end = np.maximum(begin, 0.0), np.minimum(end, 1.0)
    some = begin < end
    first, last = (ax + share * (bx - ax) for share in (begin, end))
    strips = np.column_stack((np.minimum(first, last), np.maximum(first, last)))[some]
    return np.concatenate((discs, strips))


def _uncovered(covered: Floats, left: float, right: float, least: float) -> float | None:
    """The middle of the first gap between the intervals in [left, right] wider than `least` m.

    If left == right, that place, unless it is inside an interval. None if there is no gap.
    """
    if left > right:
        return None
    if left == right:
        inside = (covered[:, 0] < left) & (left < covered[:, 1])
        return None if inside.any() else left
    reached = left
    for begin, end in covered[np.argsort(covered[:, 0])].tolist():
        if min(begin, right) - reached > least:
            break
        reached = max(reached, end)
    else:
        begin = right
    gap_end = min(begin, right)
    return 0.5 * (reached + gap_end) if gap_end - reached > least else None
