"""The balls of a world, stepped together: what every solver's set of them can do and tells."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class End:
    """How a ball's drop ended: outcome (engine.exact.outcome), bin or -1, t in s, x in m."""

    outcome: int
    bin: int
    t: float
    x: float
    digest: str


@dataclass(frozen=True, slots=True)
class Progress:
    """What one step did to the ball in `row` of `states`: its new events and, if it ended, how.

    events, shape (n, 6), and marks, shape (n, 2), are rows of an event log.
    """

    row: int
    events: Floats
    marks: npt.NDArray[np.int32]
    end: End | None


class BallSet(Protocol):
    """Balls of one board that do not touch each other, one in each row of `states`."""

    states: Floats
    """Shape (n, 7): t (s since the ball's own start), x, y, vx, vy, theta, omega."""

    @property
    def prepared(self) -> bool:
        """Whether all is made of the board that these balls need."""

    def prepare(self) -> None:
        """Make it, on any thread."""

    @property
    def ready(self) -> bool:
        """Whether the next step takes no more than moving the balls."""

    def look_ahead(self) -> bool:
        """Do a little of what later steps need; whether there is more that would help."""

    def add(self, x: float) -> None:
        """Append a ball at rest at (x, drop.y), m."""

    def step(self) -> list[Progress]:
        """Advance all balls by one step of the world; what became of some, by rising row."""

    def remove(self, rows: list[int]) -> None:
        """Take out balls whose drop has ended."""

    def saved(self) -> list[dict[str, Any]]:
        """What `load` needs of each ball, for msgpack."""

    def load(self, balls: list[dict[str, Any]]) -> None:
        """Append saved balls."""
