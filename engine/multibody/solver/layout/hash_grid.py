"""The broad phase's hierarchical hash grid as arrays."""

from typing import NamedTuple

from engine.multibody.solver.layout.array_types import Counts, Floats, Ints

# Columns of `HashGrid.cells`.
CELL_X = 0  # in cells of the ball's level
CELL_Y = 1
BUCKET = 2
CELL_COLUMNS = 3

# Columns of `HashGrid.discs`.
X = 0  # m
Y = 1
RADIUS = 2  # the ball's and its margin, m
DISC_COLUMNS = 3


class HashGrid(NamedTuple):
    """Discs of all sizes in buckets of cells; cells of a level are twice those of the one below."""

    level: Ints  # (n,) of each ball
    cells: Ints  # (n, 3): CELL_X, CELL_Y, BUCKET of each ball
    cells_per_metre: Floats  # (LEVELS,)
    population: Ints  # (LEVELS,): balls on each level
    largest: Floats  # (LEVELS,): greatest radius of a disc on each level, m; 0: it is empty
    bucket_starts: Ints  # (buckets + 2,): bucket b holds discs bucket_starts[b] to [b + 1]
    discs: Floats  # (n, 3): X, Y, RADIUS, bucket after bucket, rows ascending in each
    ranks: Counts  # (n,): of each disc, a number that grows with its ball's level and row
