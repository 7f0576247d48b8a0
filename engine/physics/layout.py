"""A board as the kernels see it: numbers and flat arrays, with a grid over its surfaces."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from engine.jit.decorator import lean_kernel

# Columns of `items`: where a surface is, and how far from it a ball's centre is at contact.
X = 0  # of a circle's centre or a line's first end, m
Y = 1
DISTANCE = 2  # circle (a peg, or a wall's end): D = R + r, m; 0 for a line (a wall's inside)
DISTANCE2 = 3  # circle: D^2
LENGTH = 3  # line, m
TX = 4  # line: unit vector along it
TY = 5
NX = 6  # line: unit normal
NY = 7
FIRST_END = 8  # line: the items of its two ends
LAST_END = 9
FIRST_LINE = 4  # circle: up to four lines that end in it, -1 for none
LINE_SLOTS = 4
INVERSE = 8  # circle: 1 / D
ITEM_COLUMNS = 10

CELL_LIMIT = 1.0e9
"""Cells from the grid's corner beyond which a ball counts as escaped."""


HEAD_BITS = 28
"""Of a cell's head: the low bits are its first item, 0 if it has none; above is how many it has."""

HEAD_MANY = (1 << (32 - HEAD_BITS)) - 1
"""The largest number of items in a head; it stands for more, too."""


class Layout(NamedTuple):
    """All that kernels know of a board. SI units; n surfaces. The grid: `engine.exact.grid`."""

    items: npt.NDArray[np.float64]  # (n, 10): pegs by index, then each wall's line and two ends
    left: float  # m, of the grid's upper left corner
    top: float
    cells_per_metre: float
    columns: int
    rows: int
    starts: npt.NDArray[np.uint32]  # (columns rows + 2,): where each cell's items start in members
    members: npt.NDArray[np.uint32]  # (m,): item numbers, ascending within a cell
    heads: npt.NDArray[np.uint32]  # (columns rows + 1,): each cell's first item, and how many
    centres: npt.NDArray[np.float64]  # (n + 1, 3): each item's x, y, D^2; a line has D^2 = 0
    peg_count: int
    travel: float  # m; the cell midway between a way's ends lists all it touches, if no longer
    fall: float  # s; from rest a ball falls the travel in it; 1 without gravity
    gravity: float
    drag: float
    radius: float
    peg_restitution: float
    peg_friction: float
    wall_restitution: float
    wall_friction: float
    bins_y: float
    edges: npt.NDArray[np.float64]  # (bins + 1,)


@lean_kernel
def cell_at(
    x: float, y: float, left: float, top: float, cells_per_metre: float, columns: int, rows: int
) -> int:
    """Number of the cell that holds (x, y), columns * rows for all outside; -1 if too far out."""
    across = (x - left) * cells_per_metre
    down = (y - top) * cells_per_metre
    if across >= 0.0 and down >= 0.0 and across < columns and down < rows:
        return int(down) * columns + int(across)
    if abs(across) < CELL_LIMIT and abs(down) < CELL_LIMIT:  # a NaN fails this too
        return columns * rows
    return -1


@lean_kernel
def cell_of(board: Layout, x: float, y: float) -> int:
    """`cell_at` of a board."""
    return cell_at(x, y, board.left, board.top, board.cells_per_metre, board.columns, board.rows)


@lean_kernel
def bin_of(board: Layout, x: float) -> int:
    """Bin whose edges enclose x: edges[i] <= x < edges[i + 1], the outer ones open outwards."""
    low = 0
    high = len(board.edges) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x >= board.edges[middle]:
            low = middle
        else:
            high = middle
    return low
