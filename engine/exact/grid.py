"""The broad phase, a uniform grid: for each cell, the surfaces that a ball in it may soon touch."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from engine.jit.decorator import lean_kernel
from engine.physics import surface

MAX_CELLS = 1 << 20
"""Where surfaces are few and far apart, cells are coarser than asked for rather than more."""

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
    listed = [
        i
        for i, row in enumerate(items)
        if row[surface.DISTANCE] == 0.0 or row[surface.DISTANCE2] >= 0.0
    ]
    if not listed:
        nothing = np.zeros(0, np.uint32)
        starts = np.zeros(2, np.uint32)
        return Cells(0.0, 0.0, cells_per_metre, 0, 0, starts, nothing, heads_of(starts, nothing))
    areas = [_Area.of(items[i], radius, reach) for i in listed]
    left, top = (min(area.low[axis] for area in areas) for axis in (0, 1))
    width = max(area.high[0] for area in areas) - left
    height = max(area.high[1] for area in areas) - top
    while (width * cells_per_metre + 1.0) * (height * cells_per_metre + 1.0) > MAX_CELLS:
        cells_per_metre *= 0.5
    columns, rows = (int(side * cells_per_metre) + 1 for side in (width, height))
    found = [area.cells(left, top, cells_per_metre) for area in areas]
    cell = np.concatenate([ix + columns * iy for ix, iy in found])
    owner = np.repeat(listed, [len(ix) for ix, _ in found])
    order = np.lexsort((owner, cell))
    starts = np.searchsorted(cell[order], np.arange(columns * rows + 2)).astype(np.uint32)
    members = np.ascontiguousarray(owner[order], np.uint32)
    heads = heads_of(starts, members)
    return Cells(left, top, cells_per_metre, columns, rows, starts, members, heads)


class _Area(NamedTuple):
    """All points within `reach` of a surface's axis: a line, or of a circle its middle."""

    x: float
    y: float
    tx: float
    ty: float
    length: float
    reach: float

    @classmethod
    def of(cls, row: Floats, radius: float, reach: float) -> "_Area":
        # Rounding of what follows must not lose a cell that just touches.
        wider = 1.0 + 1e-9
        x, y, distance = row[[surface.X, surface.Y, surface.DISTANCE]].tolist()
        if distance > 0.0:
            return cls(x, y, 1.0, 0.0, 0.0, wider * (distance + reach))
        tx, ty, length = row[[surface.TX, surface.TY, surface.LENGTH]].tolist()
        return cls(x, y, tx, ty, length, wider * (radius + reach))

    @property
    def low(self) -> tuple[float, float]:
        x, y = self.x, self.y
        ends = min(x, x + self.length * self.tx), min(y, y + self.length * self.ty)
        return ends[0] - self.reach, ends[1] - self.reach

    @property
    def high(self) -> tuple[float, float]:
        x, y = self.x, self.y
        ends = max(x, x + self.length * self.tx), max(y, y + self.length * self.ty)
        return ends[0] + self.reach, ends[1] + self.reach

    def cells(self, left: float, top: float, cells_per_metre: float) -> tuple[Ints, Ints]:
        """Columns and rows of the cells that the area touches; a few more along a slanted line."""
        size = 1.0 / cells_per_metre
        spans = [
            np.arange(
                int((low - start) * cells_per_metre), int((high - start) * cells_per_metre) + 1
            )
            for low, high, start in zip(self.low, self.high, (left, top), strict=True)
        ]
        ix, iy = (each.ravel() for each in np.meshgrid(*spans, indexing="ij"))
        x = left + ix * size - self.x
        y = top + iy * size - self.y
        if self.length == 0.0:
            dx = np.maximum(np.maximum(x, -x - size), 0.0)
            dy = np.maximum(np.maximum(y, -y - size), 0.0)
            far = self.reach
        else:  # the line's distance from the cell's centre, less half the cell's diagonal
            x += 0.5 * size
            y += 0.5 * size
            along = np.clip(x * self.tx + y * self.ty, 0.0, self.length)
            dx = x - along * self.tx
            dy = y - along * self.ty
            far = self.reach + 0.7072 * size
        near = dx * dx + dy * dy <= far * far
        return ix[near], iy[near]
