"""How certain the bin of a drop is, under rounding and a small change of the start."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from plinko.engine.drops.trajectory import Trajectory, at_start, follow
from plinko.engine.errors import ParameterError
from plinko.engine.exact import sensitivity
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.outcome import LANDED
from plinko.engine.parameters import Exact

MARGIN = 16.0
"""A bin is certain if its edges are more than this many estimated errors away from the landing."""


@dataclass(frozen=True, eq=False, repr=False)
class Certainty:
    """The effect of small changes on one drop of the exact solver.

    growth and errors, shape (events,), have one value for each event of the drop, in order. growth:
    how far the event's place moves per metre that the start moves in x. errors: estimated error of
    the place in m, from half a unit in the last place of the start and all rounding since.
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
        """Whether the ball landed in a bin."""
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
        """Whether the bin stays the same if the start moves by half a unit in the last place.

        The estimate is linear and does not notice a peg that a neighbouring path just misses. So
        the nearest starts on both sides must also land in the same bin.
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
        paths = (follow(path.board, start, Exact()) for start in nearest_starts)
        return all(other.outcome == LANDED and other.bin == path.bin for other in paths)


def _unit(path: Trajectory) -> float:
    """A unit in the last place of the start or of the ball's radius, whichever is larger; m."""
    return max(float(np.spacing(abs(path.start[1]))), float(np.spacing(path.board.ball.radius)))


def certainty_of(path: Trajectory) -> Certainty:
    """Compute tangents along a path; ParameterError if it is not from the exact solver."""
    if not isinstance(path.solver, Exact):
        raise ParameterError(
            f"solver {path.solver.name!r} cannot tell how certain a bin is: use 'exact'",
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
