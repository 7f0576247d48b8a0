"""Obstacles to a ball's centre, as arrays: discs around pegs and wall ends, strips along walls.

The centre of a ball of radius R cannot enter a disc of radius R + r around a peg of radius r, a
strip of R to either side of a wall, or a disc of radius R around a wall's end. The other checks of
this folder work on these.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.fields import BoardFields
from plinko.engine.errors import BoardError

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.intp]

CHUNK: Final = 1 << 20
"""Pairs examined at a time. It limits memory to some tens of megabytes and affects no result."""

MAX_SWEEP: Final = 100_000_000
"""Most candidate pairs, which take a few seconds to examine. Only a board with far more pegs per
ball diameter than any sensible one exceeds it."""

TIGHT: Final = 1e-9
"""A gap that exceeds the ball's diameter by at most this share counts as closed. Rounding would
decide whether the ball wedges in it or passes."""

MAX_CLOSE: Final = 1_000_000
"""Most pairs of obstacles with no gap for the ball; limits time and memory too."""


@dataclass(frozen=True, slots=True)
class Obstacles:
    """Discs (pegs, then both ends of each wall) and walls, as obstacles to a ball's centre; in m.

    x, y, reach: (n,) centres of the discs, and the least distance of the ball's centre from each.
    x1, y1, x2, y2: (m,) ends of the walls; tx, ty: unit vectors from the first to the second end;
    length: (m,).
    """

    radius: float
    peg_count: int
    x: Floats
    y: Floats
    reach: Floats
    x1: Floats
    y1: Floats
    x2: Floats
    y2: Floats
    tx: Floats
    ty: Floats
    length: Floats

    @property
    def slack(self) -> float:
        """Width in m by which a gap may exceed the ball's diameter and still count as closed."""
        return 2.0 * TIGHT * self.radius

    def disc_name(self, i: int) -> str:
        """Path of disc `i` in the JSON form."""
        if i < self.peg_count:
            return f"pegs[{i}]"
        wall, end = divmod(i - self.peg_count, 2)
        return f"walls[{wall}]'s {'second' if end else 'first'} end"


def distance(dx: Floats, dy: Floats) -> Floats:
    """Length of the vectors (dx, dy). Unlike hypot, sqrt has the same bits on all machines."""
    result: Floats = np.sqrt(dx * dx + dy * dy)
    return result


def obstacles(board: BoardFields) -> Obstacles:
    radius = board.ball.radius
    pegs = np.array([(p.x, p.y, p.radius) for p in board.pegs], dtype=np.float64).reshape(-1, 3)
    walls = np.array([(w.x1, w.y1, w.x2, w.y2) for w in board.walls], dtype=np.float64)
    walls = walls.reshape(-1, 4)
    ends = walls.reshape(-1, 2)
    x1, y1, x2, y2 = walls.T
    length = distance(x2 - x1, y2 - y1)
    return Obstacles(
        radius=radius,
        peg_count=len(pegs),
        x=np.concatenate((pegs[:, 0], ends[:, 0])),
        y=np.concatenate((pegs[:, 1], ends[:, 1])),
        reach=np.concatenate((pegs[:, 2] + radius, np.full(len(ends), radius))),
        x1=x1,
        y1=y1,
        x2=x2,
        y2=y2,
        tx=(x2 - x1) / length,
        ty=(y2 - y1) / length,
        length=length,
    )


def close_discs(obs: Obstacles) -> tuple[Ints, Ints, Floats]:
    """Pairs i < j of discs that overlap or touch, and their distances; arrays of equal length.

    The ball cannot pass between such a pair, or only by TIGHT. To find them, the discs are sorted
    along the axis with fewer candidates, and only neighbours are compared. BoardError if there are
    too many pairs.
    """
    reach = obs.reach + obs.slack
    along_x, along_y = _Sweep(obs.x, reach), _Sweep(obs.y, reach)
    sweep = along_x if along_x.total <= along_y.total else along_y
    if sweep.total > MAX_SWEEP:
        raise _too_dense()
    found: list[tuple[Ints, Ints, Floats]] = []
    count = 0
    for i, j in sweep.candidates():
        apart = distance(obs.x[i] - obs.x[j], obs.y[i] - obs.y[j])
        close = apart <= obs.reach[i] + obs.reach[j] + obs.slack
        found.append((np.minimum(i, j)[close], np.maximum(i, j)[close], apart[close]))
        count += int(np.count_nonzero(close))
        if count > MAX_CLOSE:
            raise _too_dense()
    if not found:
        none = np.empty(0, dtype=np.intp)
        return none, none, np.empty(0)
    first, second, distances = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return first, second, distances


def _too_dense() -> BoardError:
    return BoardError(
        f"pegs are too close together: more than {MAX_CLOSE} pairs leave no gap for the ball; use "
        "fewer pegs or a smaller ball",
        field="pegs",
    )


class _Sweep:
    """Finds pairs of overlapping intervals centre +- reach by sorting their left ends."""

    def __init__(self, centre: Floats, reach: Floats) -> None:
        left = centre - reach
        self.order: Ints = np.argsort(left, kind="stable")
        ends = np.searchsorted(left[self.order], (centre + reach)[self.order], side="right")
        self.counts: Ints = np.maximum(ends - np.arange(1, len(left) + 1), 0).astype(np.intp)
        self.total = int(self.counts.sum())

    def candidates(self) -> Iterator[tuple[Ints, Ints]]:
        """Index arrays of pairs, about CHUNK at a time."""
        before = np.concatenate(([0], np.cumsum(self.counts)))
        start = 0
        while start < len(self.counts):
            stop = int(np.searchsorted(before, before[start] + CHUNK, side="right"))
            stop = max(start + 1, min(stop - 1, len(self.counts)))
            counts = self.counts[start:stop]
            first = np.repeat(np.arange(start, stop), counts)
            offset = np.arange(len(first)) - np.repeat(before[start:stop] - before[start], counts)
            yield self.order[first], self.order[first + 1 + offset]
            start = stop


def near_walls(obs: Obstacles) -> Iterator[tuple[int, Ints, Floats, Floats]]:
    """For each wall, find the discs that a ball can touch while it touches the wall.

    The wall's own ends are left out. Yields the wall's index, the discs' indices, and their
    coordinates in m along the wall, from its first end, and across it (dy tx - dx ty).
    """
    margin = obs.radius + float(np.max(obs.reach, initial=0.0))
    margin += obs.slack
    by_x, by_y = _Column(obs.x), _Column(obs.y)
    for k in range(len(obs.length)):
        in_x = by_x.between(obs.x1[k], obs.x2[k], margin)
        in_y = by_y.between(obs.y1[k], obs.y2[k], margin)
        near = in_x if len(in_x) <= len(in_y) else in_y
        dx, dy = obs.x[near] - obs.x1[k], obs.y[near] - obs.y1[k]
        along = dx * obs.tx[k] + dy * obs.ty[k]
        across = dy * obs.tx[k] - dx * obs.ty[k]
        reach = obs.reach[near]
        own = obs.peg_count + 2 * k
        close = (along > -reach) & (along < obs.length[k] + reach)
        close &= (
            (np.abs(across) <= reach + obs.radius + obs.slack) & (near != own) & (near != own + 1)
        )
        order = np.argsort(near[close])
        yield k, near[close][order], along[close][order], across[close][order]


class _Column:
    """Coordinates, sorted once for range queries."""

    def __init__(self, values: Floats) -> None:
        self.order: Ints = np.argsort(values, kind="stable")
        self.sorted = values[self.order]

    def between(self, a: float, b: float, margin: float) -> Ints:
        """Indices of the coordinates from min(a, b) - margin to max(a, b) + margin."""
        first = np.searchsorted(self.sorted, min(a, b) - margin, side="left")
        last = np.searchsorted(self.sorted, max(a, b) + margin, side="right")
        return self.order[first:last]
