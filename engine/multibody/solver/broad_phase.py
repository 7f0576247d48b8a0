"""Which balls may touch each other: levels of hash grids over balls of all sizes.

A ball reaches as far as its radius and its budget, the way it may go before the list is made anew.
It lies in one cell of the level whose cells are at least as large as its reach. On its level it
looks ahead only, so each pair is seen once; on another, in all cells that its reach and the longest
of that level cover. The smaller ball looks for the larger, unless these are few, and owns the pair,
so a ratio of sizes of a thousand costs a few levels more, not a search through all.
"""

from math import sqrt

import numpy as np

from engine.jit.decorator import kernel, lean_kernel
from engine.multibody.solver.layout import (
    ASLEEP,
    BUDGET,
    FLAGS,
    GONE,
    HOME_X,
    HOME_Y,
    RADIUS,
    VX,
    VY,
    Bodies,
    Counts,
    Floats,
    Ints,
    X,
    Y,
)

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

SLEEPERS = ROWS * LEVELS
"""The rank from which on balls sleep."""

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
def _levels(
    bodies: Bodies, n: int, reach: Floats, level: Ints, per_level: Ints, farthest: Floats
) -> tuple[float, int]:
    """Each ball's reach and level, the number of balls and the longest reach on each level; the
    size of the least cells, and how many levels there are.

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
    farthest[:] = 0.0
    per_level[:] = 0
    levels = 1
    for i in range(n):
        size = smallest
        k = 0
        while size < reach[i] and k < LEVELS - 1:
            size *= 2.0
            k += 1
        level[i] = k
        levels = max(levels, k + 1)
        per_level[k] += 1
        farthest[k] = max(farthest[k], reach[i])
    return smallest, levels


@lean_kernel
def _bucket(cx: int, cy: int, level: int, mask: int) -> int:
    """Cells side by side are in buckets side by side: a row of them is one stretch."""
    return int((cx + cy * PRIME_Y + level * PRIME_LEVEL) & mask)


@lean_kernel
def _fill_buckets(
    bodies: Bodies, n: int, reach: Floats, level: Ints, smallest: float, cells: Ints,
    firsts: Ints, spots: Floats, ranks: Counts,
) -> int:  # fmt: skip
    """Where the balls of each bucket are, ascending, from firsts[bucket] to the next; how many.

    `cells` (n, 3) gets each ball's column, row and bucket, `spots` (n, 3) x, y and reach in m,
    `ranks` (n,) a number that grows with level and row; of a sleeper, which all others own their
    pairs with, one above all others.
    """
    pos = bodies.pos
    marks = bodies.marks
    mask = len(firsts) - 3
    for i in range(n):
        if marks[i, FLAGS] & GONE:
            continue
        over = 1.0 / smallest
        for _ in range(level[i]):
            over *= 0.5
        cx = int(np.floor(pos[i, X] * over))
        cy = int(np.floor(pos[i, Y] * over))
        bucket = _bucket(cx, cy, int(level[i]), mask)
        cells[i, 0] = cx
        cells[i, 1] = cy
        cells[i, 2] = bucket
        firsts[bucket + 2] += 1
    for b in range(mask + 1):
        firsts[b + 2] += firsts[b + 1]
    for i in range(n):
        if marks[i, FLAGS] & GONE == 0:
            bucket = cells[i, 2]
            m = firsts[bucket + 1]
            firsts[bucket + 1] = m + 1
            spots[m, 0] = pos[i, X]
            spots[m, 1] = pos[i, Y]
            spots[m, 2] = reach[i]
            ranks[m] = i + (SLEEPERS if marks[i, FLAGS] & ASLEEP else ROWS * int(level[i]))
    return int(firsts[mask + 1])


@lean_kernel
def _look_through(
    x: float, y: float, reach: float, rank: int, low: int, high: int, spots: Floats,
    ranks: Counts, found: Counts, count: int,
) -> int:  # fmt: skip
    """Append the pairs with the others of a stretch that are near, unless both sleep; the length.

    `found` (p, 2) gets the lower rank and the higher. What does not fit is counted only. No branch
    depends on where the balls are: half of such guesses of the processor would be wrong, which
    costs more than to write what is overwritten.
    """
    last = len(found) - 1
    for m in range(low, high):
        dx = x - spots[m, 0]
        dy = y - spots[m, 1]
        most = reach + spots[m, 2]
        foe = ranks[m]
        owner = rank if rank < foe else foe
        row = count if count < last else last
        found[row, 0] = owner
        found[row, 1] = rank if rank > foe else foe
        is_pair = (dx * dx + dy * dy <= most * most) & (owner < SLEEPERS) & (rank != foe)
        count += int(is_pair)
    return count


@lean_kernel
def _look_along(
    x: float, y: float, reach: float, rank: int, first: int, columns: int, firsts: Ints,
    spots: Floats, ranks: Counts, found: Counts, count: int,
) -> int:  # fmt: skip
    """`_look_through` for so many cells of a row, which begins with the bucket `first`."""
    room = len(firsts) - 2
    end = first + columns
    count = _look_through(
        x, y, reach, rank, firsts[first], firsts[min(end, room)], spots, ranks, found, count
    )
    if end > room:  # the row goes on at the first bucket
        count = _look_through(
            x, y, reach, rank, 0, firsts[min(end - room, first)], spots, ranks, found, count
        )
    return count


@lean_kernel
def _look_on_level(
    x: float, y: float, reach: float, rank: int, level: int, over: float, farthest: float,
    firsts: Ints, spots: Floats, ranks: Counts, found: Counts, count: int,
) -> int:  # fmt: skip
    """Append the pairs of a ball with all those near it on another level, some perhaps twice."""
    room = len(firsts) - 2
    rim = reach + farthest
    cx = int(np.floor((x - rim) * over))
    cy = int(np.floor((y - rim) * over))
    columns = int(np.floor((x + rim) * over)) - cx + 1
    rows = int(np.floor((y + rim) * over)) - cy + 1
    if columns * rows > max(25, firsts[room]):  # there are fewer balls than cells
        return _look_through(x, y, reach, rank, 0, int(firsts[room]), spots, ranks, found, count)
    for row in range(rows):
        count = _look_along(
            x, y, reach, rank, _bucket(cx, cy + row, level, room - 1), columns, firsts, spots,
            ranks, found, count,
        )  # fmt: skip
    return count


@lean_kernel
def _look_ahead(
    m: int, level: int, over: float, farthest: float, cells: Ints, firsts: Ints, spots: Floats,
    ranks: Counts, found: Counts, count: int,
) -> int:  # fmt: skip
    """Append the pairs of the ball at a spot with those near it on its level that are in its cell
    after it, in its row's next cells or in the rows below: so each pair is found once."""
    room = len(firsts) - 2
    x = spots[m, 0]
    y = spots[m, 1]
    reach = spots[m, 2]
    rank = ranks[m]
    i = rank & (ROWS - 1)
    rim = reach + farthest
    right = int(np.floor((x + rim) * over))
    left = int(np.floor((x - rim) * over))
    rows = int(np.floor((y + rim) * over)) - cells[i, 1]
    first = cells[i, 2]
    end = first + right - cells[i, 0] + 1
    count = _look_through(
        x, y, reach, rank, m + 1, firsts[min(end, room)], spots, ranks, found, count
    )
    if end > room:
        count = _look_through(
            x, y, reach, rank, 0, firsts[min(end - room, first)], spots, ranks, found, count
        )
    for row in range(1, rows + 1):
        count = _look_along(
            x, y, reach, rank, _bucket(left, cells[i, 1] + row, level, room - 1),
            right - left + 1, firsts, spots, ranks, found, count,
        )  # fmt: skip
    return count


@lean_kernel
def _look_around(
    total: int, level: Ints, per_level: Ints, farthest: Floats, smallest: float, cells: Ints,
    firsts: Ints, spots: Floats, ranks: Counts, found: Counts,
) -> int:  # fmt: skip
    """Fill `found` with all pairs of balls that may touch, some perhaps twice; how many.

    Of two levels the balls of one are looked for around those of the other: around the smaller
    ones, or around the larger if these are few and the cells around them not many.
    """
    count = 0
    for m in range(total):
        i = ranks[m] & (ROWS - 1)
        mine = level[i]
        over = 1.0 / smallest
        for k in range(len(farthest)):
            if k == mine:
                count = _look_ahead(
                    m, k, over, farthest[k], cells, firsts, spots, ranks, found, count
                )
            elif farthest[k] > 0.0:
                low = min(k, mine)
                high = max(k, mine)
                by_large = high - low <= 2 and 2 * per_level[high] < per_level[low]
                if by_large == (mine > k):
                    count = _look_on_level(
                        spots[m, 0], spots[m, 1], spots[m, 2], ranks[m], k, over, farthest[k],
                        firsts, spots, ranks, found, count,
                    )  # fmt: skip
            over *= 0.5
    return count


@kernel
def find_pairs(
    bodies: Bodies, n: int, horizon: float, gravity: float
) -> tuple[Counts, int, Floats]:
    """Give out budgets and find the pairs of balls that may touch: ranks of owner and other in the
    rows of an array, some perhaps twice, in any order; how many rows; each ball's reach in m."""
    buckets = 16
    while buckets < 2 * n:
        buckets *= 2
    reach = np.empty(n)
    level = np.empty(n, np.int32)
    cells = np.empty((n, 3), np.int32)
    spots = np.empty((n, 3))
    ranks = np.empty(n, np.int64)
    found = np.empty((4 * n + 64, 2), np.int64)
    farthest = np.empty(LEVELS)
    per_level = np.empty(LEVELS, np.int32)
    firsts = np.empty(buckets + 2, np.int32)
    scale = 1.0
    while True:
        set_budgets(bodies, n, horizon, gravity, scale)
        firsts[:] = 0
        smallest, levels = _levels(bodies, n, reach, level, per_level, farthest)
        total = _fill_buckets(bodies, n, reach, level, smallest, cells, firsts, spots, ranks)
        limit = PAIRS_PER_BALL * n + 4096 if scale > 1.0e-6 else 2147483647
        count = _look_around(
            total, level, per_level, farthest[:levels], smallest, cells, firsts, spots, ranks, found
        )
        if count > limit:
            scale *= 0.5
            continue
        if count < len(found):  # the row after the last is written to
            return found, count, reach
        found = np.empty((count + 1, 2), np.int64)


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
