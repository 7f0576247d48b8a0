"""Builds the neighbour list: the pairs that may touch before the next rebuild, with their impulses.

It is a Verlet list (Verlet, Phys. Rev. 1967), valid as long as no ball is farther than its margin
from its anchor, its place at the last rebuild. A new list takes over the impulses of the old one
for the warm start. Pairs of sleepers are not listed; their impulses are held until they wake, so
that a pile wakes with the forces with which it fell asleep.
"""

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, kernel, lean_kernel
from plinko.engine.multibody.solver.broad_phase import ROWS, find_pairs
from plinko.engine.multibody.solver.layout import body, pair, shape
from plinko.engine.multibody.solver.layout.array_types import Counts, Floats, Ints
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.pair import NeighbourList
from plinko.engine.multibody.solver.layout.shape import StaticShapes
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.multibody.solver.narrow_phase import from_closest_point


@lean_kernel
def _sort(values: Ints, first: int, last: int) -> None:
    """Sort values[first:last] in place; insertion sort, because a ball has few items near it."""
    for k in range(first + 1, last):
        value = values[k]
        m = k
        while m > first and values[m - 1] > value:
            values[m] = values[m - 1]
            m -= 1
        values[m] = value


@lean_kernel
def _list_items(
    x: float, y: float, disc_radius: float, a: int, statics: StaticShapes, seen: Ints, other: Ints,
    count: int,
) -> int:  # fmt: skip
    """Append the static items within `disc_radius` of ball `a` at (x, y), as -1 - item.

    seen (items,): the last ball for which each item was tested, because an item is in several
    cells. Returns the number of rows, which may exceed the room in `other`.
    """
    scale = statics.cells_per_metre
    items = statics.items
    starts = statics.starts
    members = statics.members
    room = len(other)
    low = max(np.floor((x - disc_radius - statics.x0) * scale), 0.0)
    high = min(np.floor((x + disc_radius - statics.x0) * scale), statics.columns - 1.0)
    top = max(np.floor((y - disc_radius - statics.y0) * scale), 0.0)
    bottom = min(np.floor((y + disc_radius - statics.y0) * scale), statics.rows - 1.0)
    if low <= high and top <= bottom:
        for row in range(int(top), int(bottom) + 1):
            cell = row * statics.columns
            first = starts[cell + int(low)]
            last = starts[cell + int(high) + 1]
            for k in range(first, last):  # the members of a row's cells are consecutive
                item = members[k]
                if seen[item] == a:
                    continue
                seen[item] = a
                dx, dy = from_closest_point(items, item, x, y)
                most = disc_radius + items[item, shape.RADIUS]
                if dx * dx + dy * dy <= most * most:
                    if count < room:
                        other[count] = -1 - item
                    count += 1
    return count


@lean_kernel
def _count_by_column(found: Counts, count: int, column: int, ends: Ints) -> None:
    """Set ends[ball] to the index of the ball's first row if `found` were sorted by `column`."""
    ends[:] = 0
    for m in range(count):
        ends[(found[m, column] & (ROWS - 1)) + 1] += 1
    for a in range(len(ends) - 1):
        ends[a + 1] += ends[a]


@lean_kernel
def _sort_by_owner(found: Counts, count: int, order: Ints, ends: Ints, others: Ints) -> None:
    """Sort the pairs by owner and other: ball a's others end before others[ends[a]], and begin
    where those of ball a - 1 end.

    This is a radix sort, by the other first and then by the owner. It needs no comparisons, about
    half of which the processor would mispredict.
    """
    _count_by_column(found, count, 1, ends)
    for m in range(count):
        b = found[m, 1] & (ROWS - 1)
        order[ends[b]] = m
        ends[b] += 1
    _count_by_column(found, count, 0, ends)
    for k in range(count):
        m = order[k]
        a = found[m, 0] & (ROWS - 1)
        others[ends[a]] = found[m, 1] & (ROWS - 1)
        ends[a] += 1


@lean_kernel
def _list_all(
    bodies: Bodies, n: int, statics: StaticShapes, disc_radius: Floats, ends: Ints, others: Ints,
    seen: Ints, starts: Ints, owner: Ints, other: Ints,
) -> int:  # fmt: skip
    """Fill `starts`, `owner` and `other`: for each ball its other balls, then its static items.

    Returns the length of the list, or a number larger than the room in `other` if that is too
    small.
    """
    pos = bodies.pos
    marks = bodies.marks
    room = len(other)
    count = 0
    first = 0
    for a in range(n):
        starts[a] = count
        if marks[a, body.FLAGS] & (body.ASLEEP | body.GONE):
            continue
        last = ends[a]
        for m in range(first, last):
            if m == first or others[m] != others[m - 1]:
                row = min(count, room - 1)
                owner[row] = a
                other[row] = others[m]
                count += 1
        first = last
        fixed = count
        x = pos[a, body.X]
        y = pos[a, body.Y]
        count = _list_items(x, y, disc_radius[a], a, statics, seen, other, count)
        _sort(other, fixed, min(count, room))
        for k in range(fixed, min(count, room)):
            owner[k] = a
    starts[n] = count
    return count


@inner_kernel
def list_pairs(
    bodies: Bodies, n: int, statics: StaticShapes, settings: SolverSettings
) -> tuple[Ints, Ints, Ints]:
    """Set margins and list the pairs that may touch: starts (n + 1,), owners and others (p,).

    Each ball's others are sorted, so no result depends on the order of balls within a cell.
    """
    found, count, disc_radius = find_pairs(bodies, n, settings)
    ends = np.empty(n + 1, np.int32)
    others = np.empty(count, np.int32)
    _sort_by_owner(found, count, np.empty(count, np.int32), ends, others)
    starts = np.empty(n + 1, np.int32)
    room = count + n + 64
    while True:
        owner = np.empty(room, np.int32)
        other = np.empty(room, np.int32)
        seen = np.full(len(statics.items), -1, np.int32)
        length = _list_all(
            bodies, n, statics, disc_radius, ends, others, seen, starts, owner, other
        )
        if length <= room:
            return starts, owner[:length], other[:length].copy()
        room = length


@lean_kernel
def _find(starts: Ints, other: Ints, a: int, b: int) -> int:
    """Row of the pair (a, b) among those that `a` owns, or -1."""
    found = -1
    for k in range(starts[a], starts[a + 1]):
        if other[k] == b:
            found = k
            break
    return found


@lean_kernel
def _carry_over_impulses(
    old_starts: Ints, old_other: Ints, old_impulse: Floats, starts: Ints, other: Ints,
    impulse: Floats,
) -> None:  # fmt: skip
    """Copy the impulses of the old list's pairs that the new list has too."""
    for a in range(len(starts) - 1):
        for was in range(old_starts[a], old_starts[a + 1]):
            if old_impulse[was, pair.NORMAL] == 0.0:
                continue
            b = old_other[was]
            torque = old_impulse[was, pair.TORQUE]
            k = _find(starts, other, a, b)
            if k < 0 and b >= 0:
                k = _find(starts, other, b, a)
                torque = -torque  # it acts on the owner
            if k >= 0:
                impulse[k, pair.NORMAL] = old_impulse[was, pair.NORMAL]
                impulse[k, pair.TANGENT] = old_impulse[was, pair.TANGENT]
                impulse[k, pair.TORQUE] = torque


@lean_kernel
def _hold_impulses(
    marks: Ints, a: int, starts: Ints, other: Ints, impulse: Floats, held_other: Ints,
    held_impulse: Floats, count: int,
) -> int:  # fmt: skip
    """Append a sleeping ball's pairs with an impulse whose other ball sleeps too, or is fixed."""
    for k in range(starts[a], starts[a + 1]):
        b = other[k]
        if impulse[k, pair.NORMAL] != 0.0 and (b < 0 or marks[b, body.FLAGS] & body.ASLEEP):
            held_other[count] = b
            held_impulse[count, pair.NORMAL] = impulse[k, pair.NORMAL]
            held_impulse[count, pair.TANGENT] = impulse[k, pair.TANGENT]
            held_impulse[count, pair.TORQUE] = impulse[k, pair.TORQUE]
            count += 1
    return count


@inner_kernel
def _hold_all(marks: Ints, n: int, old: NeighbourList) -> tuple[Ints, Ints, Floats]:
    """The pairs of sleepers, from the old list and from those that it held: see `NeighbourList`."""
    starts = np.zeros(n + 1, np.int32)
    asleep = 0
    for a in range(n):
        asleep += int(marks[a, body.FLAGS] & body.ASLEEP != 0)
    room = len(old.other) + len(old.held_other) if asleep > 0 else 0
    other = np.empty(room, np.int32)
    impulse = np.empty((room, 3))
    count = 0
    for a in range(n):
        if marks[a, body.FLAGS] & body.ASLEEP:
            count = _hold_impulses(
                marks, a, old.starts, old.other, old.impulse, other, impulse, count
            )
            count = _hold_impulses(
                marks, a, old.held_starts, old.held_other, old.held_impulse, other, impulse, count
            )
        starts[a + 1] = count
    return starts, other[:count].copy(), impulse[:count].copy()


@lean_kernel
def _list_neighbours(
    starts: Ints, owner: Ints, other: Ints, neighbour_starts: Ints, neighbours: Ints
) -> None:
    """List each ball's neighbours in all its pairs, owned or not; see `NeighbourList`."""
    n = len(starts) - 1
    for a in range(n):
        neighbour_starts[a + 2] = starts[a + 1] - starts[a]
    for k in range(len(other)):
        if other[k] >= 0:
            neighbour_starts[other[k] + 2] += 1
    for b in range(n):
        neighbour_starts[b + 2] += neighbour_starts[b + 1]
    for k in range(len(other)):
        a = owner[k]
        b = other[k]
        neighbours[neighbour_starts[a + 1]] = b
        neighbour_starts[a + 1] += 1
        if b >= 0:
            neighbours[neighbour_starts[b + 1]] = a
            neighbour_starts[b + 1] += 1


@kernel
def rebuild(
    bodies: Bodies, n: int, statics: StaticShapes, old: NeighbourList, settings: SolverSettings
) -> tuple[NeighbourList, Ints]:
    """Return a new neighbour list with the impulses of the old one, and the owner of each pair."""
    starts, owner, other = list_pairs(bodies, n, statics, settings)
    fixed = 0
    for k in range(len(other)):
        fixed += int(other[k] < 0)
    impulse = np.zeros((len(other), 3))
    _carry_over_impulses(old.starts, old.other, old.impulse, starts, other, impulse)
    _carry_over_impulses(old.held_starts, old.held_other, old.held_impulse, starts, other, impulse)
    neighbour_starts = np.zeros(n + 2, np.int32)
    neighbours = np.empty(2 * len(other) - fixed, np.int32)
    _list_neighbours(starts, owner, other, neighbour_starts, neighbours)
    held_starts, held_other, held_impulse = _hold_all(bodies.marks, n, old)
    pairs = NeighbourList(
        starts, other, impulse, neighbour_starts[: n + 1], neighbours,
        held_starts, held_other, held_impulse,
    )  # fmt: skip
    return pairs, owner


@inner_kernel
def owners(pairs: NeighbourList) -> Ints:
    """The owner of each pair, shape (p,)."""
    starts = pairs.starts
    owner = np.empty(len(pairs.other), np.int32)
    for a in range(len(starts) - 1):
        for k in range(starts[a], starts[a + 1]):
            owner[k] = a
    return owner


@inner_kernel
def _select(
    starts: Ints, other: Ints, impulse: Floats, target: Ints, n: int
) -> tuple[Ints, Ints, Floats]:
    """The pairs between the n balls that remain; target: as in `select_pairs`."""
    new_starts = np.zeros(n + 1, np.int32)
    for row in range(len(target)):
        if target[row] >= 0:
            for k in range(starts[row], starts[row + 1]):
                if other[k] < 0 or target[other[k]] >= 0:
                    new_starts[target[row] + 1] += 1
    for row in range(n):
        new_starts[row + 1] += new_starts[row]
    new_other = np.empty(new_starts[n], np.int32)
    new_impulse = np.empty((new_starts[n], 3))
    for row in range(len(target)):
        if target[row] >= 0:
            at = new_starts[target[row]]
            for k in range(starts[row], starts[row + 1]):
                partner = other[k]
                if partner < 0 or target[partner] >= 0:
                    new_other[at] = partner if partner < 0 else target[partner]
                    new_impulse[at, pair.NORMAL] = impulse[k, pair.NORMAL]
                    new_impulse[at, pair.TANGENT] = impulse[k, pair.TANGENT]
                    new_impulse[at, pair.TORQUE] = impulse[k, pair.TORQUE]
                    at += 1
    return new_starts, new_other, new_impulse


@kernel
def select_pairs(pairs: NeighbourList, target: Ints, n: int) -> NeighbourList:
    """The pairs between the n balls that remain; their impulses start the next list.

    target: the new row of each old one, -1 if removed. The result lists no neighbours.
    """
    starts, other, impulse = _select(pairs.starts, pairs.other, pairs.impulse, target, n)
    held_starts, held_other, held_impulse = _select(
        pairs.held_starts, pairs.held_other, pairs.held_impulse, target, n
    )
    return NeighbourList(
        starts, other, impulse, np.zeros(n + 1, np.int32), np.empty(0, np.int32),
        held_starts, held_other, held_impulse,
    )  # fmt: skip
