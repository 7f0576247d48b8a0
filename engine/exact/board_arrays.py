"""A board as the kernels see it: numbers and flat arrays, and how they are made of it.

Kernels take the tuple whole. Its arrays cost no counting of references in `inner_kernel`s: against
their twenty fields one by one, batches and single drops took 0.97 to 1.02 times as long.
"""

from math import sqrt
from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from engine.board.fields import BoardFields
from engine.board.materials import combine
from engine.exact.grid import cell_at, cells_of
from engine.exact.kept import Kept
from engine.jit.decorator import inner_kernel, lean_kernel
from engine.physics import surface
from engine.physics.flight import HALF_WAY


class BoardArrays(NamedTuple):
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
def cell_of(board: BoardArrays, x: float, y: float) -> int:
    """`cell_at` of a board."""
    return cell_at(x, y, board.left, board.top, board.cells_per_metre, board.columns, board.rows)


@lean_kernel
def bin_of(board: BoardArrays, x: float) -> int:
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


@inner_kernel
def restitution_of(board: BoardArrays, item: int) -> float:
    """Restitution between the ball and `item`."""
    return board.peg_restitution if item < board.peg_count else board.wall_restitution


@inner_kernel
def friction_of(board: BoardArrays, item: int) -> float:
    """Coefficient of friction between the ball and `item`."""
    return board.peg_friction if item < board.peg_count else board.wall_friction


@inner_kernel
def surface_index(board: BoardArrays, item: int) -> int:
    """How contact events name a surface: a peg by its index, wall w as -1 - w."""
    if item < board.peg_count:
        return item
    return -1 - (item - board.peg_count) // 3


# Cells and travel per mean peg spacing. Coarser cells make longer candidate lists, finer ones fill
# the cache; shorter travel makes more search windows. The time of a drop is flat around these.
_CELLS_PER_PITCH = 8.0
_TRAVEL_PER_PITCH = 0.35
_CELLS_PER_WALL = 500.0  # along a wall at most: its box of cells stays small however long it is

_KEPT: Final = 32 << 20  # bytes; a preset's take 0.07 to 0.9 MB, those of 5,000 pegs 1.4


def make_arrays(board: BoardFields) -> BoardArrays:
    """The kernels' form of `board`; its arrays cannot be written."""
    items = _items(board)
    pitch = _pitch(board)
    travel = _TRAVEL_PER_PITCH * pitch
    fine = min(_CELLS_PER_PITCH / pitch, _CELLS_PER_WALL / _longest_wall(board))
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
"""The kernels' form of a board, made when it is first asked for."""


def _items(board: BoardFields) -> npt.NDArray[np.float64]:
    """The pegs, then each wall's line and two ends; shared ends are the first one's item."""
    peg_count = len(board.pegs)
    items = np.zeros((peg_count + 3 * len(board.walls), surface.COLUMNS))
    radius = board.ball.radius
    if board.pegs:
        pegs = np.array([(peg.x, peg.y, radius + peg.radius) for peg in board.pegs])
        _set_circles(items[:peg_count], *pegs.T)
    ends: dict[tuple[float, float], int] = {}
    for w, wall in enumerate(board.walls):
        line = peg_count + 3 * w
        dx = wall.x2 - wall.x1
        dy = wall.y2 - wall.y1
        length = sqrt(dx * dx + dy * dy)
        row = items[line]
        row[[surface.X, surface.Y, surface.LENGTH]] = wall.x1, wall.y1, length
        row[[surface.TX, surface.TY]] = dx / length, dy / length
        row[[surface.NX, surface.NY]] = -dy / length, dx / length
        for column, end, point in (
            (surface.FIRST_END, line + 1, (wall.x1, wall.y1)),
            (surface.LAST_END, line + 2, (wall.x2, wall.y2)),
        ):
            _set_circles(items[end], *point, radius)
            shared = ends.setdefault(point, end)
            row[column] = shared
            slots = items[shared, surface.FIRST_LINE : surface.FIRST_LINE + surface.LINE_SLOTS]
            if (slots < 0).any():
                slots[np.argmax(slots < 0)] = line
            if shared != end:
                items[end, surface.DISTANCE2] = -1.0  # a copy: never listed as a candidate
    return items


def _set_circles(rows: npt.NDArray[np.float64], x: Any, y: Any, distance: Any) -> None:
    """Write one circle into a row, or as many as there are rows, from so many values of each."""
    rows[..., surface.X] = x
    rows[..., surface.Y] = y
    rows[..., surface.DISTANCE] = distance
    rows[..., surface.DISTANCE2] = distance * distance
    rows[..., surface.FIRST_LINE : surface.FIRST_LINE + surface.LINE_SLOTS] = -1.0
    rows[..., surface.INVERSE] = 1.0 / distance


def _longest_wall(board: BoardFields) -> float:
    """The longer side of the largest wall's box, m; a ball's radius on a board without walls."""
    sides = [max(abs(w.x2 - w.x1), abs(w.y2 - w.y1)) for w in board.walls]
    return max([board.ball.radius, *sides])


def _pitch(board: BoardFields) -> float:
    """Mean spacing of the pegs, m; on a board without pegs an eighth of its width."""
    if len(board.pegs) < 2:
        return max(board.width / 8.0, 4.0 * board.ball.radius)
    xs = [peg.x for peg in board.pegs]
    ys = [peg.y for peg in board.pegs]
    width = max(xs) - min(xs)
    height = max(ys) - min(ys)
    area = max(width, 1e-3 * height) * max(height, 1e-3 * width)
    return max(sqrt(area / len(board.pegs)), board.ball.radius)


def _centres(items: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """What the search reads of each surface, side by side in memory; one row more, of nothing.

    A cell without surfaces has item 0 in its head, which is read before it is known to be none.
    """
    centres = np.zeros((len(items) + 1, 3))
    centres[:-1] = items[:, [surface.X, surface.Y, surface.DISTANCE2]]
    centres[:-1][items[:, surface.DISTANCE] == 0.0, 2] = 0.0
    return centres
