"""From a board to the flat arrays that the kernels work on."""

from functools import lru_cache
from math import sqrt

import numpy as np
import numpy.typing as npt

from engine.board.materials import combine
from engine.board.model import Board
from engine.exact.grid import cells_of
from engine.physics.flight import HALF_WAY
from engine.physics.layout import (
    DISTANCE,
    DISTANCE2,
    FIRST_END,
    FIRST_LINE,
    INVERSE,
    ITEM_COLUMNS,
    LAST_END,
    LENGTH,
    LINE_SLOTS,
    NX,
    NY,
    TX,
    TY,
    Layout,
    X,
    Y,
)

# Cells and travel per mean peg spacing. Coarser cells make longer candidate lists, finer ones fill
# the cache; shorter travel makes more search windows. The time of a drop is flat around these.
_CELLS_PER_PITCH = 8.0
_TRAVEL_PER_PITCH = 0.35
_CELLS_PER_WALL = 500.0  # along a wall at most: its box of cells stays small however long it is


@lru_cache(maxsize=64)
def layout_of(board: Board) -> Layout:
    """The kernels' form of `board`; kept for the boards used last."""
    items = _items(board)
    pitch = _pitch(board)
    travel = _TRAVEL_PER_PITCH * pitch
    fine = min(_CELLS_PER_PITCH / pitch, _CELLS_PER_WALL / _longest_wall(board))
    cells = cells_of(items, board.ball.radius, HALF_WAY * travel, fine)
    pegs = combine(board.ball.material, board.peg_material)
    walls = combine(board.ball.material, board.wall_material)
    return Layout(
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
    row[INVERSE] = 1.0 / distance


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


def _centres(items: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """What the search reads of each surface, side by side in memory; one row more, of nothing.

    A cell without surfaces has item 0 in its head, which is read before it is known to be none.
    """
    centres = np.zeros((len(items) + 1, 3))
    centres[:-1] = items[:, [X, Y, DISTANCE2]]
    centres[:-1][items[:, DISTANCE] == 0.0, 2] = 0.0
    return centres
