"""A board in the form that kernels take: a named tuple of numbers and flat arrays.

Kernels take the whole tuple. That costs nothing: with its twenty fields as separate arguments,
batches and single drops took 0.97 to 1.02 times as long.
"""

from math import sqrt
from typing import Final, NamedTuple

import numpy as np

from plinko.engine.board.cache import BoardCache
from plinko.engine.board.fields import BoardFields
from plinko.engine.board.materials import combine
from plinko.engine.exact.grid import cell_at, cells_of
from plinko.engine.exact.surfaces import lay_out
from plinko.engine.jit.decorator import inner_kernel, kernel, lean_kernel
from plinko.engine.physics import contact, surface
from plinko.engine.physics.array_types import Floats, Indices
from plinko.engine.physics.flight import HALF_WAY


class BoardArrays(NamedTuple):
    """A board with n surfaces, in SI units; `plinko.engine.exact.grid` explains the grid's
    fields.
    """

    items: Floats  # (n, 16): rows of `plinko.engine.physics.surface`
    left: float  # m, of the grid's upper left corner
    top: float
    cells_per_metre: float
    columns: int
    rows: int
    starts: Indices  # (columns rows + 2,): where each cell's items start in members
    members: Indices  # (m,): item numbers, ascending within a cell
    heads: Indices  # (columns rows + 1,): each cell's first item, and how many
    centres: Floats  # (n + 1, 3): each item's x, y, D^2; a line has D^2 = 0
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
    edges: Floats  # (bins + 1,)


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
def law_on(board: BoardArrays, item: int) -> contact.Law:
    """The law of a ball's motion on a surface."""
    bend = surface.curvature(board.items, item)
    return contact.Law(bend, board.gravity, board.drag, friction_of(board, item), board.radius)


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


@kernel
def lay_out_board(
    pegs: Floats, walls: Floats, edges: Floats, bins_y: float, gravity: float, drag: float,
    radius: float, peg_restitution: float, peg_friction: float, wall_restitution: float,
    wall_friction: float,
) -> BoardArrays:  # fmt: skip
    """The arrays of a board: pegs, (n, 3), x, y and radius; walls, (m, 4), x1, y1, x2, y2; edges
    and bins_y of its bins; and the materials of pegs and walls combined with the ball's.
    """
    items = np.zeros((len(pegs) + 3 * len(walls), surface.COLUMNS))
    lay_out(pegs, walls, radius, items)
    longest = _longest_wall(items, radius)
    pitch = _pitch(pegs, longest, radius)
    travel = _TRAVEL_PER_PITCH * pitch
    fine = min(_CELLS_PER_PITCH / pitch, _CELLS_PER_WALL / longest)
    cells = cells_of(items, radius, HALF_WAY * travel, fine)
    fall = sqrt(2.0 * travel / gravity) if gravity > 0.0 else 1.0
    return BoardArrays(
        items, cells.left, cells.top, cells.cells_per_metre, cells.columns, cells.rows,
        cells.starts, cells.members, cells.heads, _centres(items), len(pegs), travel, fall, gravity,
        drag, radius, peg_restitution, peg_friction, wall_restitution, wall_friction, bins_y, edges,
    )  # fmt: skip


@inner_kernel
def _longest_wall(items: Floats, radius: float) -> float:
    """The longest side of a straight wall's bounding box, m; without walls the ball's radius."""
    longest = radius
    for item in range(len(items)):
        if items[item, surface.DISTANCE] == 0.0:
            wide = abs(items[item, surface.END_X] - items[item, surface.X])
            high = abs(items[item, surface.END_Y] - items[item, surface.Y])
            longest = max(longest, wide, high)
    return longest


@inner_kernel
def _pitch(pegs: Floats, longest_wall: float, radius: float) -> float:
    """Mean spacing of the pegs, m; with fewer than two pegs an eighth of the longest wall."""
    if len(pegs) < 2:
        return max(longest_wall / 8.0, 4.0 * radius)
    width = _span(pegs, 0)
    height = _span(pegs, 1)
    area = max(width, 1e-3 * height) * max(height, 1e-3 * width)
    return max(sqrt(area / len(pegs)), radius)


@inner_kernel
def _span(rows: Floats, column: int) -> float:
    """The difference between the greatest and the least value of a column."""
    least = most = rows[0, column]
    for i in range(len(rows)):
        least = min(least, rows[i, column])
        most = max(most, rows[i, column])
    return float(most - least)


@inner_kernel
def _centres(items: Floats) -> Floats:
    """The columns of each surface that the search reads, adjacent in memory, and a row of zeros.

    The head of an empty cell names item 0, which lanes read before they test the cell's count. On
    a board without surfaces that is the last row.
    """
    centres = np.zeros((len(items) + 1, 3))
    for item in range(len(items)):
        centres[item, 0] = items[item, surface.X]
        centres[item, 1] = items[item, surface.Y]
        if items[item, surface.DISTANCE] > 0.0:
            centres[item, 2] = items[item, surface.DISTANCE2]
    return centres


def make_arrays(board: BoardFields) -> BoardArrays:
    """The kernels' form of `board`, with read-only arrays."""
    pegs = combine(board.ball.material, board.peg_material)
    walls = combine(board.ball.material, board.wall_material)
    arrays = lay_out_board(
        np.array([(p.x, p.y, p.radius) for p in board.pegs], np.float64).reshape(-1, 3),
        np.array([(w.x1, w.y1, w.x2, w.y2) for w in board.walls], np.float64).reshape(-1, 4),
        np.array(board.bins.edges, np.float64), board.bins.y, board.gravity, board.drag,
        board.ball.radius, pegs.restitution, pegs.friction, walls.restitution, walls.friction,
    )  # fmt: skip
    for each in arrays:
        if isinstance(each, np.ndarray):
            each.setflags(write=False)
    return arrays


def _bytes_of(arrays: BoardArrays) -> int:
    return sum(each.nbytes for each in arrays if isinstance(each, np.ndarray))


arrays_of: Final = BoardCache(make_arrays, _bytes_of, _KEPT)
"""The kernels' form of a board, cached."""
