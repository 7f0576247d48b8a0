"""The broad phase: a uniform grid whose cells list the surfaces that a ball in them may touch."""

from typing import NamedTuple

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.physics import surface
from plinko.engine.physics.array_types import Indices
from plinko.engine.physics.surface import Surfaces

MAX_CELLS = 1 << 17
"""Cells of one grid, about a megabyte. On a larger board the cells are larger instead."""

MAX_LISTED = 1 << 19
"""Cells in the boxes around all surfaces together. If many surfaces overlap, the cells are made
larger until this holds."""


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


class Area(NamedTuple):
    """All points within `reach` of an axis: a line from (x, y), or a point, whose length is 0."""

    x: float  # m
    y: float
    tx: float  # unit vector along the axis
    ty: float
    length: float
    reach: float


@inner_kernel
def _area_of(items: Surfaces, item: int, radius: float, reach: float) -> Area:
    """The places from which a ball's centre can touch a surface within `reach`."""
    wider = 1.0 + 1e-9  # so that rounding below does not omit a cell that just touches
    x = items[item, surface.X]
    y = items[item, surface.Y]
    distance = items[item, surface.DISTANCE]
    if distance > 0.0:
        return Area(x, y, 1.0, 0.0, 0.0, wider * (distance + reach))
    tx = items[item, surface.TX]
    ty = items[item, surface.TY]
    return Area(x, y, tx, ty, items[item, surface.LENGTH], wider * (radius + reach))


@inner_kernel
def _box_of(area: Area, left: float, top: float) -> tuple[float, float, float, float]:
    """An area's least and greatest x and y, relative to (left, top), in m."""
    end_x = area.x + area.length * area.tx
    end_y = area.y + area.length * area.ty
    return (
        min(area.x, end_x) - area.reach - left,
        max(area.x, end_x) + area.reach - left,
        min(area.y, end_y) - area.reach - top,
        max(area.y, end_y) + area.reach - top,
    )


@inner_kernel
def _touches(area: Area, x: float, y: float, size: float) -> bool:
    """Whether an area touches a cell, whose corner is at (x, y) relative to the area's first point.

    Of a slanted line, a few cells that it does not touch count too.
    """
    if area.length == 0.0:
        dx = max(x, -x - size, 0.0)
        dy = max(y, -y - size, 0.0)
        return bool(dx * dx + dy * dy <= area.reach * area.reach)
    x = x + 0.5 * size
    y = y + 0.5 * size
    along = min(max(x * area.tx + y * area.ty, 0.0), area.length)
    dx = x - along * area.tx
    dy = y - along * area.ty
    far = area.reach + 0.7072 * size  # half the cell's diagonal
    return bool(dx * dx + dy * dy <= far * far)


@inner_kernel
def cells_of(items: Surfaces, radius: float, reach: float, cells_per_metre: float) -> Cells:
    """A grid whose cells list each surface that a ball in them can touch within `reach`, in m.

    cells_per_metre: the resolution, reduced if the grid would exceed MAX_CELLS or MAX_LISTED.
    """
    left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
    for item in range(len(items)):
        if items[item, surface.OWNER] == item:
            box = _box_of(_area_of(items, item, radius, reach), 0.0, 0.0)
            left, right = min(left, box[0]), max(right, box[1])
            top, bottom = min(top, box[2]), max(bottom, box[3])
    columns = rows = 0
    if left > right:  # no surface
        left = top = 0.0
    else:
        width, height = right - left, bottom - top
        while (width * cells_per_metre + 1.0) * (height * cells_per_metre + 1.0) > MAX_CELLS or (
            _listed(items, radius, reach, left, top, cells_per_metre) > MAX_LISTED
        ):
            cells_per_metre *= 0.75
        columns = int(width * cells_per_metre) + 1
        rows = int(height * cells_per_metre) + 1
    starts = np.zeros(columns * rows + 2, np.uint32)
    heads = np.zeros(columns * rows + 1, np.uint32)
    nothing = np.zeros(0, np.uint32)
    frame = Cells(left, top, cells_per_metre, columns, rows, starts, nothing, heads)
    _visit(items, radius, reach, frame, False)
    for cell in range(columns * rows + 1):
        starts[cell + 1] += starts[cell]
    members = np.zeros(int(starts[columns * rows + 1]), np.uint32)
    cells = Cells(left, top, cells_per_metre, columns, rows, starts, members, heads)
    _visit(items, radius, reach, cells, True)
    for cell in range(columns * rows + 1):
        if heads[cell] > 0:
            many = min(int(heads[cell]), HEAD_MANY)
            heads[cell] = int(members[starts[cell]]) | (many << HEAD_BITS)
    return cells


@inner_kernel
def _listed(
    items: Surfaces, radius: float, reach: float, left: float, top: float, cells_per_metre: float
) -> int:
    """The number of cells in the boxes around all surfaces."""
    count = 0
    for item in range(len(items)):
        if items[item, surface.OWNER] == item:
            x0, x1, y0, y1 = _box_of(_area_of(items, item, radius, reach), left, top)
            wide = int(x1 * cells_per_metre) - int(x0 * cells_per_metre) + 1
            high = int(y1 * cells_per_metre) - int(y0 * cells_per_metre) + 1
            count += wide * high
    return count


@inner_kernel
def _visit(items: Surfaces, radius: float, reach: float, cells: Cells, fills: bool) -> None:
    """Visit all cells that surfaces touch, to count their members in the next cell's `starts`, or
    to write the members; then `heads` counts those that are written."""
    size = 1.0 / cells.cells_per_metre
    for item in range(len(items)):
        if items[item, surface.OWNER] != item:
            continue
        area = _area_of(items, item, radius, reach)
        x0, x1, y0, y1 = _box_of(area, cells.left, cells.top)
        for ix in range(int(x0 * cells.cells_per_metre), int(x1 * cells.cells_per_metre) + 1):
            for iy in range(int(y0 * cells.cells_per_metre), int(y1 * cells.cells_per_metre) + 1):
                x = cells.left + ix * size - area.x
                y = cells.top + iy * size - area.y
                if not _touches(area, x, y, size):
                    continue
                cell = ix + cells.columns * iy
                if fills:
                    cells.members[int(cells.starts[cell]) + int(cells.heads[cell])] = item
                    cells.heads[cell] += 1
                else:
                    cells.starts[cell + 1] += 1
