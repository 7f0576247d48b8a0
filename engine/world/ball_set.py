"""`BallSet`: the interface of a world's balls, which each solver implements."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from plinko.engine.physics.array_types import Floats


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


class BallSet(Protocol):
    """Balls of one board that do not touch each other, one in each row of `states`."""

    states: Floats
    """Shape (n, 7): t (s since the ball's own start), x, y, vx, vy, theta, omega."""

    def add(self, x: float) -> None:
        """Append a ball at rest at (x, drop.y) in m."""

    def step(self) -> list[Progress]:
        """Advance all balls by one step; return the progress of balls with events, by row."""

    def remove(self, rows: list[int]) -> None:
        """Remove balls whose drop has ended."""

    def saved(self) -> list[dict[str, Any]]:
        """The values, for msgpack, from which `load` restores each ball."""

    def load(self, balls: list[dict[str, Any]]) -> None:
        """Append balls from the values of `saved`."""
