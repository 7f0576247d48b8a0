"""Checks that pegs do not overlap and that every start is above the bins and touches nothing."""

from typing import Final

import numpy as np

from plinko.engine.board.checks.obstacles import Floats, Ints, Obstacles, distance
from plinko.engine.board.faults import MOST, Faults
from plinko.engine.board.fields import BoardFields
from plinko.engine.errors import BoardError

TOUCH: Final = 1e-9
"""Relative gap below which a start counts as touching. It is larger than rounding, so that a drop
never begins in a contact, and much smaller than any gap drawn on purpose."""

OVERLAP: Final = 1e-12
"""Relative overlap allowed to touching pegs, for the rounding of their coordinates."""


def check_start_above_bins(board: BoardFields) -> None:
    """Raise BoardError if the start is not above the bins."""
    if board.drop.y >= board.bins.y:
        raise BoardError(
            f"drop.y is {board.drop.y!r}: the start must be above the bins, less than "
            f"bins.y = {board.bins.y!r} (y points down)",
            field="drop.y",
        )


def check_overlaps(board: BoardFields, pairs: tuple[Ints, Ints, Floats]) -> None:
    """Raise BoardError naming the pegs of `pairs` that overlap."""
    i, j, apart = pairs
    pegs = j < len(board.pegs)  # j > i, and pegs come first
    i, j, apart = i[pegs], j[pegs], apart[pegs]
    radii = np.array([peg.radius for peg in board.pegs], dtype=np.float64)
    bad = np.flatnonzero(apart < (radii[i] + radii[j]) * (1.0 - OVERLAP))
    faults = Faults()
    for k in bad[np.lexsort((j[bad], i[bad]))][:MOST]:
        a, b = int(i[k]), int(j[k])
        message = (
            f"pegs[{b}] at {_at(board, b)} overlaps pegs[{a}] at {_at(board, a)}: their centres "
            f"must be at least {radii[a] + radii[b]:g} m apart, but are {apart[k]:g} m"
        )
        faults.add(f"pegs[{b}]", message)
    faults.end()


def _at(board: BoardFields, i: int) -> str:
    return f"({board.pegs[i].x!r}, {board.pegs[i].y!r})"


def check_starts(board: BoardFields, obs: Obstacles) -> None:
    """Raise BoardError if a ball at an allowed start touches anything."""
    zone = board.drop
    name = "reach" if zone.reach > zone.jitter else "jitter"
    what = f"drop.x = {zone.x!r} with drop.{name} = {zone.span!r}"
    faults = Faults()
    ends = (zone.x - zone.span, zone.x + zone.span)
    faults.take(_check_start, obs, *ends, zone.y, what, "drop")
    for i, x in enumerate(zone.slots):
        path = f"drop.slots[{i}]"
        faults.take(_check_start, obs, x, x, zone.y, f"{path} = {x!r}", path)
    faults.end()


def _check_start(obs: Obstacles, left: float, right: float, y: float, what: str, path: str) -> None:
    """Check all starts with the ball's centre at height `y`, from x = `left` to `right`, in m."""
    gap = distance(obs.x - np.clip(obs.x, left, right), obs.y - y) - obs.reach
    touched = np.flatnonzero(gap <= TOUCH * obs.reach)
    if len(touched) > 0:
        name = obs.disc_name(int(touched[0]))
    else:
        walls = np.flatnonzero(_wall_distance(obs, left, right, y) <= obs.radius * (1.0 + TOUCH))
        if len(walls) == 0:
            return
        name = f"walls[{walls[0]}]"
    raise BoardError(
        f"{what} at drop.y = {y!r} lets the ball (radius {obs.radius:g} m) start inside or "
        f"touching {name}: a start must not touch anything",
        field=path,
    )


def _wall_distance(obs: Obstacles, left: float, right: float, y: float) -> Floats:
    """Distance of each wall from the starts, (m,). The caller checks wall ends as discs."""
    nearest = np.full(len(obs.length), np.inf)
    for x in (left, right):
        dx, dy = x - obs.x1, y - obs.y1
        along = np.clip(dx * obs.tx + dy * obs.ty, 0.0, obs.length)
        nearest = np.minimum(nearest, distance(dx - along * obs.tx, dy - along * obs.ty))
    crosses = (obs.y1 - y) * (obs.y2 - y) < 0.0
    rise = np.where(crosses, obs.y2 - obs.y1, 1.0)
    at = obs.x1 + (obs.x2 - obs.x1) * ((y - obs.y1) / rise)
    return np.where(crosses & (at >= left) & (at <= right), 0.0, nearest)
