"""Static geometry: pegs and walls, and the grid that finds those near a place."""

from typing import NamedTuple

from plinko.engine.multibody.solver.layout.array_types import Floats, Ints

# Columns of `StaticShapes.items`. Pegs and walls are both capsules: segments with a radius.
X1 = 0  # first end of a wall, or a peg's centre, m
Y1 = 1
TX = 2  # unit vector along the wall; (1, 0) for a peg
TY = 3
LENGTH = 4  # m; 0 for a peg
RADIUS = 5  # m; 0 for a wall
RESTITUTION = 6
FRICTION = 7
COLUMNS = 8


class StaticShapes(NamedTuple):
    """Pegs, then walls, as items; and a uniform grid with the items in each cell."""

    items: Floats  # (m, 8)
    peg_count: int
    x0: float  # corner of the grid, m
    y0: float
    cells_per_metre: float
    columns: int
    rows: int
    starts: Ints  # (columns rows + 1,)
    members: Ints  # item numbers, ascending in each cell
    bins_y: float  # m; infinite without bins
