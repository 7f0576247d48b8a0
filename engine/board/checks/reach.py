"""What a ball can reach: checks that it can get to the bins, and that it cannot miss them.

Two things are exact: which gaps the ball fits through (`separators`), and which parts of the bins'
line are free. The rest is conservative: a place that is connected to the start and not above it
counts as reached, even if no flight leads there. Only at open sides does the ball's energy limit
how far it can fly (`side_limits`).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from plinko.engine.board.checks.components import Bools, Components, connected_components
from plinko.engine.board.checks.obstacles import Floats, Ints, Obstacles
from plinko.engine.board.faults import MOST, Faults
from plinko.engine.board.fields import BoardFields
from plinko.engine.errors import BoardError

CELL: Final = 1.0 / 3.0
"""Grid spacing in ball radii. A gap between separators is at least sqrt(3) radii wide."""

COARSEST_CELL: Final = 0.5
"""Largest spacing, used on large boards to save cells; a coarser grid could miss a gap."""

MAX_CELLS: Final = 8_000_000
"""About 100 MB and one second. It limits how small a ball may be compared with the board."""

WINDOW: Final = 3
"""Grid spacings, about one ball radius: every free place sees a node of its component within it."""

SAMPLES: Final = 1025
"""Depths at which `side_limits` is exact; between them, a chord of a convex curve is safe."""

_GENERIC: Final = 0.381966011250105  # offset (golden section) that avoids round coordinates


@dataclass(frozen=True, slots=True)
class Reach:
    """The components of the grid, and which of them contain the starts and the gaps at the bins.

    separators: (k, 4), from `separators`. starts: x in m, both ends of the zone first, then slots.
    start_labels: the component of each start. gaps: (n, 2), from `free_intervals` at the bins'
    height. gap_labels: the component of each gap.
    """

    components: Components
    separators: Floats
    starts: Floats
    start_labels: Ints
    gaps: Floats
    gap_labels: Ints

    @property
    def reached(self) -> Ints:
        """Labels of the components that contain a start."""
        return np.unique(self.start_labels)

    def is_near(self, x: Floats, y: Floats) -> Bools:
        """Whether each place (x, y) in m has a reached node within WINDOW rows and columns.

        Faster than `includes`, and true wherever that is true.
        """
        xs, ys = self.components.xs, self.components.ys
        columns, rows = np.searchsorted(xs, x), np.searchsorted(ys, y)
        is_reached = np.isin(np.arange(int(self.components.label.max()) + 1), self.reached)
        near = np.zeros(len(x), dtype=np.bool_)
        for i in range(-WINDOW, WINDOW):
            for j in range(-WINDOW, WINDOW):
                row = np.clip(rows + i, 0, len(ys) - 1)
                column = np.clip(columns + j, 0, len(xs) - 1)
                near |= is_reached[self.components.label[row, column]]
        return near

    def includes(self, x: float, y: float) -> bool:
        """Whether the free place (x, y) in m is connected to a start.

        It is if no separator lies between it and a reached node within WINDOW rows and columns,
        about one ball radius.
        """
        xs, ys = self.components.xs, self.components.ys
        column, row = int(np.searchsorted(xs, x)), int(np.searchsorted(ys, y))
        columns = slice(max(column - WINDOW, 0), column + WINDOW)
        rows = slice(max(row - WINDOW, 0), row + WINDOW)
        labels = self.components.label[rows, columns]
        good = np.isin(labels, self.reached)
        if not good.any():
            return False
        at_x, at_y = np.meshgrid(xs[columns], ys[rows])
        return bool(_sees(x, y, at_x[good], at_y[good], self.separators).any())


def _sees(x: float, y: float, at_x: Floats, at_y: Floats, segments: Floats) -> Bools:
    """Whether each point `at` is visible from (x, y): no segment crosses the line between them."""
    box_x, box_y = np.append(at_x, x), np.append(at_y, y)
    x1, y1, x2, y2 = segments.T
    near = (np.minimum(x1, x2) <= box_x.max()) & (np.maximum(x1, x2) >= box_x.min())
    near &= (np.minimum(y1, y2) <= box_y.max()) & (np.maximum(y1, y2) >= box_y.min())
    x1, y1, x2, y2 = (v[None, :] for v in segments[near].T)
    px, py = at_x[:, None], at_y[:, None]
    side_1 = (px - x) * (y1 - y) - (py - y) * (x1 - x)
    side_2 = (px - x) * (y2 - y) - (py - y) * (x2 - x)
    side_p = (x2 - x1) * (py - y1) - (y2 - y1) * (px - x1)
    side_0 = (x2 - x1) * (y - y1) - (y2 - y1) * (x - x1)
    crossed = (side_1 * side_2 <= 0.0) & (side_p * side_0 <= 0.0)
    result: Bools = ~crossed.any(axis=1)
    return result


def find_reach(board: BoardFields, obs: Obstacles, separators: Floats) -> Reach:
    """Return the places that the ball can reach; BoardError if it is too small for the grid.

    separators: from `separators`, with the heights of the start and of the bins.
    """
    zone, bins = board.drop, board.bins
    gaps = free_intervals(obs, bins.y)
    probes = _probes(gaps, obs.radius)
    starts = np.array([zone.x - zone.span, zone.x + zone.span, *zone.slots])
    xs, ys = _grid(board, obs, np.concatenate((starts, probes, bins.edges)), starts, probes)
    components = connected_components(xs, ys, separators)
    start_labels = components.label[0, np.searchsorted(xs, starts)]
    gap_labels = components.label[-1, np.searchsorted(xs, probes)]
    return Reach(components, separators, starts, start_labels, gaps, gap_labels)


def check_passes(board: BoardFields, reach: Reach) -> None:
    """Raise BoardError naming the starts from which a ball can reach no bin."""
    stuck = ~np.isin(reach.start_labels, reach.gap_labels)
    places = ["the start"] if stuck[:2].any() else []
    slots = np.flatnonzero(stuck[2:]).tolist()
    places += [f"drop.slots[{i}] = {board.slots[i]!r}" for i in slots]
    faults = Faults()
    for where in places[:MOST]:
        faults.add(
            "ball.radius",
            f"ball.radius is {board.ball.radius!r}: the ball (diameter "
            f"{2 * board.ball.radius:g} m) cannot pass from {where} to the bins, because every "
            "way is narrower",
        )
    faults.end()


def check_hits_bins(board: BoardFields, obs: Obstacles, reach: Reach) -> None:
    """Raise BoardError if a ball can cross the bins' line outside the outermost edges."""
    bins = board.bins
    left, right = bins.edges[0], bins.edges[-1]
    slack = 1e-9 * board.ball.radius
    landing = reach.gaps[np.isin(reach.gap_labels, reach.start_labels)]
    if np.all((landing[:, 0] >= left - slack) & (landing[:, 1] <= right + slack)):
        return
    low, high = side_limits(obs, reach.starts, board.drop.y, bins.y)
    a, b = np.clip(landing, low, high).T
    a, b = a[a < b], b[a < b]
    first, last = float(np.min(a, initial=left)), float(np.max(b, initial=right))
    faults = Faults()
    for missed, edge, x in (
        (first < left - slack, 0, first),
        (last > right + slack, len(bins.edges) - 1, last),
    ):
        if missed:
            faults.add(
                f"bins.edges[{edge}]",
                f"bins.edges[{edge}] is {bins.edges[edge]!r}: a ball can miss the bins, and cross "
                f"bins.y = {bins.y!r} as far out as x = {x:.6g}; bins must reach from wall to wall",
            )
    faults.end()


def free_intervals(obs: Obstacles, y: float) -> Floats:
    """Where a ball's centre can be at height `y`: (n, 2) intervals of x in m, left to right.

    The first begins at -inf and the last ends at inf.
    """
    left, right = _forbidden(obs, y)
    order = np.argsort(left)
    left, right = left[order], np.maximum.accumulate(right[order])
    begin, end = np.append(-np.inf, right), np.append(left, np.inf)
    wide = end - begin > 1e-9 * obs.radius
    return np.column_stack((begin[wide], end[wide]))


def _forbidden(obs: Obstacles, y: float) -> tuple[Floats, Floats]:
    """Left and right ends in m of the intervals at height `y` inside discs and walls' strips."""
    dy = obs.y - y
    cut = np.abs(dy) < obs.reach
    half = np.sqrt(obs.reach[cut] ** 2 - dy[cut] ** 2)
    lefts, rights = [obs.x[cut] - half], [obs.x[cut] + half]
    # A strip is 0 <= along <= length and |across| <= R; at a given height both are linear in x.
    rise = y - obs.y1
    for_along = _between(obs.tx, rise * obs.ty, np.zeros_like(rise), obs.length)
    for_across = _between(-obs.ty, rise * obs.tx, np.full_like(rise, -obs.radius), obs.radius)
    a = obs.x1 + np.maximum(for_along[0], for_across[0])
    b = obs.x1 + np.minimum(for_along[1], for_across[1])
    lefts.append(a[a < b])
    rights.append(b[a < b])
    return np.concatenate(lefts), np.concatenate(rights)


def _between(
    slope: Floats, offset: Floats, low: Floats, high: Floats | float
) -> tuple[Floats, Floats]:
    """Interval of x where low <= slope x + offset <= high; from inf to -inf if it is empty."""
    steep = np.abs(slope) > 1e-15
    safe = np.where(steep, slope, 1.0)
    p, q = (low - offset) / safe, (high - offset) / safe
    always = (low <= offset) & (offset <= high)
    everywhere = np.where(always, -np.inf, np.inf)
    return np.where(steep, np.minimum(p, q), everywhere), np.where(
        steep, np.maximum(p, q), -everywhere
    )


def _probes(gaps: Floats, radius: float) -> Floats:
    """A place in m within each gap of `free_intervals`."""
    left, right = gaps.T
    if len(gaps) == 1:
        return np.zeros(1)
    inner = 0.5 * (left[1:-1] + right[1:-1])
    return np.concatenate((right[:1] - radius, inner, left[-1:] + radius))


def _grid(board: BoardFields, obs: Obstacles, xs: Floats, *exact: Floats) -> tuple[Floats, Floats]:
    """Return columns and rows of the grid in m.

    The grid spans all obstacles and `xs`. Its columns include all of `exact`; its first row is at
    the start's height and its last at the bins'. Raises BoardError if it needs more than MAX_CELLS.
    """
    top, bottom = board.drop.y, board.bins.y
    margin = 2.0 * obs.radius
    left = min(float(np.min(obs.x - obs.reach, initial=math.inf)), float(xs.min())) - margin
    right = max(float(np.max(obs.x + obs.reach, initial=-math.inf)), float(xs.max())) + margin
    cell = CELL * obs.radius
    cell *= max(1.0, math.sqrt((right - left) * (bottom - top) / MAX_CELLS) / cell)
    if cell > COARSEST_CELL * obs.radius:
        raise BoardError(
            f"ball.radius is {obs.radius!r}: the ball is too small for a board of "
            f"{right - left:.6g} by {bottom - top:.6g} m from start to bins; use a radius of at "
            f"least {cell / COARSEST_CELL:.3g} m, or a smaller board",
            field="ball.radius",
        )
    columns = left + cell * (np.arange(math.ceil((right - left) / cell)) + _GENERIC)
    rows = top + cell * (np.arange(math.ceil((bottom - top) / cell)) + _GENERIC)
    inner = rows[(rows > top) & (rows < bottom)]
    return (
        np.unique(np.concatenate((columns, *exact))),
        np.concatenate(([top], inner, [bottom])),
    )


def side_limits(obs: Obstacles, starts: Floats, top: float, bottom: float) -> tuple[float, float]:
    """Smallest and largest x in m at which a ball's centre can cross the height `bottom`.

    A ball that left its last contact at a height h below the start had a speed of at most sqrt(2 g
    h) there. At a depth d below the start, above or below that contact, it is at most 2 sqrt(h d)
    to the side: the envelope of all throws with this speed is a parabola. Linear drag only shortens
    a throw, because a path with drag lies below the parabola without it. The bound therefore
    depends neither on gravity nor on restitution and friction.

    starts: x of the starts in m, all at height `top`, shape (n,). The bound ignores that obstacles
    shield each other, and assumes each contact at the worst point of the disc or wall.
    """
    x, y, half, low = _bodies(obs)
    # As a function of u = sqrt(depth), the bound from each contact, x + 2 sqrt(h) u, is a line.
    u = np.sqrt(np.linspace(0.0, bottom - top, SAMPLES))
    right = np.full(SAMPLES, float(np.max(starts)))
    left = np.full(SAMPLES, float(np.min(starts)))
    lowest = np.clip(y + low, top, bottom)
    u_lowest = np.sqrt(lowest - top)
    untouched: Bools = y + low > top
    untouched &= y - low < bottom
    while True:
        touched = untouched & (x - half <= np.interp(u_lowest, u, right))
        touched &= x + half >= np.interp(u_lowest, u, left)
        if not touched.any():
            return float(left[-1]), float(right[-1])
        untouched &= ~touched
        for i in np.flatnonzero(touched):
            throw = 2.0 * u_lowest[i] * u
            right = np.maximum(right, x[i] + half[i] + throw)
            left = np.minimum(left, x[i] - half[i] - throw)


def _bodies(obs: Obstacles) -> tuple[Floats, Floats, Floats, Floats]:
    """Bounding boxes of discs and walls' strips: centre x and y, half width and half height, m."""
    return (
        np.concatenate((obs.x, 0.5 * (obs.x1 + obs.x2))),
        np.concatenate((obs.y, 0.5 * (obs.y1 + obs.y2))),
        np.concatenate((obs.reach, 0.5 * np.abs(obs.x2 - obs.x1) + obs.radius)),
        np.concatenate((obs.reach, 0.5 * np.abs(obs.y2 - obs.y1) + obs.radius)),
    )
