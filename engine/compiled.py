"""From a board to the flat arrays that the kernels work on."""

from functools import lru_cache
from math import sqrt

import numpy as np
import numpy.typing as npt

from engine.board import Board
from engine.kernels.layout import (
    DISTANCE,
    DISTANCE2,
    FIRST_END,
    FIRST_LINE,
    ITEM_COLUMNS,
    LAST_END,
    LENGTH,
    LINE_SLOTS,
    NX,
    NY,
    PRIME_X,
    PRIME_Y,
    TX,
    TY,
    Layout,
    X,
    Y,
)
from engine.materials import combine

# Cells and travel per mean peg spacing. Coarser cells make longer candidate lists, shorter travel
# more search windows; the product of both is flat around these values.
_CELLS_PER_PITCH = 4.0
_TRAVEL_PER_PITCH = 0.3
_CELLS_PER_WALL = 500.0  # along a wall at most: its box of cells stays small however long it is
_BUCKETS_PER_CELL = 4  # occupied cells rarely share a bucket then, and empty ones look empty


@lru_cache(maxsize=64)
def layout_of(board: Board) -> Layout:
    """The kernels' form of `board`; kept for the boards used last."""
    items = _items(board)
    pitch = _pitch(board)
    travel = _TRAVEL_PER_PITCH * pitch
    cells_per_metre = min(_CELLS_PER_PITCH / pitch, _CELLS_PER_WALL / _longest_wall(board))
    starts, members = _hash(items, board.ball.radius, travel, cells_per_metre)
    pegs = combine(board.ball.material, board.peg_material)
    walls = combine(board.ball.material, board.wall_material)
    return Layout(
        items=items,
        starts=starts,
        members=members,
        near=_near(items, members),
        peg_count=len(board.pegs),
        cells_per_metre=cells_per_metre,
        travel=travel,
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


def _items(board: Board) -> npt.NDArray[np.float64]:
    """The pegs, then each wall's line and two ends; shared ends are the first one's item."""
    peg_count = len(board.pegs)
    items = np.zeros((peg_count + 3 * len(board.walls), ITEM_COLUMNS))
    radius = board.ball.radius
    for i, peg in enumerate(board.pegs):
        _set_circle(items[i], peg.x, peg.y, radius + peg.radius)
    ends: dict[tuple[float, float], int] = {}
    for w, wall in enumerate(board.walls):
        line = peg_count + 3 * w
        dx = wall.x2 - wall.x1
        dy = wall.y2 - wall.y1
        length = sqrt(dx * dx + dy * dy)
        row = items[line]
        row[[X, Y, LENGTH]] = wall.x1, wall.y1, length
        row[[TX, TY]] = dx / length, dy / length
        row[[NX, NY]] = -dy / length, dx / length
        for column, end, point in (
            (FIRST_END, line + 1, (wall.x1, wall.y1)),
            (LAST_END, line + 2, (wall.x2, wall.y2)),
        ):
            _set_circle(items[end], *point, radius)
            shared = ends.setdefault(point, end)
            row[column] = shared
            slots = items[shared, FIRST_LINE : FIRST_LINE + LINE_SLOTS]
            if (slots < 0).any():
                slots[np.argmax(slots < 0)] = line
            if shared != end:
                items[end, DISTANCE2] = -1.0  # a copy: never listed as a candidate
    return items


def _set_circle(row: npt.NDArray[np.float64], x: float, y: float, distance: float) -> None:
    row[[X, Y, DISTANCE, DISTANCE2]] = x, y, distance, distance * distance
    row[FIRST_LINE : FIRST_LINE + LINE_SLOTS] = -1.0


def _longest_wall(board: Board) -> float:
    """The longer side of the largest wall's box, m; a ball's radius on a board without walls."""
    sides = [max(abs(w.x2 - w.x1), abs(w.y2 - w.y1)) for w in board.walls]
    return max([board.ball.radius, *sides])


def _pitch(board: Board) -> float:
    """Mean spacing of the pegs, m; on a board without pegs an eighth of its width."""
    if len(board.pegs) < 2:
        return max(board.width / 8.0, 4.0 * board.ball.radius)
    xs = [peg.x for peg in board.pegs]
    ys = [peg.y for peg in board.pegs]
    width = max(xs) - min(xs)
    height = max(ys) - min(ys)
    area = max(width, 1e-3 * height) * max(height, 1e-3 * width)
    return max(sqrt(area / len(board.pegs)), board.ball.radius)


def _hash(
    items: npt.NDArray[np.float64], radius: float, travel: float, cells_per_metre: float
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Buckets of the spatial hash: starts, shape (b + 1,), and members, ascending in each.

    A cell lists each surface that a ball in it can touch within `travel`. Two cells that share a
    bucket see each other's surfaces too: more work, never another result.
    """
    cells: list[npt.NDArray[np.int64]] = []
    owners: list[npt.NDArray[np.int64]] = []
    for i, row in enumerate(items):
        if row[DISTANCE2] < 0.0 and row[DISTANCE] > 0.0:
            continue
        found = _cells_near(row, radius, travel, cells_per_metre)
        cells.append(found)
        owners.append(np.full(len(found), i))
    if not cells:
        return np.zeros(2, np.int64), np.zeros(0, np.int64)
    cell = np.concatenate(cells)
    owner = np.concatenate(owners)
    occupied = len(np.unique(cell, axis=0))
    size = 1
    while size < _BUCKETS_PER_CELL * occupied:
        size *= 2
    bucket = (cell[:, 0] * PRIME_X + cell[:, 1] * PRIME_Y) & (size - 1)
    pairs = np.unique(np.stack([bucket, owner], axis=1), axis=0)
    starts = np.searchsorted(pairs[:, 0], np.arange(size + 1)).astype(np.int64)
    return starts, np.ascontiguousarray(pairs[:, 1])


def _near(
    items: npt.NDArray[np.float64], members: npt.NDArray[np.int64]
) -> npt.NDArray[np.float64]:
    """What the search reads of each member, side by side in memory."""
    near = np.ascontiguousarray(items[members][:, [X, Y, DISTANCE2]])
    near[items[members, DISTANCE] == 0.0, 2] = 0.0
    return near


def _cells_near(
    row: npt.NDArray[np.float64], radius: float, travel: float, cells_per_metre: float
) -> npt.NDArray[np.int64]:
    """Cells, shape (m, 2), whose nearest point to a surface is within a ball's reach of it."""
    size = 1.0 / cells_per_metre
    is_circle = row[DISTANCE] > 0.0
    reach = (row[DISTANCE] if is_circle else radius) + travel
    reach *= 1.0 + 1e-9  # rounding of what follows must not lose a cell that just touches
    length = 0.0 if is_circle else row[LENGTH]
    ends = row[[X, Y]], row[[X, Y]] + length * row[[TX, TY]]
    low = np.floor((np.minimum(*ends) - reach) * cells_per_metre).astype(np.int64)
    high = np.floor((np.maximum(*ends) + reach) * cells_per_metre).astype(np.int64)
    ix, iy = np.meshgrid(
        np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1), indexing="ij"
    )
    if is_circle:
        dx = np.maximum(np.maximum(ix * size - row[X], row[X] - (ix + 1) * size), 0.0)
        dy = np.maximum(np.maximum(iy * size - row[Y], row[Y] - (iy + 1) * size), 0.0)
        near = dx * dx + dy * dy <= reach * reach
    else:  # the line's distance from the cell's centre, less half the cell's diagonal
        x = (ix + 0.5) * size - row[X]
        y = (iy + 0.5) * size - row[Y]
        along = np.clip(x * row[TX] + y * row[TY], 0.0, length)
        dx = x - along * row[TX]
        dy = y - along * row[TY]
        far = reach + 0.7072 * size
        near = dx * dx + dy * dy <= far * far
    return np.stack([ix[near], iy[near]], axis=1)
