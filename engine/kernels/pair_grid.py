"""Who may touch whom: levels of hash grids over balls of all sizes, a grid over what is fixed.

A ball reaches as far as its radius and its budget, the way it may go before the list is made anew.
It lies in one cell of the level whose cells are at least as large as its reach, and is looked for
in the cells that its reach and the longest of a level cover. The smaller ball owns a pair, so a
ratio of sizes of a thousand costs a few levels more, not a search through all.
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
    Counts,
    Floats,
    Ints,
    Pairs,
    Statics,
    X,
    Y,
)
from engine.kernels.jit import kernel, lean_kernel
from engine.kernels.place import nearest

# Multipliers of the prime hash of Teschner et al., VMV 2003.
PRIME_Y = 19349663
PRIME_LEVEL = 83492791

MARGIN = 0.25
"""Budget of a ball at rest, in radii. Smaller lists are made more often, larger ones are longer."""

CELL = 1.25
"""Size of the least cells, in harmonic means of the balls' reaches. Half of it would mean more
cells for each ball, twice more balls in each; at one most balls would be on two levels."""

ROWS = 1 << 32
"""More than there can be balls: a ball's rank is its row and its level times this."""

LEVELS = 48

PAIRS_PER_BALL = 64
"""A longer list is made anew with half of what speed adds to the budgets."""


@lean_kernel
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


@lean_kernel
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


@lean_kernel
def _levels(bodies: Bodies, n: int, reach: Floats, level: Ints, farthest: Floats) -> float:
    """Each ball's reach and level, the longest reach on each level; the size of the least cells.

    That size suits the harmonic mean of the reaches: most balls are on one level then, and the
    small among balls of all sizes do not crowd in the cells of the large.
    """
    home = bodies.home
    pos = bodies.pos
    total = 0.0
    for i in range(n):
        reach[i] = pos[i, RADIUS] + home[i, BUDGET]
        total += 1.0 / reach[i]
    smallest = CELL * n / total
    for i in range(n):
        size = smallest
        k = 0
        while size < reach[i] and k < LEVELS - 1:
            size *= 2.0
            k += 1
        level[i] = k
        farthest[k] = max(farthest[k], reach[i])
    return smallest


@lean_kernel
def _bucket(cx: int, cy: int, level: int, mask: int) -> int:
    """Cells side by side are in buckets side by side: a row of them is one stretch."""
    return int((cx + cy * PRIME_Y + level * PRIME_LEVEL) & mask)


@lean_kernel
def _fill_buckets(
    bodies: Bodies, n: int, reach: Floats, level: Ints, smallest: float, bucket: Ints,
    firsts: Ints, spots: Floats, ranks: Counts,
) -> None:  # fmt: skip
    """Where the balls of each bucket are, ascending, from firsts[bucket] to the next.

    `spots` (n, 3) gets x, y and reach in m, `ranks` (n,) a number that grows with level and row;
    of a sleeper, which all others own their pairs with, one above all others.
    """
    pos = bodies.pos
    marks = bodies.marks
    mask = firsts.shape[0] - 3
    for i in range(n):
        if marks[i, FLAGS] & GONE:
            continue
        size = smallest
        for _ in range(level[i]):
            size *= 2.0
        cx = int(np.floor(pos[i, X] / size))
        cy = int(np.floor(pos[i, Y] / size))
        bucket[i] = _bucket(cx, cy, int(level[i]), mask)
        firsts[bucket[i] + 2] += 1
    for b in range(mask + 1):
        firsts[b + 2] += firsts[b + 1]
    for i in range(n):
        if marks[i, FLAGS] & GONE == 0:
            m = firsts[bucket[i] + 1]
            firsts[bucket[i] + 1] = m + 1
            spots[m, 0] = pos[i, X]
            spots[m, 1] = pos[i, Y]
            spots[m, 2] = reach[i]
            ranks[m] = i + ROWS * (LEVELS if marks[i, FLAGS] & ASLEEP else int(level[i]))


@lean_kernel
def _sort(values: Ints, first: int, last: int) -> None:
    """Ascending order of a stretch, mostly a short one: Shell's sort."""
    gap = 1
    while gap * 3 < last - first:
        gap = gap * 9 // 4 + 1
    while gap > 0:
        for k in range(first + gap, last):
            value = values[k]
            m = k
            while m >= first + gap and values[m - gap] > value:
                values[m] = values[m - gap]
                m -= gap
            values[m] = value
        gap = 0 if gap == 1 else max(1, gap * 4 // 9)


@lean_kernel
def _without_doubles(values: Ints, first: int, last: int) -> int:
    """Where a sorted stretch ends without what is there more than once."""
    end = min(first + 1, last)
    for k in range(first + 1, last):
        if values[k] != values[k - 1]:
            values[end] = values[k]
            end += 1
    return end


@lean_kernel
def _list_stretch(
    x: float, y: float, reach: float, rank: int, low: int, high: int, spots: Floats,
    ranks: Counts, other: Ints, count: int,
) -> int:  # fmt: skip
    """Append those of a stretch that are near and of a higher rank; the length of the list then.

    What does not fit is counted only. No branch depends on where the balls are: half of such
    guesses of the processor would be wrong, which costs more than to write what is overwritten.
    """
    last = other.shape[0] - 1
    for m in range(low, high):
        dx = x - spots[m, 0]
        dy = y - spots[m, 1]
        most = reach + spots[m, 2]
        other[min(count, last)] = ranks[m] & (ROWS - 1)
        count += int((dx * dx + dy * dy <= most * most) & (ranks[m] > rank))
    return count


@lean_kernel
def _list_balls(
    x: float, y: float, reach: float, rank: int, farthest: Floats, smallest: float,
    firsts: Ints, spots: Floats, ranks: Counts, other: Ints, count: int,
) -> int:  # fmt: skip
    """Append the balls near (x, y) that one of that reach and rank may touch and owns the pair
    with, some perhaps twice; the length of the list then."""
    mask = firsts.shape[0] - 3
    size = smallest
    for k in range(farthest.shape[0]):
        if k > 0:
            size *= 2.0
        if farthest[k] == 0.0:
            continue
        rim = reach + farthest[k]
        cx = int(np.floor((x - rim) / size))
        cy = int(np.floor((y - rim) / size))
        columns = int(np.floor((x + rim) / size)) - cx + 1
        rows = int(np.floor((y + rim) / size)) - cy + 1
        if columns * rows > max(25, firsts[mask + 1]):  # there are fewer balls than cells
            return _list_stretch(x, y, reach, rank, 0, firsts[mask + 1], spots, ranks, other, count)
        for row in range(rows):
            first = _bucket(cx, cy + row, k, mask)
            end = first + columns
            count = _list_stretch(
                x, y, reach, rank, firsts[first], firsts[min(end, mask + 1)], spots, ranks,
                other, count,
            )  # fmt: skip
            if end > mask + 1:  # the stretch goes on at the first bucket
                count = _list_stretch(
                    x, y, reach, rank, 0, firsts[min(end - mask - 1, first)], spots, ranks,
                    other, count,
                )  # fmt: skip
    return count


@lean_kernel
def _list_items(
    x: float, y: float, reach: float, a: int, statics: Statics, seen: Ints, other: Ints, count: int
) -> int:
    """Append the fixed things within `reach` of ball `a` at (x, y), as -1 - item."""
    scale = statics.cells_per_metre
    items = statics.items
    room = other.shape[0]
    low = max(np.floor((x - reach - statics.x0) * scale), 0.0)
    high = min(np.floor((x + reach - statics.x0) * scale), statics.columns - 1.0)
    top = max(np.floor((y - reach - statics.y0) * scale), 0.0)
    bottom = min(np.floor((y + reach - statics.y0) * scale), statics.rows - 1.0)
    if low <= high and top <= bottom:
        for row in range(int(top), int(bottom) + 1):
            for column in range(int(low), int(high) + 1):
                cell = row * statics.columns + column
                for k in range(statics.starts[cell], statics.starts[cell + 1]):
                    item = statics.members[k]
                    if seen[item] == a:
                        continue
                    seen[item] = a
                    dx, dy = nearest(items, item, x, y)
                    near = reach + items[item, THICKNESS]
                    if dx * dx + dy * dy <= near * near:
                        if count < room:
                            other[count] = -1 - item
                        count += 1
    return count


@lean_kernel
def _list_all(
    bodies: Bodies, n: int, statics: Statics, reach: Floats, level: Ints, farthest: Floats,
    smallest: float, firsts: Ints, spots: Floats, ranks: Counts, limit: int,
    seen: Ints, starts: Ints, other: Ints,
) -> int:  # fmt: skip
    """Fill `starts` and `other`; the length of the list, or more than the room in `other`, where
    that is too small, or than `limit`, where it ended."""
    pos = bodies.pos
    marks = bodies.marks
    room = other.shape[0]
    most = min(limit, room)
    count = 0
    for a in range(n):
        starts[a] = count
        if marks[a, FLAGS] & (ASLEEP | GONE) or count > most:
            continue
        count = _list_balls(
            pos[a, X], pos[a, Y], reach[a], a + ROWS * int(level[a]), farthest, smallest, firsts,
            spots, ranks, other, count,
        )  # fmt: skip
        if count <= room:
            _sort(other, starts[a], count)
            count = _without_doubles(other, starts[a], count)
        first = count
        count = _list_items(pos[a, X], pos[a, Y], reach[a], a, statics, seen, other, count)
        _sort(other, first, min(count, room))
    starts[n] = count
    return count


@kernel
def list_pairs(
    bodies: Bodies, n: int, statics: Statics, horizon: float, gravity: float
) -> tuple[Ints, Ints]:
    """Give out budgets and list who may touch whom: starts (n + 1,), others (p,).

    Each ball's others are in ascending order, so nothing depends on the order within a cell.
    """
    buckets = 16
    while buckets < 2 * n:
        buckets *= 2
    reach = np.empty(n)
    level = np.empty(n, np.int32)
    bucket = np.empty(n, np.int32)
    spots = np.empty((n, 3))
    ranks = np.empty(n, np.int64)
    starts = np.empty(n + 1, np.int32)
    other = np.empty(4 * n + 64, np.int32)
    scale = 1.0
    while True:
        set_budgets(bodies, n, horizon, gravity, scale)
        farthest = np.zeros(LEVELS)
        firsts = np.zeros(buckets + 2, np.int32)
        smallest = _levels(bodies, n, reach, level, farthest)
        levels = int(level.max()) + 1
        _fill_buckets(bodies, n, reach, level, smallest, bucket, firsts, spots, ranks)
        limit = PAIRS_PER_BALL * n + 4096 if scale > 1.0e-6 else 2147483647
        while True:
            seen = np.full(statics.items.shape[0], -1, np.int32)
            count = _list_all(
                bodies, n, statics, reach, level, farthest[:levels], smallest, firsts, spots,
                ranks, limit, seen, starts, other,
            )  # fmt: skip
            if count > limit or count <= other.shape[0]:
                break
            other = np.empty(max(count, 2 * other.shape[0]), np.int32)
        if count <= limit:
            return starts, other[:count].copy()
        scale *= 0.5


@lean_kernel
def _find(starts: Ints, other: Ints, a: int, b: int) -> int:
    """Row of the pair of `a` with `b` in `a`'s part of the list, or -1."""
    found = -1
    for k in range(starts[a], starts[a + 1]):
        if other[k] == b:
            found = k
            break
    return found


@lean_kernel
def _take_over(old: Pairs, starts: Ints, other: Ints, impulse: Floats) -> None:
    """Copy the impulses of the old list to the pairs that are in the new one as well."""
    old_starts = old.starts
    old_other = old.other
    old_impulse = old.impulse
    for a in range(starts.shape[0] - 1):
        for was in range(old_starts[a], old_starts[a + 1]):
            if old_impulse[was, 0] == 0.0:
                continue
            b = old_other[was]
            k = _find(starts, other, a, b)
            if k < 0 and b >= 0:
                k = _find(starts, other, b, a)
            if k >= 0:
                impulse[k, 0] = old_impulse[was, 0]
                impulse[k, 1] = old_impulse[was, 1]


@lean_kernel
def _count_near(starts: Ints, other: Ints, near_starts: Ints) -> int:
    """Where the list of all that may touch a ball begins, a row later; its length."""
    n = starts.shape[0] - 1
    for a in range(n):
        near_starts[a + 2] += starts[a + 1] - starts[a]
        for k in range(starts[a], starts[a + 1]):
            b = other[k]
            if b >= 0:
                near_starts[b + 2] += 1
    for b in range(n):
        near_starts[b + 2] += near_starts[b + 1]
    return int(near_starts[n + 1])


@lean_kernel
def _fill_near(starts: Ints, other: Ints, near_starts: Ints, near: Ints) -> None:
    for a in range(starts.shape[0] - 1):
        for k in range(starts[a], starts[a + 1]):
            b = other[k]
            near[near_starts[a + 1]] = b
            near_starts[a + 1] += 1
            if b >= 0:
                near[near_starts[b + 1]] = a
                near_starts[b + 1] += 1


@kernel
def renew(
    bodies: Bodies, n: int, statics: Statics, old: Pairs, horizon: float, gravity: float
) -> Pairs:
    """A new list of pairs that takes over the impulses of the old one."""
    starts, other = list_pairs(bodies, n, statics, horizon, gravity)
    impulse = np.zeros((other.shape[0], 2))
    _take_over(old, starts, other, impulse)
    near_starts = np.zeros(n + 2, np.int32)
    near = np.empty(_count_near(starts, other, near_starts), np.int32)
    _fill_near(starts, other, near_starts, near)
    return Pairs(starts, other, impulse, near_starts[: n + 1], near)


@lean_kernel
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
