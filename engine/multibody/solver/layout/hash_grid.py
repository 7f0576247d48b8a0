"""The hierarchical hash grid of the broad phase."""

from typing import NamedTuple

from plinko.engine.multibody.solver.layout.array_types import Counts, Floats, Ints

# Columns of `HashGrid.cells`.
CELL_X = 0  # column of the cell in the grid of the ball's level
CELL_Y = 1
BUCKET = 2
CELL_COLUMNS = 3

# Columns of `HashGrid.discs`.
X = 0  # m
Y = 1
RADIUS = 2  # the ball's radius plus its margin, m
DISC_COLUMNS = 3


class HashGrid(NamedTuple):
    """Discs of all sizes, sorted into buckets of cells; a level's cells are twice as large as those
    of the level below."""

    level: Ints  # (n,) of each ball
    cells: Counts  # (n, 3): CELL_X, CELL_Y, BUCKET of each ball
    cells_per_metre: Floats  # (LEVELS,)
    population: Ints  # (LEVELS,): balls on each level
    largest: Floats  # (LEVELS,): largest radius of a disc on each level, m; 0 if it is empty
    bucket_starts: Ints  # (buckets + 2,): bucket b has discs bucket_starts[b] to [b + 1] - 1
    discs: Floats  # (n, 3): X, Y, RADIUS, sorted by bucket, then by ball's row
    ranks: Counts  # (n,): rank of each disc: it orders balls by level, then row; sleepers last
