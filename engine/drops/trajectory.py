"""One ball followed from its start to its end: the bridge between drops and the kernels."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from engine.board.model import Board
from engine.exact import event_log
from engine.exact.board_arrays import arrays_of
from engine.exact.event_log import new_log
from engine.exact.outcome import MAX_EVENTS, MAX_TIME
from engine.exact.sampling import sample
from engine.exact.trace import trace
from engine.parameters import Solver, Stepped
from engine.physics import body
from engine.physics.contact import new_series
from engine.stepped.step import trace_stepped

Floats = npt.NDArray[np.float64]

_ROOM = 256  # rows of a first log; a longer drop is traced again with the room it asked for


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """The whole motion of one ball.

    start and end: states, shape (7,): t, x, y, vx, vy, theta, omega. events, shape (n, 6), and
    marks, shape (n, 2): the drop's log. segments: what `states_at` reads.
    """

    board: Board
    solver: Solver
    start: Floats
    end: Floats
    outcome: int
    bin: int
    events: Floats
    marks: npt.NDArray[np.int32]
    segments: Floats

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


def follow(board: Board, x: float, solver: Solver) -> Trajectory:
    """Trajectory of a ball that starts at rest at (x, drop.y)."""
    start = np.zeros(body.SIZE)
    start[body.X] = x
    start[body.Y] = board.drop.y
    return follow_from(board, start, solver)


def follow_from(
    board: Board, start: Floats, solver: Solver, max_events: int = MAX_EVENTS
) -> Trajectory:
    """Trajectory of a ball from the state `start`, shape (7,): t, x, y, vx, vy, theta, omega."""
    layout = arrays_of(board)
    rows, pieces = _ROOM, 4 * _ROOM
    while True:
        log = new_log(rows, pieces)
        end = start.copy()
        if isinstance(solver, Stepped):
            outcome, where = trace_stepped(
                layout, end, solver.h, solver.correction, max_events, log
            )
        else:
            outcome, where = trace(layout, end, max_events, MAX_TIME, log)
        needed, needed_pieces = (
            int(log.counts[event_log.EVENTS]),
            int(log.counts[event_log.SEGMENTS]),
        )
        if needed <= rows and needed_pieces <= pieces:
            break
        rows, pieces = max(rows, needed), max(pieces, needed_pieces)
    return Trajectory(
        board=board,
        solver=solver,
        start=start,
        end=end,
        outcome=int(outcome),
        bin=int(where),
        events=log.events[:needed].copy(),
        marks=log.marks[:needed].copy(),
        segments=log.segments[:needed_pieces].copy(),
    )


def start_row(trajectory: Trajectory) -> Floats:
    """x, y, vx, vy, omega at the start, as a digest takes them."""
    return trajectory.start[[body.X, body.Y, body.X + 2, body.Y + 2, body.THETA + 1]]
