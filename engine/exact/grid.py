"""The broad phase, a uniform grid: for each cell, the surfaces that a ball in it may soon touch."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from engine.jit.decorator import lean_kernel
from engine.physics import surface

MAX_CELLS = 1 << 17
"""Of one grid, which then takes a megabyte: larger boards have coarser cells rather than more."""

MAX_LISTED = 1 << 19
"""Cells in the boxes around all surfaces: where many lie upon each other, cells are coarser too."""

_BLOCK = 1 << 18
"""Cells that are looked at together while a grid is made: so much memory it takes."""

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Indices = npt.NDArray[np.uint32]


CELL_LIMIT = 1.0e9
"""Cells from the grid's corner beyond which a ball counts as escaped."""


HEAD_BITS = 28
"""Of a cell's head: the low bits are its first item, 0 if it has none; above is how many it has."""

HEAD_MANY = (1 << (32 - HEAD_BITS)) - 1
"""The largest number of items in a head; it stands for more, too."""


class Cells(NamedTuple):
    """A grid of columns times rows square cells; after the last comes one for all that is outside.

    starts, shape (columns * rows + 2,): where each cell's surfaces start in `members`, which are
    ascending within a cell. Both unsigned, so that machine code need not ask whether an index is
    below zero.
    """

    left: float  # m, of the grid's upper left corner
    top: float
    cells_per_metre: float
    columns: int
    rows: int
    starts: Indices
    members: Indices
    heads: Indices


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


def heads_of(starts: Indices, members: Indices) -> Indices:
    """`BoardArrays.heads`: what most looks at a cell want to know of it, in one number."""
    counts = np.minimum(np.diff(starts), HEAD_MANY).astype(np.uint32)
    firsts = np.append(members, np.uint32(0))[starts[:-1]]
    return np.where(counts > 0, firsts | (counts << np.uint32(HEAD_BITS)), 0).astype(np.uint32)


def cells_of(items: Floats, radius: float, reach: float, cells_per_metre: float) -> Cells:
    """A grid whose cells list each surface that a ball in them can touch within `reach`, in m.

    items: the surfaces, shape (n, surface.COLUMNS). cells_per_metre: how fine the grid should be.
    """
    listed = np.flatnonzero(
        (items[:, surface.DISTANCE] == 0.0) | (items[:, surface.DISTANCE2] >= 0.0)
    )
    if not len(listed):
        nothing = np.zeros(0, np.uint32)
        starts = np.zeros(2, np.uint32)
        return Cells(0.0, 0.0, cells_per_metre, 0, 0, starts, nothing, heads_of(starts, nothing))
    areas = _areas_of(items[listed], radius, reach)
    boxes = _boxes(areas)
    left, top = boxes[0].min(axis=0).tolist()
    boxes -= (left, top)
    width, height = boxes[1].max(axis=0).tolist()
    while _are_many(boxes, width, height, cells_per_metre):
        cells_per_metre *= 0.75
    columns, rows = (int(side * cells_per_metre) + 1 for side in (width, height))
    found = list(_touched(areas, boxes, (left, top), cells_per_metre))
    cell = np.concatenate([ix + columns * iy for _, ix, iy in found])
    owner = listed[np.concatenate([area for area, _, _ in found])]  # ascending
    members = owner[np.argsort(cell, kind="stable")].astype(np.uint32)
    counts = np.bincount(cell, minlength=columns * rows + 1)
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.uint32)
    heads = heads_of(starts, members)
    return Cells(left, top, cells_per_metre, columns, rows, starts, members, heads)


def _areas_of(items: Floats, radius: float, reach: float) -> Floats:
    """All points within a reach of a surface's axis, a line or the middle of a circle; (n, 6).

    Columns: x, y, tx, ty and length of the axis, and the reach, in m. A middle's length is 0.
    """
    wider = 1.0 + 1e-9  # rounding of what follows must not lose a cell that just touches
    x, y, distance = items[:, [surface.X, surface.Y, surface.DISTANCE]].T
    tx, ty, length = items[:, [surface.TX, surface.TY, surface.LENGTH]].T
    disc = distance > 0.0
    own = wider * (np.where(disc, distance, radius) + reach)
    return np.column_stack(
        [x, y, np.where(disc, 1.0, tx), np.where(disc, 0.0, ty), np.where(disc, 0.0, length), own]
    )


def _boxes(areas: Floats) -> Floats:
    """The least and the greatest x and y of each area, (2, n, 2)."""
    begin, along, (length, reach) = areas[:, :2], areas[:, 2:4], areas[:, 4:, None].swapaxes(0, 1)
    end = begin + length * along
    return np.stack([np.minimum(begin, end) - reach, np.maximum(begin, end) + reach])


def _are_many(boxes: Floats, width: float, height: float, cells_per_metre: float) -> bool:
    """Whether a grid of this fineness has too many cells, or lists too much in them."""
    if (width * cells_per_metre + 1.0) * (height * cells_per_metre + 1.0) > MAX_CELLS:
        return True
    low, high = (boxes * cells_per_metre).astype(np.int64)
    return int(np.prod(high - low + 1, axis=1).sum()) > MAX_LISTED


def _touched(
    areas: Floats, boxes: Floats, corner: tuple[float, float], cells_per_metre: float
) -> Iterator[tuple[Ints, Ints, Ints]]:
    """Areas by number with the column and the row of each cell that they touch, some at a time.

    A few more along a slanted line. boxes: those around the areas, seen from the grid's corner.
    """
    low, high = (boxes * cells_per_metre).astype(np.int64)
    columns, rows = (high - low + 1).T
    blocks = np.flatnonzero(np.diff(np.cumsum(columns * rows) // _BLOCK)) + 1
    for block in np.split(np.arange(len(areas)), blocks):
        cells = columns[block] * rows[block]
        area = np.repeat(block, cells)
        number = np.arange(len(area)) - np.repeat(np.cumsum(cells) - cells, cells)
        ix = low[area, 0] + number // rows[area]
        iy = low[area, 1] + number % rows[area]
        near = _is_near(areas[area], ix, iy, corner, 1.0 / cells_per_metre)
        yield area[near], ix[near], iy[near]


def _is_near(
    areas: Floats, ix: Ints, iy: Ints, corner: tuple[float, float], size: float
) -> npt.NDArray[np.bool_]:
    """Whether each of these areas touches the cell of this column and row."""
    middle_x, middle_y, tx, ty, length, reach = areas.T
    x = corner[0] + ix * size - middle_x
    y = corner[1] + iy * size - middle_y
    dx = np.maximum(np.maximum(x, -x - size), 0.0)
    dy = np.maximum(np.maximum(y, -y - size), 0.0)
    near: npt.NDArray[np.bool_] = dx * dx + dy * dy <= reach * reach
    line = length > 0.0
    if line.any():  # a line's distance from the cell's centre, less half the cell's diagonal
        x, y, tx, ty, length = (each[line] for each in (x, y, tx, ty, length))
        x += 0.5 * size
        y += 0.5 * size
        along = np.clip(x * tx + y * ty, 0.0, length)
        dx, dy, far = x - along * tx, y - along * ty, reach[line] + 0.7072 * size
        near[line] = dx * dx + dy * dy <= far * far
    return near
