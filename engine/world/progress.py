"""What a step of a world's balls tells of each: its events and, if its drop ended, how."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class End:
    """How a ball's drop ended."""

    outcome: int
    bin: int
    t: float
    x: float
    digest: str


@dataclass(frozen=True, slots=True)
class Progress:
    """What one step did to the ball in `row`: events (n, 6), marks (n, 2), and its end if any.

    speeds (n,): the approaches in m/s, where they do not follow from the events.
    """

    row: int
    events: Floats
    marks: npt.NDArray[np.int32]
    end: End | None
    speeds: Floats | None = None
