"""Broad phase: finds the balls that may touch each other, with a hierarchical hash grid.

Each ball is represented by a disc with its radius plus its margin, the distance that it may move
before the neighbour list is rebuilt. The disc is in one cell of the lowest level whose cells are at
least as large as its radius.

On its own level, a disc is only compared with those after it, so each pair is found once. On
another level it searches all cells within its radius plus the largest radius of that level. Of two
levels the smaller balls search for the larger, unless those are few; the smaller ball owns the
pair. So a size ratio of a thousand costs a few more levels, and not a search through all balls.

Ericson, Real-Time Collision Detection (2005), 7.2; the hash: Teschner et al., VMV 2003.
"""

from math import sqrt

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, kernel, lean_kernel
from plinko.engine.multibody.solver.layout import body, hash_grid
from plinko.engine.multibody.solver.layout.array_types import Counts, Floats
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.hash_grid import HashGrid
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings

# Multipliers of the prime hash of Teschner et al., VMV 2003.
PRIME_Y = 19349663
PRIME_LEVEL = 83492791

REST_MARGIN = 0.25
"""Margin of a ball at rest, in radii. With a smaller one the neighbour list is rebuilt more often;
with a larger one it is longer."""

CELL = 1.25
"""Size of the smallest cells, in harmonic means of the discs' radii. With half the size a ball
searches more cells; with twice the size each cell has more balls; at 1, most balls would be
distributed over two levels."""

ROWS = 1 << 32
"""More than the possible number of balls. The rank of an awake ball is ROWS * level + row."""

LEVELS = 48

SLEEPERS = ROWS * LEVELS
"""Added to the row, this is the rank of a sleeping ball, above those of all awake balls."""

PAIRS_PER_BALL = 64
"""If there are more pairs per ball, they are searched again, with half the part of the margins that
depends on speed."""


@lean_kernel
def _typical_speed(bodies: Bodies, n: int) -> float:
    """A mean speed of the awake balls, m/s: the square of the mean square root.

    A few fast balls affect it less than the arithmetic mean.
    """
    vel = bodies.vel
    marks = bodies.marks
    total = 0.0
    count = 0
    for i in range(n):
        if marks[i, body.FLAGS] & (body.ASLEEP | body.GONE) == 0:
            vx = vel[i, body.VX]
            vy = vel[i, body.VY]
            total += sqrt(sqrt(vx * vx + vy * vy))
            count += 1
    if count == 0:
        return 0.0
    return (total / count) * (total / count)


@lean_kernel
def _set_margins(bodies: Bodies, n: int, settings: SolverSettings, scale: float) -> None:
    """Set each ball's anchor to its place, and its margin to the distance that it will probably
    move within a step; scale: factor of the part that depends on speed."""
    horizon = settings.h * settings.substeps
    anchor = bodies.anchor
    pos = bodies.pos
    vel = bodies.vel
    marks = bodies.marks
    typical = 1.5 * _typical_speed(bodies, n)
    for i in range(n):
        anchor[i, body.ANCHOR_X] = pos[i, body.X]
        anchor[i, body.ANCHOR_Y] = pos[i, body.Y]
        if marks[i, body.FLAGS] & body.ASLEEP:
            anchor[i, body.MARGIN] = 0.0
            continue
        vx = vel[i, body.VX]
        vy = vel[i, body.VY]
        speed = max(1.25 * sqrt(vx * vx + vy * vy), typical) + settings.gravity * horizon
        anchor[i, body.MARGIN] = REST_MARGIN * pos[i, body.RADIUS] + scale * speed * horizon


@lean_kernel
def beyond_margin(bodies: Bodies, n: int, remaining: float) -> bool:
    """Whether any ball would leave its margin within `remaining` seconds at its velocity."""
    pos = bodies.pos
    vel = bodies.vel
    anchor = bodies.anchor
    for i in range(n):
        if bodies.marks[i, body.FLAGS] & (body.ASLEEP | body.GONE):
            continue
        dx = pos[i, body.X] + vel[i, body.VX] * remaining - anchor[i, body.ANCHOR_X]
        dy = pos[i, body.Y] + vel[i, body.VY] * remaining - anchor[i, body.ANCHOR_Y]
        if not dx * dx + dy * dy <= anchor[i, body.MARGIN] * anchor[i, body.MARGIN]:
            return True
    return False


@inner_kernel
def _new_grid(n: int) -> HashGrid:
    """An empty grid with room for n balls, and at least two buckets per ball."""
    buckets = 16
    while buckets < 2 * n:
        buckets *= 2
    return HashGrid(
        np.empty(n, np.int32),
        np.empty((n, hash_grid.CELL_COLUMNS), np.int64),
        np.empty(LEVELS),
        np.empty(LEVELS, np.int32),
        np.empty(LEVELS),
        np.empty(buckets + 2, np.int32),
        np.empty((n, hash_grid.DISC_COLUMNS)),
        np.empty(n, np.int64),
    )


@kernel
def smallest_cell(bodies: Bodies, n: int, chosen: float) -> float:
    """The size of the smallest cells in m: the chosen one, or 0 to size them by the discs' radii.

    The harmonic mean puts most balls on one level, and if sizes vary, the small balls do not crowd
    in the cells of the large ones.
    """
    if chosen > 0.0:
        return chosen
    total = 0.0
    for i in range(n):
        total += 1.0 / (bodies.pos[i, body.RADIUS] + bodies.anchor[i, body.MARGIN])
    return CELL * n / total


@lean_kernel
def _set_levels(bodies: Bodies, n: int, chosen: float, grid: HashGrid, disc_radius: Floats) -> int:
    """Compute each disc's radius and level, and the levels' data; return the number of levels."""
    for i in range(n):
        disc_radius[i] = bodies.pos[i, body.RADIUS] + bodies.anchor[i, body.MARGIN]
    smallest = smallest_cell(bodies, n, chosen)
    grid.cells_per_metre[0] = 1.0 / smallest
    for k in range(1, LEVELS):
        grid.cells_per_metre[k] = 0.5 * grid.cells_per_metre[k - 1]
    grid.largest[:] = 0.0
    grid.population[:] = 0
    levels = 1
    for i in range(n):
        size = smallest
        k = 0
        while size < disc_radius[i] and k < LEVELS - 1:
            size *= 2.0
            k += 1
        grid.level[i] = k
        levels = max(levels, k + 1)
        grid.population[k] += 1
        grid.largest[k] = max(grid.largest[k], disc_radius[i])
    return levels


@lean_kernel
def _bucket(cx: int, cy: int, level: int, mask: int) -> int:
    """The bucket of a cell. Neighbouring cells of a row are in consecutive buckets."""
    return int((cx + cy * PRIME_Y + level * PRIME_LEVEL) & mask)


@lean_kernel
def _fill_buckets(bodies: Bodies, n: int, grid: HashGrid, disc_radius: Floats) -> int:
    """Sort the discs of all balls that are not gone by bucket; return their number.

    Sleepers get the highest ranks, so that the awake ball of a pair owns it.
    """
    pos = bodies.pos
    marks = bodies.marks
    cells = grid.cells
    level = grid.level
    bucket_starts = grid.bucket_starts
    discs = grid.discs
    mask = len(bucket_starts) - 3
    bucket_starts[:] = 0
    for i in range(n):
        if marks[i, body.FLAGS] & body.GONE:
            continue
        per_metre = grid.cells_per_metre[level[i]]
        cx = int(np.floor(pos[i, body.X] * per_metre))
        cy = int(np.floor(pos[i, body.Y] * per_metre))
        bucket = _bucket(cx, cy, int(level[i]), mask)
        cells[i, hash_grid.CELL_X] = cx
        cells[i, hash_grid.CELL_Y] = cy
        cells[i, hash_grid.BUCKET] = bucket
        bucket_starts[bucket + 2] += 1
    for b in range(mask + 1):
        bucket_starts[b + 2] += bucket_starts[b + 1]
    for i in range(n):
        if marks[i, body.FLAGS] & body.GONE == 0:
            bucket = cells[i, hash_grid.BUCKET]
            m = bucket_starts[bucket + 1]
            bucket_starts[bucket + 1] = m + 1
            discs[m, hash_grid.X] = pos[i, body.X]
            discs[m, hash_grid.Y] = pos[i, body.Y]
            discs[m, hash_grid.RADIUS] = disc_radius[i]
            is_asleep = marks[i, body.FLAGS] & body.ASLEEP
            grid.ranks[m] = i + (SLEEPERS if is_asleep else ROWS * int(level[i]))
    return int(bucket_starts[mask + 1])


@lean_kernel
def _test_range(
    grid: HashGrid, x: float, y: float, radius: float, rank: int, low: int, high: int,
    found: Counts, count: int,
) -> int:  # fmt: skip
    """Append the pairs of a disc with those discs from `low` to `high` - 1 that it overlaps.

    Pairs of two sleepers are left out. found (p, 2) gets the lower rank, then the higher; pairs
    without room are only counted. Returns the number of pairs.

    No branch depends on the places of balls. The processor would mispredict about half of such
    branches, which costs more than writing every row and overwriting it if it is not a pair.
    """
    discs = grid.discs
    ranks = grid.ranks
    last = len(found) - 1
    for m in range(low, high):
        dx = x - discs[m, hash_grid.X]
        dy = y - discs[m, hash_grid.Y]
        most = radius + discs[m, hash_grid.RADIUS]
        other_rank = ranks[m]
        owner = rank if rank < other_rank else other_rank
        row = count if count < last else last
        found[row, 0] = owner
        found[row, 1] = rank if rank > other_rank else other_rank
        is_near = dx * dx + dy * dy <= most * most
        is_pair = is_near & (owner < SLEEPERS) & (rank != other_rank)
        count += int(is_pair)
    return count


@lean_kernel
def _query_cells(
    grid: HashGrid, x: float, y: float, radius: float, rank: int, first: int, columns: int,
    found: Counts, count: int,
) -> int:  # fmt: skip
    """`_test_range` for `columns` cells of a row, beginning with the bucket `first`."""
    starts = grid.bucket_starts
    room = len(starts) - 2
    end = first + columns
    count = _test_range(
        grid, x, y, radius, rank, starts[first], starts[min(end, room)], found, count
    )
    if end > room:  # the buckets wrap around: the rest of the row begins at bucket 0
        count = _test_range(
            grid, x, y, radius, rank, 0, starts[min(end - room, first)], found, count
        )
    return count


@lean_kernel
def _query_level(grid: HashGrid, m: int, level: int, found: Counts, count: int) -> int:
    """Append the pairs of disc m with those near it on another level; some may be found twice."""
    x = grid.discs[m, hash_grid.X]
    y = grid.discs[m, hash_grid.Y]
    radius = grid.discs[m, hash_grid.RADIUS]
    rank = grid.ranks[m]
    per_metre = grid.cells_per_metre[level]
    starts = grid.bucket_starts
    room = len(starts) - 2
    rim = radius + grid.largest[level]
    cx = int(np.floor((x - rim) * per_metre))
    cy = int(np.floor((y - rim) * per_metre))
    columns = int(np.floor((x + rim) * per_metre)) - cx + 1
    rows = int(np.floor((y + rim) * per_metre)) - cy + 1
    if columns * rows > max(25, starts[room]):  # more cells than balls: compare with all balls
        return _test_range(grid, x, y, radius, rank, 0, int(starts[room]), found, count)
    for row in range(rows):
        first = _bucket(cx, cy + row, level, room - 1)
        count = _query_cells(grid, x, y, radius, rank, first, columns, found, count)
    return count


@lean_kernel
def _query_own_level(grid: HashGrid, m: int, level: int, found: Counts, count: int) -> int:
    """Append the pairs of disc m with discs near it on its own level.

    Only discs after it in its cell, in later cells of its row and in the rows below are tested, so
    each pair is found once.
    """
    x = grid.discs[m, hash_grid.X]
    y = grid.discs[m, hash_grid.Y]
    radius = grid.discs[m, hash_grid.RADIUS]
    rank = grid.ranks[m]
    per_metre = grid.cells_per_metre[level]
    cells = grid.cells
    starts = grid.bucket_starts
    room = len(starts) - 2
    i = rank & (ROWS - 1)
    rim = radius + grid.largest[level]
    right = int(np.floor((x + rim) * per_metre))
    left = int(np.floor((x - rim) * per_metre))
    cy = cells[i, hash_grid.CELL_Y]
    rows = int(np.floor((y + rim) * per_metre)) - cy
    first = cells[i, hash_grid.BUCKET]
    end = first + right - cells[i, hash_grid.CELL_X] + 1
    count = _test_range(grid, x, y, radius, rank, m + 1, starts[min(end, room)], found, count)
    if end > room:
        count = _test_range(
            grid, x, y, radius, rank, 0, starts[min(end - room, first)], found, count
        )
    for row in range(1, rows + 1):
        first = _bucket(left, cy + row, level, room - 1)
        count = _query_cells(grid, x, y, radius, rank, first, right - left + 1, found, count)
    return count


@lean_kernel
def _query_all(grid: HashGrid, total: int, levels: int, found: Counts) -> int:
    """Fill `found` with all pairs of balls that may touch, some perhaps twice; return their number.

    Of two levels, the smaller balls search around themselves for the larger; or the larger for the
    smaller, if they are few and have few cells around them.
    """
    level = grid.level
    population = grid.population
    count = 0
    for m in range(total):
        own = level[grid.ranks[m] & (ROWS - 1)]
        for k in range(levels):
            if k == own:
                count = _query_own_level(grid, m, k, found, count)
            elif grid.largest[k] > 0.0:
                low = min(k, own)
                high = max(k, own)
                by_large = high - low <= 2 and 2 * population[high] < population[low]
                if by_large == (own > k):
                    count = _query_level(grid, m, k, found, count)
    return count


@inner_kernel
def find_pairs(bodies: Bodies, n: int, settings: SolverSettings) -> tuple[Counts, int, Floats]:
    """Set margins and find the pairs of balls that may touch.

    Returns an array with a row for each pair, the ranks of owner and other; the number of rows, in
    any order and some perhaps twice; and each disc's radius in m.
    """
    grid = _new_grid(n)
    disc_radius = np.empty(n)
    found = np.empty((4 * n + 64, 2), np.int64)
    scale = 1.0
    while True:
        _set_margins(bodies, n, settings, scale)
        levels = _set_levels(bodies, n, settings.cell, grid, disc_radius)
        total = _fill_buckets(bodies, n, grid, disc_radius)
        limit = PAIRS_PER_BALL * n + 4096 if scale > 1.0e-6 else 2147483647
        count = _query_all(grid, total, levels, found)
        if count > limit:
            scale *= 0.5
            continue
        if count < len(found):  # not <=: `_test_range` also writes to the row after the last
            return found, count, disc_radius
        found = np.empty((count + 1, 2), np.int64)
