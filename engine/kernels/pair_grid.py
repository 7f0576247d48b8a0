"""Who may touch whom: levels of hash grids over balls of all sizes, a grid over what is fixed.

A ball reaches as far as its radius and its budget, the way it may go before the list is made anew.
It lies in one cell of the level whose cells are at least twice its reach, so all it may touch on a
level of the same or larger cells is in the nine cells around it: the smaller ball finds the larger,
and a ratio of sizes of a thousand costs a few levels more, not a search through all.
"""

from math import sqrt

import numpy as np

from engine.kernels.arena_data import (
    ASLEEP,
    BUDGET,
    FLAGS,
    GONE,
    HOME_X,
    HOME_Y,
    RADIUS,
    THICKNESS,
    VX,
    VY,
    Bodies,
    Floats,
    Ints,
    Pairs,
    Statics,
    X,
    Y,
)
from engine.kernels.jit import kernel
from engine.kernels.layout import PRIME_X, PRIME_Y
from engine.kernels.place import nearest

PRIME_LEVEL = 83492791

MARGIN = 0.25
"""Budget of a ball at rest, in radii. Smaller lists are made more often, larger ones are longer."""

LEVELS = 48

PAIRS_PER_BALL = 64
"""A longer list is made anew with half of what speed adds to the budgets."""


@kernel
def typical_speed(bodies: Bodies, n: int) -> float:
    """Square of the mean root of the awake balls' speeds, m/s: few fast ones count little."""
    vel = bodies.vel
    marks = bodies.marks
    total = 0.0
    count = 0
    for i in range(n):
        if marks[i, FLAGS] & (ASLEEP | GONE) == 0:
            vx = vel[i, VX]
            vy = vel[i, VY]
            total += sqrt(sqrt(vx * vx + vy * vy))
            count += 1
    if count == 0:
        return 0.0
    return (total / count) * (total / count)


@kernel
def set_budgets(bodies: Bodies, n: int, horizon: float, gravity: float, scale: float) -> None:
    """Give each awake ball its home and the way it is likely to go within `horizon` seconds."""
    home = bodies.home
    pos = bodies.pos
    vel = bodies.vel
    marks = bodies.marks
    typical = 1.5 * typical_speed(bodies, n)
    for i in range(n):
        home[i, HOME_X] = pos[i, X]
        home[i, HOME_Y] = pos[i, Y]
        if marks[i, FLAGS] & ASLEEP:
            home[i, BUDGET] = 0.0
            continue
        vx = vel[i, VX]
        vy = vel[i, VY]
        speed = max(1.25 * sqrt(vx * vx + vy * vy), typical) + gravity * horizon
        home[i, BUDGET] = MARGIN * pos[i, RADIUS] + scale * speed * horizon


@kernel
def _levels(bodies: Bodies, n: int, level: Ints, sleepers: Ints, all_balls: Ints) -> float:
    """Each ball's level, counts of sleepers and of all on each; returns the least cell size."""
    home = bodies.home
    pos = bodies.pos
    marks = bodies.marks
    smallest = -1.0
    for i in range(n):
        reach = pos[i, RADIUS] + home[i, BUDGET]
        if smallest < 0.0 or reach < smallest:
            smallest = reach
    smallest *= 3.0
    for i in range(n):
        reach = 2.0 * (pos[i, RADIUS] + home[i, BUDGET])
        size = smallest
        k = 0
        while size < reach and k < LEVELS - 1:
            size *= 2.0
            k += 1
        level[i] = k
        if marks[i, FLAGS] & GONE:
            continue
        all_balls[k] += 1
        if marks[i, FLAGS] & ASLEEP:
            sleepers[k] += 1
    return smallest


@kernel
def _bucket(cx: int, cy: int, level: int, mask: int) -> int:
    return int((cx * PRIME_X + cy * PRIME_Y + level * PRIME_LEVEL) & mask)


@kernel
def _grown(old: Ints) -> Ints:
    """The same numbers with twice the room."""
    new = np.empty(2 * old.shape[0], np.int32)
    new[: old.shape[0]] = old
    return new


@kernel
def _sort(values: Ints, first: int, last: int) -> None:
    """Ascending order of a short stretch: heap sort, so that no stretch makes it quadratic."""
    count = last - first
    if count < 24:
        for k in range(first + 1, last):
            value = values[k]
            m = k
            while m > first and values[m - 1] > value:
                values[m] = values[m - 1]
                m -= 1
            values[m] = value
        return
    values[first:last] = np.sort(values[first:last])


@kernel
def _close(pos: Floats, home: Floats, a: int, b: int) -> bool:
    dx = pos[a, X] - home[b, HOME_X]
    dy = pos[a, Y] - home[b, HOME_Y]
    reach = pos[a, RADIUS] + home[a, BUDGET] + pos[b, RADIUS] + home[b, BUDGET]
    return bool(dx * dx + dy * dy <= reach * reach)


@kernel
def list_pairs(
    bodies: Bodies, n: int, statics: Statics, horizon: float, gravity: float
) -> tuple[Ints, Ints]:
    """Give out budgets and list who may touch whom: starts (n + 1,), others (p,).

    Each ball's others are in ascending order, so nothing depends on the order within a cell.
    """
    scale = 1.0
    while True:
        set_budgets(bodies, n, horizon, gravity, scale)
        limit = PAIRS_PER_BALL * n + 4096 if scale > 1.0e-6 else -1
        starts, other, fits = _list_within(bodies, n, statics, limit)
        if fits:
            return starts, other
        scale *= 0.5


@kernel
def _list_within(bodies: Bodies, n: int, statics: Statics, limit: int) -> tuple[Ints, Ints, bool]:
    """`list_pairs` with the budgets given; False if there are more than `limit` (-1: no limit)."""
    pos = bodies.pos
    home = bodies.home
    marks = bodies.marks
    level = np.zeros(n, np.int32)
    sleepers = np.zeros(LEVELS, np.int32)
    all_balls = np.zeros(LEVELS, np.int32)
    smallest = _levels(bodies, n, level, sleepers, all_balls)
    buckets = 16
    while buckets < 2 * n:
        buckets *= 2
    mask = buckets - 1
    heads = np.full(buckets, -1, np.int32)
    chain = np.empty(n, np.int32)
    cells = np.empty((n, 2), np.int64)
    for i in range(n):
        if marks[i, FLAGS] & GONE:
            continue
        size = smallest
        for _ in range(level[i]):
            size *= 2.0
        cells[i, 0] = int(np.floor(pos[i, X] / size))
        cells[i, 1] = int(np.floor(pos[i, Y] / size))
        bucket = _bucket(int(cells[i, 0]), int(cells[i, 1]), int(level[i]), mask)
        chain[i] = heads[bucket]
        heads[bucket] = i
    starts = np.zeros(n + 1, np.int32)
    other = np.empty(8 * n + 64, np.int32)
    seen = np.full(statics.items.shape[0], -1, np.int32)
    count = 0
    for a in range(n):
        starts[a] = count
        if marks[a, FLAGS] & (ASLEEP | GONE):
            continue
        size = smallest
        x = pos[a, X]
        y = pos[a, Y]
        reach = pos[a, RADIUS] + home[a, BUDGET]
        for k in range(LEVELS):
            if k > 0:
                size *= 2.0
            wanted = all_balls[k] if k >= level[a] else sleepers[k]
            if wanted == 0:
                continue
            rim = 0.0 if k >= level[a] else reach
            cx0 = int(np.floor((x - rim) / size)) - 1
            cx1 = int(np.floor((x + rim) / size)) + 1
            cy0 = int(np.floor((y - rim) / size)) - 1
            cy1 = int(np.floor((y + rim) / size)) + 1
            if (cx1 - cx0 + 1) * (cy1 - cy0 + 1) > max(9, n):
                for b in range(n):  # fewer balls than cells
                    if level[b] != k or marks[b, FLAGS] & ASLEEP == 0:
                        continue
                    if _close(pos, home, a, b):
                        if count == other.shape[0]:
                            other = _grown(other)
                        other[count] = b
                        count += 1
                continue
            for cx in range(cx0, cx1 + 1):
                for cy in range(cy0, cy1 + 1):
                    b = heads[_bucket(cx, cy, k, mask)]
                    while b >= 0:
                        mine = cells[b, 0] == cx and cells[b, 1] == cy and level[b] == k
                        if mine and marks[b, FLAGS] & ASLEEP == 0:
                            mine = k > level[a] or (k == level[a] and b > a)
                        if mine and b != a and _close(pos, home, a, b):
                            if count == other.shape[0]:
                                other = _grown(other)
                            other[count] = b
                            count += 1
                        b = chain[b]
        _sort(other, starts[a], count)
        first = count
        count, other = _list_items(x, y, reach, a, statics, seen, other, count)
        _sort(other, first, count)
        if 0 <= limit < count:
            return starts, other, False
    starts[n] = count
    return starts, other[:count].copy(), True


@kernel
def _list_items(
    x: float,
    y: float,
    reach: float,
    a: int,
    statics: Statics,
    seen: Ints,
    other: Ints,
    count: int,
) -> tuple[int, Ints]:
    """Append the fixed things within `reach` of ball `a` at (x, y), as -1 - item."""
    scale = statics.cells_per_metre
    low = max(np.floor((x - reach - statics.x0) * scale), 0.0)
    high = min(np.floor((x + reach - statics.x0) * scale), statics.columns - 1.0)
    top = max(np.floor((y - reach - statics.y0) * scale), 0.0)
    bottom = min(np.floor((y + reach - statics.y0) * scale), statics.rows - 1.0)
    if not (low <= high and top <= bottom):
        return count, other
    for row in range(int(top), int(bottom) + 1):
        for column in range(int(low), int(high) + 1):
            cell = row * statics.columns + column
            for k in range(statics.starts[cell], statics.starts[cell + 1]):
                item = statics.members[k]
                if seen[item] == a:
                    continue
                seen[item] = a
                dx, dy = nearest(statics.items, item, x, y)
                near = reach + statics.items[item, THICKNESS]
                if dx * dx + dy * dy <= near * near:
                    if count == other.shape[0]:
                        other = _grown(other)
                    other[count] = -1 - item
                    count += 1
    return count, other


@kernel
def _find(starts: Ints, other: Ints, a: int, b: int) -> int:
    """Row of the pair of `a` with `b` in `a`'s part of the list, or -1."""
    for k in range(starts[a], starts[a + 1]):
        if other[k] == b:
            return k
    return -1


@kernel
def renew(
    bodies: Bodies, n: int, statics: Statics, old: Pairs, horizon: float, gravity: float
) -> Pairs:
    """A new list of pairs that takes over the impulses of the old one."""
    starts, other = list_pairs(bodies, n, statics, horizon, gravity)
    count = other.shape[0]
    old_starts = old.starts
    old_other = old.other
    old_impulse = old.impulse
    impulse = np.zeros((count, 2))
    owner = np.empty(count, np.int32)
    reverse_starts = np.zeros(n + 2, np.int32)
    for a in range(n):
        for k in range(starts[a], starts[a + 1]):
            b = other[k]
            owner[k] = a
            was = _find(old_starts, old_other, a, b)
            if b >= 0:
                reverse_starts[b + 2] += 1
                if was < 0:
                    was = _find(old_starts, old_other, b, a)
            if was >= 0:
                impulse[k, 0] = old_impulse[was, 0]
                impulse[k, 1] = old_impulse[was, 1]
    for b in range(n):
        reverse_starts[b + 2] += reverse_starts[b + 1]
    reverse = np.empty(reverse_starts[n + 1], np.int32)
    for k in range(count):
        b = other[k]
        if b >= 0:
            reverse[reverse_starts[b + 1]] = k
            reverse_starts[b + 1] += 1
    return Pairs(starts, other, impulse, reverse_starts[: n + 1], reverse, owner)


@kernel
def beyond_budget(pos: Floats, vel: Floats, home: Floats, marks: Ints, n: int, rest: float) -> bool:
    """Whether a ball would go farther from its home than its pairs hold, in `rest` seconds."""
    for i in range(n):
        if marks[i, FLAGS] & (ASLEEP | GONE):
            continue
        dx = pos[i, X] + vel[i, VX] * rest - home[i, HOME_X]
        dy = pos[i, Y] + vel[i, VY] * rest - home[i, HOME_Y]
        if not dx * dx + dy * dy <= home[i, BUDGET] * home[i, BUDGET]:
            return True
    return False


@kernel
def budget_time(home: Floats, vel: Floats, i: int, x: float, y: float) -> float:
    """Seconds until ball i, now at (x, y), has used up its budget; inf if it does not move."""
    vx = vel[i, VX]
    vy = vel[i, VY]
    vv = vx * vx + vy * vy
    if vv == 0.0:
        return np.inf
    dx = x - home[i, HOME_X]
    dy = y - home[i, HOME_Y]
    left = home[i, BUDGET] * home[i, BUDGET] - dx * dx - dy * dy
    if left <= 0.0:
        return 0.0
    dv = dx * vx + dy * vy
    return float((sqrt(dv * dv + vv * left) - dv) / vv)


@kernel
def too_far(bodies: Bodies, i: int, limit: float) -> bool:
    """Whether ball i is farther out than `limit`, m, or nowhere (NaN)."""
    return not (abs(bodies.pos[i, X]) < limit and abs(bodies.pos[i, Y]) < limit)
