"""Finds traps: places where a ball would rest between two obstacles for good.

Without friction, a ball rests on two obstacles if their forces, along the outward normals, can
balance its weight. That is so if 'up' is strictly between the two normals. A ball at rest on three
or more obstacles always touches two such ones. Balance on one obstacle (the top of a peg, a level
wall) is not a trap: the slightest disturbance ends it, and a drop that starts there is unsettled.

The check is exact without friction. With a high friction, a ball could also stick between
obstacles that lean a little.

A gap as wide as the ball, within rounding, is a trap in every direction: the ball could enter it
and would be squeezed.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from plinko.engine.board.checks.components import Bools
from plinko.engine.board.checks.obstacles import Floats, Ints, Obstacles, distance, near_walls
from plinko.engine.board.checks.reach import Reach
from plinko.engine.board.faults import Faults
from plinko.engine.board.fields import BoardFields

LEAN: Final = 1e-9
"""Least angle in radians by which each normal must lean from 'up' to its side. A ball in the corner
of a level and an upright wall only balances on the level one. The angle is larger than rounding and
smaller than any slope drawn on purpose."""

OVERLAP: Final = 1e-9
"""Relative overlap with a third obstacle that still counts as touching."""


@dataclass(frozen=True, slots=True)
class DoubleContacts:
    """Places of a ball's centre where it touches two obstacles a and b; arrays of equal length.

    x, y in m; (ax, ay) and (bx, by): unit normals from the obstacles to the ball; a, b: the index
    of a disc, or ~index of a wall.
    """

    x: Floats
    y: Floats
    ax: Floats
    ay: Floats
    bx: Floats
    by: Floats
    a: Ints
    b: Ints

    def where(self, mask: Bools) -> "DoubleContacts":
        return DoubleContacts(*(getattr(self, name)[mask] for name in self.__slots__))


def check_traps(
    board: BoardFields, obs: Obstacles, pairs: tuple[Ints, Ints, Floats], reach: Reach
) -> None:
    """Raise BoardError naming the traps above the bins that a ball can reach."""
    above_bins = (board.drop.y, board.bins.y)
    traps = _joined(_traps(some, *above_bins) for some in _touching_two(obs, pairs))
    traps = _joined([traps, _within(_joined(_squeezes(obs, pairs)), *above_bins)])
    traps = traps.where(reach.is_near(traps.x, traps.y))
    faults = Faults()
    seen: set[tuple[int, int]] = set()
    for k in range(len(traps.x)):
        if faults.full:
            break
        x, y = float(traps.x[k]), float(traps.y[k])
        gap = int(traps.a[k]), int(traps.b[k])
        if gap not in seen and _is_free(obs, x, y) and reach.includes(x, y):
            seen.add(gap)
            a, b = _name(obs, int(traps.a[k])), _name(obs, int(traps.b[k]))
            faults.add(
                a.split("'")[0],
                f"a ball can wedge in the gap between {a} and {b}: with radius {obs.radius:g} m "
                f"it stays at ({x:.6g}, {y:.6g}) for good; widen or close the gap",
            )
    faults.end()


def _joined(parts: Iterable[DoubleContacts]) -> DoubleContacts:
    """Concatenate `parts`, of which there must be at least one."""
    columns = ([getattr(part, name) for name in DoubleContacts.__slots__] for part in parts)
    values = zip(*columns, strict=True)
    return DoubleContacts(*(np.concatenate(arrays) for arrays in values))


def _traps(doubles: DoubleContacts, top: float, bottom: float) -> DoubleContacts:
    """The traps among `doubles` from height `top` to `bottom`, in m."""
    return _within(doubles.where(_are_traps(doubles)), top, bottom)


def _within(doubles: DoubleContacts, top: float, bottom: float) -> DoubleContacts:
    return doubles.where((doubles.y >= top) & (doubles.y < bottom))


def _squeezes(obs: Obstacles, pairs: tuple[Ints, Ints, Floats]) -> Iterator[DoubleContacts]:
    """Both mouths of each gap between a disc and a disc or wall that is as wide as the ball."""
    i, j, apart = pairs
    tight = np.abs(apart - obs.reach[i] - obs.reach[j]) <= obs.slack
    i, j, apart = i[tight], j[tight], apart[tight]
    nx, ny = (obs.x[i] - obs.x[j]) / apart, (obs.y[i] - obs.y[j]) / apart
    yield from _mouths(obs, i, j, obs.x[i], obs.y[i], nx, ny)
    for k, near, along, across in near_walls(obs):
        tight = np.abs(np.abs(across) - obs.reach[near] - obs.radius) <= obs.slack
        tight &= (along > 0.0) & (along < obs.length[k])
        disc, side = near[tight], np.sign(across[tight])
        wall = np.full(len(disc), ~k, dtype=np.intp)
        nx, ny = -side * obs.ty[k], side * obs.tx[k]
        yield from _mouths(obs, disc, wall, obs.x[disc], obs.y[disc], nx, ny)


def _mouths(
    obs: Obstacles, disc: Ints, other: Ints, x: Floats, y: Floats, nx: Floats, ny: Floats
) -> Iterator[DoubleContacts]:
    """Places a tenth of a radius before and behind the narrowest place of each gap.

    (x, y): the disc's centre; (nx, ny): the direction from the other obstacle to it.
    """
    for way in (0.1, -0.1):
        yield DoubleContacts(
            x - obs.reach[disc] * nx - way * obs.radius * ny,
            y - obs.reach[disc] * ny + way * obs.radius * nx,
            -nx,
            -ny,
            nx,
            ny,
            disc,
            other,
        )


def _name(obs: Obstacles, thing: int) -> str:
    return obs.disc_name(thing) if thing >= 0 else f"walls[{~thing}]"


def _are_traps(doubles: DoubleContacts) -> Bools:
    """Whether 'up', (0, -1), is strictly between the normals: one leans left, the other right."""
    turn = doubles.ax * doubles.by - doubles.ay * doubles.bx
    result: Bools = np.where(
        turn > 0.0,
        (doubles.bx > LEAN) & (doubles.ax < -LEAN),
        (turn < 0.0) & (doubles.bx < -LEAN) & (doubles.ax > LEAN),
    )
    return result


def _is_free(obs: Obstacles, x: float, y: float) -> bool:
    slack = 1.0 - OVERLAP
    if np.any(distance(obs.x - x, obs.y - y) < obs.reach * slack):
        return False
    dx, dy = x - obs.x1, y - obs.y1
    along = dx * obs.tx + dy * obs.ty
    across = np.abs(dy * obs.tx - dx * obs.ty)
    beside = (along > 0.0) & (along < obs.length)
    return not np.any(beside & (across < obs.radius * slack))


def _touching_two(obs: Obstacles, pairs: tuple[Ints, Ints, Floats]) -> Iterator[DoubleContacts]:
    yield from _disc_disc(obs, pairs)
    yield from _disc_wall(obs)
    yield from _wall_wall(obs)


def _disc_disc(obs: Obstacles, pairs: tuple[Ints, Ints, Floats]) -> Iterator[DoubleContacts]:
    i, j, apart = pairs
    nested = apart <= np.abs(obs.reach[i] - obs.reach[j])
    i, j, apart = i[~nested], j[~nested], apart[~nested]
    ux, uy = (obs.x[j] - obs.x[i]) / apart, (obs.y[j] - obs.y[i]) / apart
    ri, rj = obs.reach[i], obs.reach[j]
    along = 0.5 * (apart + (ri - rj) * (ri + rj) / apart)
    height = np.sqrt(np.maximum(ri * ri - along * along, 0.0))
    for side in (1.0, -1.0):
        x = obs.x[i] + along * ux - side * height * uy
        y = obs.y[i] + along * uy + side * height * ux
        yield DoubleContacts(
            x,
            y,
            (x - obs.x[i]) / ri,
            (y - obs.y[i]) / ri,
            (x - obs.x[j]) / rj,
            (y - obs.y[j]) / rj,
            i,
            j,
        )


def _disc_wall(obs: Obstacles) -> Iterator[DoubleContacts]:
    for k, near, along, across in near_walls(obs):
        for side in (1.0, -1.0):
            gap = side * obs.radius - across
            half = np.sqrt(np.maximum(obs.reach[near] ** 2 - gap**2, 0.0))
            crosses = np.abs(gap) < obs.reach[near]
            for way in (1.0, -1.0):
                s = along + way * half
                on = crosses & (s > 0.0) & (s < obs.length[k])
                disc, at = near[on], s[on]
                nx, ny = -side * obs.ty[k], side * obs.tx[k]
                x = obs.x1[k] + at * obs.tx[k] + obs.radius * nx
                y = obs.y1[k] + at * obs.ty[k] + obs.radius * ny
                yield DoubleContacts(
                    x,
                    y,
                    (x - obs.x[disc]) / obs.reach[disc],
                    (y - obs.y[disc]) / obs.reach[disc],
                    np.full_like(x, nx),
                    np.full_like(x, ny),
                    disc,
                    np.full(len(x), ~k, dtype=np.intp),
                )


def _wall_wall(obs: Obstacles) -> Iterator[DoubleContacts]:
    count = len(obs.length)
    for k in range(count - 1):
        others = _boxes_near(obs, k, np.arange(k + 1, count))
        turn = obs.tx[k] * obs.ty[others] - obs.ty[k] * obs.tx[others]
        others, turn = others[np.abs(turn) > LEAN], turn[np.abs(turn) > LEAN]
        for side_k in (1.0, -1.0):
            for side_o in (1.0, -1.0):
                yield _wall_pair(obs, k, others, turn, side_k, side_o)


def _boxes_near(obs: Obstacles, k: int, others: Ints) -> Ints:
    """Those of `others` whose bounding box is within one ball diameter of wall `k`'s."""
    near = np.ones(len(others), dtype=np.bool_)
    for a, b in ((obs.x1, obs.x2), (obs.y1, obs.y2)):
        low, high = min(a[k], b[k]) - 2.0 * obs.radius, max(a[k], b[k]) + 2.0 * obs.radius
        a_others, b_others = a[others], b[others]
        near &= np.minimum(a_others, b_others) <= high
        near &= np.maximum(a_others, b_others) >= low
    return others[near]


def _wall_pair(
    obs: Obstacles, k: int, others: Ints, turn: Floats, side_k: float, side_o: float
) -> DoubleContacts:
    """Where a ball touches wall `k` and one of `others`, each on the given side.

    Its centre is where the parallels to both walls at distance R intersect.
    """
    ax, ay = -side_k * obs.ty[k], side_k * obs.tx[k]
    bx, by = -side_o * obs.ty[others], side_o * obs.tx[others]
    dx = obs.x1[others] - obs.x1[k] + obs.radius * (bx - ax)
    dy = obs.y1[others] - obs.y1[k] + obs.radius * (by - ay)
    at_k = (dx * obs.ty[others] - dy * obs.tx[others]) / turn
    at_o = (dx * obs.ty[k] - dy * obs.tx[k]) / turn
    on = (at_k > 0.0) & (at_k < obs.length[k]) & (at_o > 0.0) & (at_o < obs.length[others])
    x = obs.x1[k] + at_k * obs.tx[k] + obs.radius * ax
    y = obs.y1[k] + at_k * obs.ty[k] + obs.radius * ay
    return DoubleContacts(
        x,
        y,
        np.full_like(x, ax),
        np.full_like(x, ay),
        bx,
        by,
        np.full(len(x), ~k, dtype=np.intp),
        ~others,
    ).where(on)
