"""Elastic discs in a box without gravity, by an event-driven program and by this engine.

Event-driven molecular dynamics supports no more: no gravity, friction, rest or lost energy.
"""

from typing import Any

import numpy as np

from benchmarks.contestants.common import AbsentError, Floats
from benchmarks.scenes.touching import DT, Gas
from plinko.engine import Arena, ArenaSettings


class Billiards:
    """python-billiards, which keeps the times of impact of all pairs in a NumPy table."""

    name = "billiards (PyPI)"

    def __init__(self, gas: Gas) -> None:
        try:
            import billiards
        except ImportError as error:
            raise AbsentError(f"billiards: {error}; pip install --group bench") from error
        corners = [(wall.x1, wall.y1) for wall in gas.heap.place.walls]
        walls = [
            billiards.InfiniteWall(a, b, inside="left")
            for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)
        ]
        self._world: Any = billiards.Billiard(walls)
        for x, y, vx, vy in zip(gas.heap.x, gas.heap.y, gas.vx, gas.vy, strict=True):
            self._world.add_ball((x, y), (vx, vy), gas.heap.radius)
        self._impacts = 0

    def run(self, seconds: float) -> None:
        """Advance by simulated `seconds`."""
        self._impacts += len(self._world.evolve(self._world.time + seconds))

    def impacts(self) -> int:
        """Number of impacts since the start."""
        return self._impacts

    def places(self) -> Floats:
        """Centres in m, shape (n, 2)."""
        return np.array(self._world.balls_position)

    def velocities(self) -> Floats:
        """In m/s, shape (n, 2)."""
        return np.array(self._world.balls_velocity)


class Ours:
    """The arena, with its default step and substeps."""

    name = "this engine"

    def __init__(self, gas: Gas) -> None:
        heap = gas.heap
        self._arena = Arena(heap.place, ArenaSettings(gravity=0.0, sleeping=False, dt=DT))
        self._arena.add_many(
            heap.x, heap.y, vx=gas.vx, vy=gas.vy, radius=heap.radius, restitution=1.0, friction=0.0
        )
        self._impacts = 0

    def run(self, seconds: float) -> None:
        """Advance by simulated `seconds`, in whole steps."""
        for _ in range(round(seconds / DT)):
            self._arena.step()

    def impacts(self) -> int:
        """Number of impacts since the start, including those that no event reported."""
        self._impacts += len(self._arena.take_events())
        return self._impacts + self._arena.events_lost

    def places(self) -> Floats:
        """Centres in m, shape (n, 2)."""
        bodies = self._arena.bodies
        return np.stack([bodies["x"], bodies["y"]], axis=1)

    def velocities(self) -> Floats:
        """In m/s, shape (n, 2)."""
        bodies = self._arena.bodies
        return np.stack([bodies["vx"], bodies["vy"]], axis=1)


CONTESTANTS = (Ours, Billiards)
