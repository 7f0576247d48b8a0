"""Lays out an arena's pegs and walls: their items, and the grid that finds those near a ball."""

from math import sqrt

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, kernel
from plinko.engine.multibody.solver.layout import shape
from plinko.engine.multibody.solver.layout.array_types import Floats, Ints
from plinko.engine.multibody.solver.layout.shape import StaticShapes

CELLS = 64
"""Most cells along the grid's longer side. With finer cells a long wall is listed in more of them;
with coarser ones a ball has more pegs to test. With 64, a cell of a board has a peg or two."""


@kernel
def lay_out_shapes(
    pegs: Floats, walls: Floats, peg_restitution: float, peg_friction: float,
    wall_restitution: float, wall_friction: float, x0: float, x1: float, y0: float, y1: float,
    bins_y: float,
) -> StaticShapes:  # fmt: skip
    """pegs, (n, 3): x, y and radius; walls, (m, 4): x1, y1, x2, y2; x0 to y1: the box around all
    parts. All in m."""
    items = np.zeros((len(pegs) + len(walls), shape.COLUMNS))
    for i in range(len(items)):
        items[i, shape.TX] = 1.0
        items[i, shape.RESTITUTION] = peg_restitution
        items[i, shape.FRICTION] = peg_friction
        if i < len(pegs):
            items[i, shape.X1] = pegs[i, 0]
            items[i, shape.Y1] = pegs[i, 1]
            items[i, shape.RADIUS] = pegs[i, 2]
            continue
        wall = walls[i - len(pegs)]
        dx = wall[2] - wall[0]
        dy = wall[3] - wall[1]
        length = sqrt(dx * dx + dy * dy)
        items[i, shape.X1] = wall[0]
        items[i, shape.Y1] = wall[1]
        items[i, shape.TX] = dx / length
        items[i, shape.TY] = dy / length
        items[i, shape.LENGTH] = length
        items[i, shape.RESTITUTION] = wall_restitution
        items[i, shape.FRICTION] = wall_friction
    side = max(x1 - x0, y1 - y0, 1e-9)
    count = min(CELLS, max(1, int(sqrt(32.0 * len(items)))))
    scale = count / side
    columns = int((x1 - x0) * scale) + 1
    rows = int((y1 - y0) * scale) + 1
    starts = np.zeros(columns * rows + 1, np.int32)
    at = np.zeros(columns * rows, np.int32)
    _visit(items, x0, y0, scale, columns, rows, starts[1:], at[:0], False)
    for cell in range(columns * rows):
        starts[cell + 1] += starts[cell]
        at[cell] = starts[cell]
    members = np.zeros(starts[columns * rows], np.int32)
    _visit(items, x0, y0, scale, columns, rows, at, members, True)
    return StaticShapes(items, len(pegs), x0, y0, scale, columns, rows, starts, members, bins_y)


@inner_kernel
def _visit(
    items: Floats, x0: float, y0: float, scale: float, columns: int, rows: int, at: Ints,
    members: Ints, fills: bool,
) -> None:  # fmt: skip
    """Advance `at` of a cell for each item that passes through it; write the members at it."""
    size = 1.0 / scale
    for item in range(len(items)):
        x, y = items[item, shape.X1], items[item, shape.Y1]
        tx, ty, length = items[item, shape.TX], items[item, shape.TY], items[item, shape.LENGTH]
        thickness = items[item, shape.RADIUS]
        end_x, end_y = x + length * tx, y + length * ty
        low = max(int((min(x, end_x) - thickness - x0) * scale) - 1, 0)
        high = min(int((max(x, end_x) + thickness - x0) * scale) + 1, columns - 1)
        top = max(int((min(y, end_y) - thickness - y0) * scale) - 1, 0)
        bottom = min(int((max(y, end_y) + thickness - y0) * scale) + 1, rows - 1)
        near = thickness + 0.7072 * size * (1.0 + 1e-6)
        for row in range(top, bottom + 1):
            for column in range(low, high + 1):
                dx = x0 + (column + 0.5) * size - x
                dy = y0 + (row + 0.5) * size - y
                along = min(max(dx * tx + dy * ty, 0.0), length)
                dx -= along * tx
                dy -= along * ty
                if dx * dx + dy * dy <= near * near:
                    cell = row * columns + column
                    if fills:
                        members[at[cell]] = item
                    at[cell] += 1
