"""How sure the bin of a drop is, against rounding and against a start moved by half a unit."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from engine.drops.trajectory import Trajectory, at_start, follow
from engine.errors import ParameterError
from engine.exact import sensitivity
from engine.exact.board_arrays import arrays_of
from engine.exact.outcome import LANDED
from engine.parameters import Exact

MARGIN = 16.0
"""A bin is sure if its edges are this many estimated errors away from the landing."""


@dataclass(frozen=True, eq=False, repr=False)
class Certainty:
    """What small changes do to one drop of the exact solver.

    `growth` and `errors`, shape (events,), belong to the events of the drop in order: metres that
    the place of an event moves per metre that the start moves in x, and the estimated error of the
    place in m, from the start's half unit in the last place and all rounding since.
    """

    trajectory: Trajectory
    growth: npt.NDArray[np.float64]
    errors: npt.NDArray[np.float64]

    def __repr__(self) -> str:
        return (
            f"<Certainty: certain {self.certain}, amplification {self.amplification}, "
            f"error {self.error}>"
        )

    @property
    def landed(self) -> bool:
        """Whether there is a bin to be sure of."""
        return self.trajectory.outcome == LANDED

    @property
    def amplification(self) -> float | None:
        """Metres that x_end moves per metre that the start moves; None if the ball did not land."""
        return float(self.growth[-1]) if self.landed else None

    @property
    def error(self) -> float | None:
        """Estimated error of x_end in m; None if the ball did not land."""
        return float(self.errors[-1]) if self.landed else None

    @cached_property
    def certain(self) -> bool:
        """Whether the bin stands if the start moves by half a unit in the last place.

        The estimate is linear and cannot see a peg that a neighbouring path just misses. So the
        nearest starts on both sides are followed as well, and must land in the same bin.
        """
        if not self.landed:
            return False
        path = self.trajectory
        edges = np.array(path.board.bins.edges[1:-1])
        nearest = np.abs(edges - path.end[1]).min(initial=np.inf)
        if not nearest > MARGIN * self.errors[-1]:
            return False
        x, unit = float(path.start[1]), _unit(path)
        nearest_starts = (at_start(path.board, x + way * unit) for way in (-1, 1))
        beside = (follow(path.board, start, Exact()) for start in nearest_starts)
        return all(other.outcome == LANDED and other.bin == path.bin for other in beside)


def _unit(path: Trajectory) -> float:
    """A unit in the last place of the start, at least that of the lengths it is added to, m."""
    return max(float(np.spacing(abs(path.start[1]))), float(np.spacing(path.board.ball.radius)))


def certainty_of(path: Trajectory) -> Certainty:
    """Take tangents along a traced path; ParameterError if it is not of the exact solver."""
    if not isinstance(path.solver, Exact):
        raise ParameterError(
            f"the {path.solver.name} solver has no tangents; only 'exact' says how sure it is",
            field="solver",
        )
    moved = np.zeros((len(path.marks), sensitivity.TANGENTS))
    sensitivity.sensitivity(
        arrays_of(path.board), path.segments, path.events, path.marks,
        path.end, 0.5 * _unit(path), sensitivity.new_space(), moved,
    )  # fmt: skip
    growth, errors = moved[:, sensitivity.PATH].copy(), moved[:, sensitivity.ERROR].copy()
    for array in (growth, errors):
        array.setflags(write=False)
    return Certainty(path, growth, errors)
