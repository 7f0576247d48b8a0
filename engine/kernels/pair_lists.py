"""The list of who may touch whom: pairs in order, with the impulses of the list before."""

import numpy as np

from engine.kernels.arena_data import (
    ASLEEP,
    FLAGS,
    GONE,
    THICKNESS,
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
from engine.kernels.pair_grid import ROWS, find_pairs
from engine.kernels.place import nearest


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
def _by_owner(n: int, found: Counts, count: int, ends: Ints, loose: Ints) -> None:
    """Put the others of each ball's pairs into a stretch of `loose`, from the end of the ball
    before to ends[ball]."""
    ends[:] = 0
    for m in range(count):
        ends[(found[m, 0] & (ROWS - 1)) + 1] += 1
    for a in range(n):
        ends[a + 1] += ends[a]
    for m in range(count):
        a = found[m, 0] & (ROWS - 1)
        loose[ends[a]] = found[m, 1] & (ROWS - 1)
        ends[a] += 1


@lean_kernel
def _list_all(
    bodies: Bodies, n: int, statics: Statics, reach: Floats, ends: Ints, loose: Ints, seen: Ints,
    starts: Ints, other: Ints,
) -> int:  # fmt: skip
    """Fill `starts` and `other`, each ball's others ascending, then what is fixed; the length of
    the list, or more than the room in `other`, where that is too small."""
    pos = bodies.pos
    marks = bodies.marks
    room = other.shape[0]
    count = 0
    first = 0
    for a in range(n):
        starts[a] = count
        if marks[a, FLAGS] & (ASLEEP | GONE):
            continue
        last = ends[a]
        _sort(loose, first, last)
        for m in range(first, last):
            if m == first or loose[m] != loose[m - 1]:
                other[min(count, room - 1)] = loose[m]
                count += 1
        first = last
        fixed = count
        count = _list_items(pos[a, X], pos[a, Y], reach[a], a, statics, seen, other, count)
        _sort(other, fixed, min(count, room))
    starts[n] = count
    return count


@kernel
def list_pairs(
    bodies: Bodies, n: int, statics: Statics, horizon: float, gravity: float
) -> tuple[Ints, Ints]:
    """Give out budgets and list who may touch whom: starts (n + 1,), others (p,).

    Each ball's others are in ascending order, so nothing depends on the order within a cell.
    """
    found, count, reach = find_pairs(bodies, n, horizon, gravity)
    ends = np.empty(n + 1, np.int32)
    loose = np.empty(count, np.int32)
    _by_owner(n, found, count, ends, loose)
    starts = np.empty(n + 1, np.int32)
    room = count + n + 64
    while True:
        other = np.empty(room, np.int32)
        seen = np.full(statics.items.shape[0], -1, np.int32)
        length = _list_all(bodies, n, statics, reach, ends, loose, seen, starts, other)
        if length <= room:
            return starts, other[:length].copy()
        room = length


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
