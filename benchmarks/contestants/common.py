"""The interface of a contestant, and the figures that are computed from its paths."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import ceil, exp

import numpy as np
import numpy.typing as npt

from plinko.engine import Board
from plinko.engine.board.materials import Material, combine

Floats = npt.NDArray[np.float64]

POLL = 0.25
"""Simulated seconds between two checks whether all balls have landed."""

LONGEST = 60.0
"""Simulated seconds after which a timed run gives up on balls that have not landed."""


BALLS_AT_ONCE = 100
"""Balls whose whole paths are in memory at a time, if only their bins are needed."""


class AbsentError(Exception):
    """A contestant cannot take part; the message says why and how to fix it."""


@dataclass(frozen=True)
class Paths:
    """States at steps of dt: positions in m and velocities in m/s, shape (steps + 1, n, 2)."""

    dt: float
    positions: Floats
    velocities: Floats

    def at(self, times: Floats) -> Floats:
        """Positions of ball i at times[i, j], shape (n, m, 2), interpolated linearly between steps.

        A renderer does the same. The error is at most g dt^2 / 8, far below a step's own error.
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
        """The bin where each ball first crossed the bins' line, shape (n,); -1 if it never did."""
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
        """Largest overlap of a ball with a peg at any step, in m."""
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
    """An engine that can drop many balls at once, which do not touch each other."""

    name: str
    stepped = True  # has a time step to choose

    @abstractmethod
    def seconds(self, board: Board, xs: Floats, dt: float) -> float:
        """Wall seconds on one core to drop balls from `xs` until all have landed.

        Setting up the board and reading positions is not counted.
        """

    @abstractmethod
    def paths(self, board: Board, xs: Floats, dt: float, duration: float) -> Paths:
        """All states during `duration` seconds of balls dropped at rest from `xs`, in m."""

    def bins(self, board: Board, xs: Floats, dt: float, duration: float) -> npt.NDArray[np.int64]:
        """The bin of each ball that has landed by `duration`, otherwise -1, shape (n,)."""
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
    """positions in m, shape (n, m, 2); bins, -1 if not landed, shape (n,); deepest overlap in m."""

    positions: Floats
    bins: npt.NDArray[np.int64]
    deepest: float


def pairs(board: Board) -> tuple[Material, Material]:
    """Restitution and friction of the ball with a peg, and with a wall."""
    ball = board.ball.material
    return combine(ball, board.peg_material), combine(ball, board.wall_material)


def steps_of(duration: float, dt: float) -> int:
    """Number of whole steps that cover a duration."""
    return ceil(duration / dt - 1e-9)


def poll_steps(dt: float) -> int:
    """Steps between two checks whether all balls have landed."""
    return max(1, round(POLL / dt))


def decay_of(board: Board, dt: float) -> float:
    """The factor exp(-k dt) by which drag slows a ball during dt."""
    return exp(-board.drag * dt)
