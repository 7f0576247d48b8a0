"""One ball followed from its start to its end: the bridge between drops and the kernels."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from engine.board.fields import BoardFields
from engine.constants import MAX_TIME
from engine.exact import event_log
from engine.exact.board_arrays import arrays_of
from engine.exact.event_log import new_log
from engine.exact.initial_state import in_flight
from engine.exact.outcome import MAX_EVENTS
from engine.exact.sampling import sample
from engine.exact.trace import trace_many
from engine.parameters import Solver, Stepped
from engine.physics import body
from engine.physics.contact import new_series
from engine.stepped.step import trace_stepped_many

Floats = npt.NDArray[np.float64]

_ROOM = 256  # rows of a first log: presets' drops have fewer, others are traced again with more


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Trajectory:
    """The whole motion of one ball.

    start and end: states, shape (7,): t, x, y, vx, vy, theta, omega. events, shape (n, 6), and
    marks, shape (n, 2): the drop's log. segments: what `states_at` reads. All are read-only.
    """

    board: BoardFields
    solver: Solver
    start: Floats
    end: Floats
    outcome: int
    bin: int
    events: Floats
    marks: npt.NDArray[np.int32]
    segments: Floats

    def __post_init__(self) -> None:
        for array in (self.start, self.end, self.events, self.marks, self.segments):
            array.setflags(write=False)

    def __repr__(self) -> str:
        return f"<Trajectory on {self.board.name!r} of {len(self.events)} events>"

    def states_at(self, times: Floats) -> Floats:
        """States at `times`, shape (n,), in s since the start, as an array of shape (n, 7)."""
        out = np.empty((len(times), body.SIZE))
        ended = times >= self.end[body.T]
        if not ended.all():
            rows = np.searchsorted(self.segments[:, body.T], times, side="right") - 1
            sample(
                arrays_of(self.board), self.segments, rows, rows + 1, times,
                isinstance(self.solver, Stepped), new_series(), out,
            )  # fmt: skip
        out[ended] = self.end
        out[ended, body.T] = times[ended]
        return out


def at_start(board: BoardFields, x: float) -> Floats:
    """State of a ball at rest at x in m on the height of the start, shape (7,)."""
    state = np.zeros(body.SIZE)
    state[body.X] = x
    state[body.Y] = board.drop.y
    return state


def follow(
    board: BoardFields,
    start: Floats,
    solver: Solver,
    max_events: int = MAX_EVENTS,
    max_time: float = MAX_TIME,
) -> Trajectory:
    """Trajectory of one ball from the state `start`, shape (7,): t, x, y, vx, vy, theta, omega.

    The kernels are those of many balls, given one. It ends after `max_events` events at the latest;
    the exact solver ends it at the first event or stretch that begins after `max_time`, in s.
    """
    arrays = arrays_of(board)
    events = segments = _ROOM
    outcome, where, impacts = np.empty(1, np.int8), np.empty(1, np.int32), np.empty(1, np.int32)
    while True:
        log = new_log(events, segments)
        end = start.reshape(1, body.SIZE).copy()
        if isinstance(solver, Stepped):
            trace_stepped_many(
                arrays, end, solver.h, solver.correction, max_events, log, outcome, where, impacts
            )
        else:
            trace_many(
                arrays, end, in_flight(1), max_events, max_time, new_series(), log,
                outcome, where, impacts,
            )  # fmt: skip
        all_events, all_segments = (
            int(log.counts[event_log.EVENTS]),
            int(log.counts[event_log.SEGMENTS]),
        )
        if all_events <= events and all_segments <= segments:
            break
        events, segments = max(events, all_events), max(segments, all_segments)
    return Trajectory(
        board=board,
        solver=solver,
        start=start,
        end=end[0],
        outcome=int(outcome[0]),
        bin=int(where[0]),
        events=log.events[:all_events].copy(),
        marks=log.marks[:all_events].copy(),
        segments=log.segments[:all_segments].copy(),
    )


def start_row(trajectory: Trajectory) -> Floats:
    """x, y, vx, vy, omega at the start, as a digest takes them."""
    return trajectory.start[[body.X, body.Y, body.VX, body.VY, body.OMEGA]]
