"""A board in the form that kernels take: a named tuple of numbers and flat arrays.

Kernels take the whole tuple. That costs nothing: with its twenty fields as separate arguments,
batches and single drops took 0.97 to 1.02 times as long.
"""

from math import sqrt
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from plinko.engine.board.fields import BoardFields
from plinko.engine.board.materials import combine
from plinko.engine.exact.grid import cell_at, cells_of
from plinko.engine.exact.kept import Kept
from plinko.engine.exact.surfaces import lay_out
from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.physics import surface
from plinko.engine.physics.flight import HALF_WAY


class BoardArrays(NamedTuple):
    """A board with n surfaces, in SI units; `plinko.engine.exact.grid` explains the grid's
    fields.
    """

    items: npt.NDArray[np.float64]  # (n, 16): rows of `plinko.engine.physics.surface`
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
    travel: float  # m; the longest path whose surfaces the cell at its middle lists
    fall: float  # s in which a ball falls by `travel` from rest; 1 without gravity
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
def cell_of(board: BoardArrays, x: float, y: float) -> int:
    """`cell_at` in a board's grid."""
    return cell_at(x, y, board.left, board.top, board.cells_per_metre, board.columns, board.rows)


@lean_kernel
def bin_of(board: BoardArrays, x: float) -> int:
    """The bin i with edges[i] <= x < edges[i + 1]; the first and last extend outwards for ever."""
    low = 0
    high = len(board.edges) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x >= board.edges[middle]:
            low = middle
        else:
            high = middle
    return low


@inner_kernel
def restitution_of(board: BoardArrays, item: int) -> float:
    return board.peg_restitution if item < board.peg_count else board.wall_restitution


@inner_kernel
def friction_of(board: BoardArrays, item: int) -> float:
    return board.peg_friction if item < board.peg_count else board.wall_friction


@inner_kernel
def wall_at(board: BoardArrays, item: int, x: float, y: float) -> int:
    """The number of the wall that a ball at (x, y) touches on an item that is not a peg.

    A straight wall of several pieces has the number of the first piece that covers the ball's foot.
    """
    first = (item - board.peg_count) // 3
    row = board.items[item]
    if row[surface.DISTANCE] > 0.0 or row[surface.NEXT] < 0.0:
        return first
    foot = (x - row[surface.X]) * row[surface.TX] + (y - row[surface.Y]) * row[surface.TY]
    nearest = first
    least = np.inf
    piece = item
    while piece >= 0:
        beyond = max(board.items[piece, surface.FROM] - foot, foot - board.items[piece, surface.TO])
        if max(beyond, 0.0) < least:
            least = max(beyond, 0.0)
            nearest = (piece - board.peg_count) // 3
        piece = int(board.items[piece, surface.NEXT])
    return nearest


@inner_kernel
def surface_index(board: BoardArrays, item: int, x: float, y: float) -> int:
    """The index of a surface in contact events, for a ball at (x, y): a peg's own, -1 - w for wall
    w."""
    if item < board.peg_count:
        return item
    return -1 - wall_at(board, item, x, y)


# Cells and travel per mean peg spacing. Larger cells list more candidates, smaller ones fill the
# processor's cache; a shorter travel needs more search windows. The optimum is flat.
_CELLS_PER_PITCH = 8.0
_TRAVEL_PER_PITCH = 0.35
_CELLS_PER_WALL = 500.0  # along a wall, at most: limits the cells that a long wall touches

_KEPT: Final = 32 << 20  # bytes; a preset takes 0.07 to 0.9 MB, a board of 5,000 pegs 1.4 MB


def make_arrays(board: BoardFields) -> BoardArrays:
    """The kernels' form of `board`, with read-only arrays."""
    items = _items(board)
    longest_wall = _longest_wall(items, board.ball.radius)
    pitch = _pitch(board, longest_wall)
    travel = _TRAVEL_PER_PITCH * pitch
    fine = min(_CELLS_PER_PITCH / pitch, _CELLS_PER_WALL / longest_wall)
    cells = cells_of(items, board.ball.radius, HALF_WAY * travel, fine)
    pegs = combine(board.ball.material, board.peg_material)
    walls = combine(board.ball.material, board.wall_material)
    arrays = BoardArrays(
        items=items,
        **cells._asdict(),
        centres=_centres(items),
        peg_count=len(board.pegs),
        travel=travel,
        fall=sqrt(2.0 * travel / board.gravity) if board.gravity > 0.0 else 1.0,
        gravity=board.gravity,
        drag=board.drag,
        radius=board.ball.radius,
        peg_restitution=pegs.restitution,
        peg_friction=pegs.friction,
        wall_restitution=walls.restitution,
        wall_friction=walls.friction,
        bins_y=board.bins.y,
        edges=np.array(board.bins.edges, np.float64),
    )
    for each in arrays:
        if isinstance(each, np.ndarray):
            each.setflags(write=False)
    return arrays


def _bytes_of(arrays: BoardArrays) -> int:
    return sum(each.nbytes for each in arrays if isinstance(each, np.ndarray))


arrays_of: Final = Kept(make_arrays, _bytes_of, _KEPT)
"""The kernels' form of a board, cached."""


def _items(board: BoardFields) -> npt.NDArray[np.float64]:
    pegs = np.array([(peg.x, peg.y, peg.radius) for peg in board.pegs], np.float64)
    walls = np.array([(w.x1, w.y1, w.x2, w.y2) for w in board.walls], np.float64)
    items = np.zeros((len(pegs) + 3 * len(walls), surface.COLUMNS))
    lay_out(pegs.reshape(-1, 3), walls.reshape(-1, 4), board.ball.radius, items)
    return items


def _longest_wall(items: npt.NDArray[np.float64], radius: float) -> float:
    """The longest side of a straight wall's bounding box, m; without walls the ball's radius."""
    lines = items[items[:, surface.DISTANCE] == 0.0]
    width = np.abs(lines[:, surface.END_X] - lines[:, surface.X])
    height = np.abs(lines[:, surface.END_Y] - lines[:, surface.Y])
    return float(max(np.max(width, initial=radius), np.max(height, initial=radius)))


def _pitch(board: BoardFields, longest_wall: float) -> float:
    """Mean spacing of the pegs, m; with fewer than two pegs an eighth of the longest wall."""
    if len(board.pegs) < 2:
        return max(longest_wall / 8.0, 4.0 * board.ball.radius)
    xs = [peg.x for peg in board.pegs]
    ys = [peg.y for peg in board.pegs]
    width = max(xs) - min(xs)
    height = max(ys) - min(ys)
    area = max(width, 1e-3 * height) * max(height, 1e-3 * width)
    return max(sqrt(area / len(board.pegs)), board.ball.radius)


def _centres(items: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The columns of each surface that the search reads, adjacent in memory, and a row of zeros.

    The head of an empty cell names item 0, which lanes read before they test the cell's count. On
    a board without surfaces that is the last row.
    """
    centres = np.zeros((len(items) + 1, 3))
    centres[:-1] = items[:, [surface.X, surface.Y, surface.DISTANCE2]]
    centres[:-1][items[:, surface.DISTANCE] == 0.0, 2] = 0.0
    return centres
