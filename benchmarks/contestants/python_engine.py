"""Base class for engines that are C libraries with a Python binding: many balls in one world."""

from abc import abstractmethod
from typing import Protocol

import numpy as np

from benchmarks.contestants.common import LONGEST, Contestant, Floats, Paths, poll_steps, steps_of
from benchmarks.harness.clock import seconds_of
from plinko.engine import Board

WORLD_BALLS = 10
"""Balls in a timed world. With fewer, the calls from Python cost more per ball; with more, the
broad phase examines more pairs, which cannot touch anyway. Both libraries are fastest near ten."""


class Scene(Protocol):
    """A world with all balls, which pass through each other."""

    def step(self) -> None:
        """Advance by one step."""

    def read(self, positions: Floats, velocities: Floats) -> None:
        """Write all states in m and m/s into arrays of shape (n, 2)."""


class PythonEngine(Contestant):
    """Many balls in one world, so that the cost of a call from Python is shared by all of them."""

    @abstractmethod
    def scene(self, board: Board, xs: Floats, dt: float) -> Scene:
        """A world with a ball at rest at each of `xs`."""

    def seconds(self, board: Board, xs: Floats, dt: float) -> float:
        """Wall seconds of the steps, without the checks whether all balls have landed."""
        parts = [xs[i : i + WORLD_BALLS] for i in range(0, len(xs), WORLD_BALLS)]
        return sum(self._seconds(board, part, dt) for part in parts)

    def _seconds(self, board: Board, xs: Floats, dt: float) -> float:
        scene = self.scene(board, xs, dt)
        positions, velocities = np.empty((2, len(xs), 2))
        total = 0.0

        def work() -> None:
            for _ in range(poll_steps(dt)):
                scene.step()

        for _ in range(int(LONGEST / dt) // poll_steps(dt)):
            total += seconds_of(work)
            scene.read(positions, velocities)
            if (positions[:, 1] >= board.bins.y).all():
                break
        return total

    def paths(self, board: Board, xs: Floats, dt: float, duration: float) -> Paths:
        scene = self.scene(board, xs, dt)
        steps = steps_of(duration, dt)
        positions, velocities = np.empty((2, steps + 1, len(xs), 2))
        scene.read(positions[0], velocities[0])
        for row in range(1, steps + 1):
            scene.step()
            scene.read(positions[row], velocities[row])
        return Paths(dt, positions, velocities)
