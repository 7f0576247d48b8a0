"""The list of who may touch whom: pairs in order, with the impulses of the list before."""

import numpy as np

from engine.jit.decorator import kernel, lean_kernel
from engine.multibody.solver.broad_phase import ROWS, find_pairs
from engine.multibody.solver.layout import (
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
from engine.multibody.solver.narrow_phase import nearest


@lean_kernel
def _sort(values: Ints, first: int, last: int) -> None:
    """Ascending order of a stretch, a short one: items near a ball."""
    for k in range(first + 1, last):
        value = values[k]
        m = k
        while m > first and values[m - 1] > value:
            values[m] = values[m - 1]
            m -= 1
        values[m] = value


@lean_kernel
def _list_items(
    x: float, y: float, reach: float, a: int, statics: Statics, seen: Ints, other: Ints, count: int
) -> int:
    """Append the fixed things within `reach` of ball `a` at (x, y), as -1 - item."""
    scale = statics.cells_per_metre
    items = statics.items
    starts = statics.starts
    members = statics.members
    room = len(other)
    low = max(np.floor((x - reach - statics.x0) * scale), 0.0)
    high = min(np.floor((x + reach - statics.x0) * scale), statics.columns - 1.0)
    top = max(np.floor((y - reach - statics.y0) * scale), 0.0)
    bottom = min(np.floor((y + reach - statics.y0) * scale), statics.rows - 1.0)
    if low <= high and top <= bottom:
        for row in range(int(top), int(bottom) + 1):
            cell = row * statics.columns
            first = starts[cell + int(low)]
            last = starts[cell + int(high) + 1]
            for k in range(first, last):  # cells side by side are listed one after the other
                item = members[k]
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
def _by_column(found: Counts, count: int, column: int, ends: Ints) -> None:
    """Where the rows of each ball in a column of `found` begin, were they sorted: ends[ball]."""
    ends[:] = 0
    for m in range(count):
        ends[(found[m, column] & (ROWS - 1)) + 1] += 1
    for a in range(len(ends) - 1):
        ends[a + 1] += ends[a]


@lean_kernel
def _by_owner(found: Counts, count: int, order: Ints, ends: Ints, loose: Ints) -> None:
    """Put the others of each ball's pairs, ascending, into a stretch of `loose`, from the end of
    the ball before to ends[ball].

    Ordered by the other first and then by the owner, without a comparison: the processor would
    guess half of them badly.
    """
    _by_column(found, count, 1, ends)
    for m in range(count):
        b = found[m, 1] & (ROWS - 1)
        order[ends[b]] = m
        ends[b] += 1
    _by_column(found, count, 0, ends)
    for k in range(count):
        m = order[k]
        a = found[m, 0] & (ROWS - 1)
        loose[ends[a]] = found[m, 1] & (ROWS - 1)
        ends[a] += 1


@lean_kernel
def _list_all(
    bodies: Bodies, n: int, statics: Statics, reach: Floats, ends: Ints, loose: Ints, seen: Ints,
    starts: Ints, owner: Ints, other: Ints,
) -> int:  # fmt: skip
    """Fill `starts`, `owner` and `other`, each ball's others ascending, then what is fixed; the
    length of the list, or more than the room in `other`, where that is too small."""
    pos = bodies.pos
    marks = bodies.marks
    room = len(other)
    count = 0
    first = 0
    for a in range(n):
        starts[a] = count
        if marks[a, FLAGS] & (ASLEEP | GONE):
            continue
        last = ends[a]
        for m in range(first, last):
            if m == first or loose[m] != loose[m - 1]:
                row = min(count, room - 1)
                owner[row] = a
                other[row] = loose[m]
                count += 1
        first = last
        fixed = count
        count = _list_items(pos[a, X], pos[a, Y], reach[a], a, statics, seen, other, count)
        _sort(other, fixed, min(count, room))
        for k in range(fixed, min(count, room)):
            owner[k] = a
    starts[n] = count
    return count


@kernel
def list_pairs(
    bodies: Bodies, n: int, statics: Statics, horizon: float, gravity: float
) -> tuple[Ints, Ints, Ints]:
    """Give out budgets and list who may touch whom: starts (n + 1,), owners and others (p,).

    Each ball's others are in ascending order, so nothing depends on the order within a cell.
    """
    found, count, reach = find_pairs(bodies, n, horizon, gravity)
    ends = np.empty(n + 1, np.int32)
    loose = np.empty(count, np.int32)
    _by_owner(found, count, np.empty(count, np.int32), ends, loose)
    starts = np.empty(n + 1, np.int32)
    room = count + n + 64
    while True:
        owner = np.empty(room, np.int32)
        other = np.empty(room, np.int32)
        seen = np.full(len(statics.items), -1, np.int32)
        length = _list_all(bodies, n, statics, reach, ends, loose, seen, starts, owner, other)
        if length <= room:
            return starts, owner[:length], other[:length].copy()
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
    for a in range(len(starts) - 1):
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
def _list_near(starts: Ints, owner: Ints, other: Ints, near_starts: Ints, near: Ints) -> None:
    """Who may touch each ball, whoever owns the pair: from near_starts[ball] to the next."""
    n = len(starts) - 1
    for a in range(n):
        near_starts[a + 2] = starts[a + 1] - starts[a]
    for k in range(len(other)):
        if other[k] >= 0:
            near_starts[other[k] + 2] += 1
    for b in range(n):
        near_starts[b + 2] += near_starts[b + 1]
    for k in range(len(other)):
        a = owner[k]
        b = other[k]
        near[near_starts[a + 1]] = b
        near_starts[a + 1] += 1
        if b >= 0:
            near[near_starts[b + 1]] = a
            near_starts[b + 1] += 1


@kernel
def renew(
    bodies: Bodies, n: int, statics: Statics, old: Pairs, horizon: float, gravity: float
) -> tuple[Pairs, Ints]:
    """A new list of pairs that takes over the impulses of the old one, and who owns each pair."""
    starts, owner, other = list_pairs(bodies, n, statics, horizon, gravity)
    items = 0
    for k in range(len(other)):
        items += int(other[k] < 0)
    impulse = np.zeros((len(other), 2))
    _take_over(old, starts, other, impulse)
    near_starts = np.zeros(n + 2, np.int32)
    near = np.empty(2 * len(other) - items, np.int32)
    _list_near(starts, owner, other, near_starts, near)
    return Pairs(starts, other, impulse, near_starts[: n + 1], near), owner


@kernel
def owners(pairs: Pairs) -> Ints:
    """Who owns each pair, shape (p,)."""
    starts = pairs.starts
    owner = np.empty(len(pairs.other), np.int32)
    for a in range(len(starts) - 1):
        for k in range(starts[a], starts[a + 1]):
            owner[k] = a
    return owner
