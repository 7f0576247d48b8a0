"""A board as the kernels see it: numbers and flat arrays, with a spatial hash over its surfaces."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from engine.kernels.jit import kernel

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
ITEM_COLUMNS = 10

# Multipliers of the prime hash of Teschner et al., VMV 2003.
PRIME_X = 73856093
PRIME_Y = 19349663

CELL_LIMIT = 1.0e9
"""Cells from the origin beyond which a ball counts as escaped; floats below it fit an int64."""


class Layout(NamedTuple):
    """All that the kernels know of a board. SI units; n surfaces, b hash buckets."""

    items: npt.NDArray[np.float64]  # (n, 10): pegs by index, then each wall's line and two ends
    starts: npt.NDArray[np.int64]  # (b + 1,): where each bucket's items start in `members`
    members: npt.NDArray[np.int64]  # (m,): item numbers, ascending within a bucket
    near: npt.NDArray[np.float64]  # (m, 3): each member as x, y, D^2; a line has D^2 = 0
    peg_count: int
    cells_per_metre: float
    travel: float  # m; a bucket lists all a ball can touch while it moves this far from its cell
    gravity: float
    drag: float
    radius: float
    peg_restitution: float
    peg_friction: float
    wall_restitution: float
    wall_friction: float
    bins_y: float
    edges: npt.NDArray[np.float64]  # (bins + 1,)


@kernel
def cell_bucket(x: float, y: float, cells_per_metre: float, buckets: int) -> int:
    """Hash bucket, of a power of two of them, of the cell that holds (x, y); -1 if too far out."""
    fx = np.floor(x * cells_per_metre)
    fy = np.floor(y * cells_per_metre)
    if not (abs(fx) < CELL_LIMIT and abs(fy) < CELL_LIMIT):  # a NaN fails this too
        return -1
    return int((int(fx) * PRIME_X + int(fy) * PRIME_Y) & (buckets - 1))


@kernel
def bucket_of(board: Layout, x: float, y: float) -> int:
    """`cell_bucket` of a board."""
    return cell_bucket(x, y, board.cells_per_metre, board.starts.shape[0] - 1)


@kernel
def bin_of(board: Layout, x: float) -> int:
    """Bin whose edges enclose x: edges[i] <= x < edges[i + 1], the outer ones open outwards."""
    low = 0
    high = board.edges.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x >= board.edges[middle]:
            low = middle
        else:
            high = middle
    return low
