"""The events of a world, contacts and landings, and what a solver says of its balls."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import KIND_PEG


@dataclass(frozen=True, slots=True)
class End:
    """How a ball's drop ended: outcome (`plinko.engine.exact.outcome`), bin or -1, t in s, x in m.

    ticks: from the ball's start to the first tick at or after the end; None: that is this tick.
    """

    outcome: int
    bin: int
    t: float
    x: float
    digest: str
    ticks: int | None = None


@dataclass(frozen=True, slots=True)
class Progress:
    """The new events of the ball in `row` of `states` in one step, and its end if it has ended.

    impacts, shape (n,), has dtype `plinko.engine.drops.trajectory.IMPACT`.
    """

    row: int
    impacts: npt.NDArray[np.void]
    end: End | None


@dataclass(frozen=True, slots=True)
class Contact:
    """A ball hit something: t in s since the ball's start, centre in m.

    kind: KIND_PEG or KIND_WALL. index: of the peg or wall. speed: before the impact, along the
    normal, in m/s.
    """

    ball: int
    t: float
    x: float
    y: float
    kind: int
    index: int
    speed: float


@dataclass(frozen=True, slots=True)
class Landing:
    """A ball's drop ended in `bin`, or with the reason `unsettled` and no bin.

    t: duration of the drop in s. tick: the world's first tick at or after the end.
    """

    ball: int
    seed: int | None
    tick: int
    t: float
    x_end: float
    bin: int | None
    score: float
    digest: str
    unsettled: str | None


Event = Contact | Landing


def approach_speed(board: Board, kind: int, index: int, after: tuple[float, ...]) -> float:
    """Normal speed in m/s before an impact, computed from x, y, vx, vy after it.

    0 if the impact left no normal speed to compute it from.
    """
    x, y, vx, vy = after
    if kind == KIND_PEG:
        peg, material = board.pegs[index], board.peg_material
        nx, ny = x - peg.x, y - peg.y
    else:
        wall, material = board.walls[index], board.wall_material
        tx, ty = wall.x2 - wall.x1, wall.y2 - wall.y1
        along = ((x - wall.x1) * tx + (y - wall.y1) * ty) / (tx * tx + ty * ty)
        along = min(max(along, 0.0), 1.0)
        nx, ny = x - wall.x1 - along * tx, y - wall.y1 - along * ty
    length = sqrt(nx * nx + ny * ny)
    restitution = max(material.restitution, board.ball.restitution)
    if length == 0.0 or restitution == 0.0:
        return 0.0
    return max((vx * nx + vy * ny) / (length * restitution), 0.0)
