"""The broad phase: a uniform grid whose cells list the surfaces that a ball in them may touch."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.physics import surface

MAX_CELLS = 1 << 17
"""Cells of one grid, about a megabyte. On a larger board the cells are larger instead."""

MAX_LISTED = 1 << 19
"""Cells in the boxes around all surfaces together. If many surfaces overlap, the cells are made
larger until this holds."""

_BLOCK = 1 << 18
"""Cells that are tested together while a grid is made; limits the memory for it."""

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Indices = npt.NDArray[np.uint32]


CELL_LIMIT = 1.0e9
"""A ball this many cells away from the grid's corner has escaped."""


HEAD_BITS = 28
"""The low bits of a cell's head have its first item, 0 if it has none; the high bits have the
number of its items."""

HEAD_MANY = (1 << (32 - HEAD_BITS)) - 1
"""The largest number in a head; it means this many items or more."""


class Cells(NamedTuple):
    """A grid of columns times rows square cells, and one more cell for everything outside.

    starts, shape (columns * rows + 2,): where each cell's surfaces start in `members`, in ascending
    order within a cell. Both are unsigned, so that machine code does not test for negative indices.
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
    """Number of the cell at (x, y), columns * rows outside of the grid; -1 beyond CELL_LIMIT."""
    across = (x - left) * cells_per_metre
    down = (y - top) * cells_per_metre
    if across >= 0.0 and down >= 0.0 and across < columns and down < rows:
        return int(down) * columns + int(across)
    if abs(across) < CELL_LIMIT and abs(down) < CELL_LIMIT:  # a NaN fails this too
        return columns * rows
    return -1


def heads_of(starts: Indices, members: Indices) -> Indices:
    """`BoardArrays.heads`: each cell's first item and number of items, which suffice for most
    lookups, in one number."""
    counts = np.minimum(np.diff(starts), HEAD_MANY).astype(np.uint32)
    firsts = np.append(members, np.uint32(0))[starts[:-1]]
    return np.where(counts > 0, firsts | (counts << np.uint32(HEAD_BITS)), 0).astype(np.uint32)


def cells_of(items: Floats, radius: float, reach: float, cells_per_metre: float) -> Cells:
    """A grid whose cells list each surface that a ball in them can touch within `reach`, in m.

    items: the surfaces, shape (n, surface.COLUMNS). cells_per_metre: the resolution, reduced if the
    grid would exceed MAX_CELLS or MAX_LISTED.
    """
    listed = np.flatnonzero(items[:, surface.OWNER] == np.arange(len(items)))
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
    """The areas from which a ball's centre can touch each surface, shape (n, 6).

    An area is all points within a distance of an axis: a line, or the centre of a circle, whose
    length is 0. Columns: x, y, tx, ty and length of the axis, and the distance, in m.
    """
    wider = 1.0 + 1e-9  # so that rounding below does not omit a cell that just touches
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
    """Whether a grid of this resolution exceeds MAX_CELLS or MAX_LISTED."""
    if (width * cells_per_metre + 1.0) * (height * cells_per_metre + 1.0) > MAX_CELLS:
        return True
    low, high = (boxes * cells_per_metre).astype(np.int64)
    return int(np.prod(high - low + 1, axis=1).sum()) > MAX_LISTED


def _touched(
    areas: Floats, boxes: Floats, corner: tuple[float, float], cells_per_metre: float
) -> Iterator[tuple[Ints, Ints, Ints]]:
    """The number of an area, and column and row of a cell, for all cells that the areas touch.

    In blocks of about _BLOCK cells. Along a slanted line a few cells are listed that do not touch.
    boxes: those around the areas, relative to the grid's corner.
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
    """Whether each area touches the cell at its column and row."""
    middle_x, middle_y, tx, ty, length, reach = areas.T
    x = corner[0] + ix * size - middle_x
    y = corner[1] + iy * size - middle_y
    dx = np.maximum(np.maximum(x, -x - size), 0.0)
    dy = np.maximum(np.maximum(y, -y - size), 0.0)
    near: npt.NDArray[np.bool_] = dx * dx + dy * dy <= reach * reach
    line = length > 0.0
    if line.any():  # a line's distance to the cell's centre, less half the cell's diagonal
        x, y, tx, ty, length = (each[line] for each in (x, y, tx, ty, length))
        x += 0.5 * size
        y += 0.5 * size
        along = np.clip(x * tx + y * ty, 0.0, length)
        dx, dy, far = x - along * tx, y - along * ty, reach[line] + 0.7072 * size
        near[line] = dx * dx + dy * dy <= far * far
    return near
