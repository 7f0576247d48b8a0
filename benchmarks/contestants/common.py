"""What every contestant is asked for, and what is read off its paths."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import ceil, exp

import numpy as np
import numpy.typing as npt

from engine import Board
from engine.board.materials import Material, combine

Floats = npt.NDArray[np.float64]

POLL = 0.25
"""Seconds of simulated time between two looks at whether all balls have landed."""

LONGEST = 60.0
"""Simulated seconds after which a timed run gives up on balls that have not landed."""


BALLS_AT_ONCE = 100
"""Balls whose whole paths are held in memory at a time when only their ends are wanted."""


class AbsentError(Exception):
    """A contestant that cannot take part; the message says why and what would help."""


@dataclass(frozen=True)
class Paths:
    """States at steps of dt: positions in m and velocities in m/s, shape (steps + 1, n, 2)."""

    dt: float
    positions: Floats
    velocities: Floats

    def at(self, times: Floats) -> Floats:
        """Positions at times[i, j] of ball i, shape (n, m, 2), between steps by a straight line.

        That is what a renderer does. It costs at most g dt^2 / 8, far below a step's own error.
        """
        last = len(self.positions) - 2
        row = np.clip((times / self.dt).astype(np.int64), 0, last)
        part = (times / self.dt - row)[..., None]
        ball = np.arange(times.shape[0])[:, None]
        found: Floats = (1.0 - part) * self.positions[row, ball] + part * self.positions[
            row + 1, ball
        ]
        return found

    def landings(self, board: Board) -> npt.NDArray[np.int64]:
        """Bin of each ball, shape (n,), where it first passed the bins' line; -1 if it did not."""
        height = self.positions[..., 1]
        below = height >= board.bins.y
        row = np.maximum(below.argmax(axis=0), 1)
        ball = np.arange(height.shape[1])
        top, bottom = height[row - 1, ball], height[row, ball]
        rise = np.where(bottom > top, bottom - top, 1.0)
        part = (board.bins.y - top) / rise
        x = self.positions[row - 1, ball, 0] * (1.0 - part) + self.positions[row, ball, 0] * part
        inner = np.array(board.bins.edges[1:-1])
        found: npt.NDArray[np.int64] = np.where(
            below.any(axis=0), np.searchsorted(inner, x, side="right"), -1
        )
        return found

    def deepest(self, board: Board) -> float:
        """Largest depth in m by which a ball ever overlapped a peg; 0 if none did."""
        if not board.pegs:
            return 0.0
        pegs = np.array([(peg.x, peg.y, peg.radius) for peg in board.pegs])
        worst = 0.0
        for positions in self.positions:
            flying = positions[positions[:, 1] < board.bins.y]
            apart = np.hypot(
                flying[:, 0, None] - pegs[None, :, 0], flying[:, 1, None] - pegs[None, :, 1]
            )
            depth = board.ball.radius + pegs[None, :, 2] - apart
            worst = max(worst, float(depth.max(initial=0.0)))
        return worst


class Contestant(ABC):
    """An engine that can drop many balls at once that do not touch each other."""

    name: str
    stepped = True  # has a time step to choose

    @abstractmethod
    def seconds(self, board: Board, xs: Floats, dt: float) -> float:
        """Wall seconds on one core from the start of the drops from `xs` until all have landed.

        Setting the board up is not in it, and neither is reading positions.
        """

    @abstractmethod
    def paths(self, board: Board, xs: Floats, dt: float, duration: float) -> Paths:
        """All states over `duration` seconds of balls dropped at rest from `xs`, m."""

    def bins(self, board: Board, xs: Floats, dt: float, duration: float) -> npt.NDArray[np.int64]:
        """Bin in which each ball has landed by `duration`, -1 if in none, shape (n,)."""
        parts = [xs[i : i + BALLS_AT_ONCE] for i in range(0, len(xs), BALLS_AT_ONCE)]
        found = [self.paths(board, part, dt, duration).landings(board) for part in parts]
        return np.concatenate(found)

    def observe(
        self, board: Board, xs: Floats, dt: float, times: Floats, duration: float
    ) -> "Observation":
        """Positions of ball i at times[i, j], bins after `duration`, and the deepest overlap."""
        paths = self.paths(board, xs, dt, duration)
        return Observation(paths.at(times), paths.landings(board), paths.deepest(board))


@dataclass(frozen=True)
class Observation:
    """positions, m, shape (n, m, 2); bins, -1 for none, shape (n,); deepest overlap, m."""

    positions: Floats
    bins: npt.NDArray[np.int64]
    deepest: float


def pairs(board: Board) -> tuple[Material, Material]:
    """Restitution and friction of the ball with a peg, and with a wall."""
    ball = board.ball.material
    return combine(ball, board.peg_material), combine(ball, board.wall_material)


def steps_of(duration: float, dt: float) -> int:
    """Whole steps that cover a duration."""
    return ceil(duration / dt - 1e-9)


def poll_steps(dt: float) -> int:
    """Steps between two looks."""
    return max(1, round(POLL / dt))


def decay_of(board: Board, dt: float) -> float:
    """Part of its speed that drag leaves a ball after dt, exp(-k dt)."""
    return exp(-board.drag * dt)
