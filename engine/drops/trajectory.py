"""Computes one ball's trajectory from start to end: the bridge between drops and the kernels."""

from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.engine.board.cache import BoardCache
from plinko.engine.board.fields import BoardFields
from plinko.engine.canonical import float_bits
from plinko.engine.constants import MAX_TIME
from plinko.engine.drops.digest import drop_digest
from plinko.engine.exact.board_arrays import BoardArrays, arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.initial_state import in_flight
from plinko.engine.exact.outcome import MAX_EVENTS
from plinko.engine.exact.sampling import sample
from plinko.engine.exact.trace import trace_many
from plinko.engine.jit.decorator import in_place
from plinko.engine.parameters import Exact, Solver, Stepped
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats
from plinko.engine.physics.contact import new_series
from plinko.engine.stepped.step import trace_stepped_many

_ROOM: Final = 256
"""Rows of the first log. Presets' drops need fewer; a drop that needs more is computed again."""

_KEPT: Final = 32 << 20
"""Bytes of flights that are cached for later drops; those of all presets take 19 MB."""

_MACHINE: Final = 1 << 19
"""Bytes of a flight without its board's arrays."""


IMPACT: Final = np.dtype(
    [(name, "<f8") for name in ("t", "x", "y", "vx", "vy", "omega")]
    + [("kind", "<i4"), ("index", "<i4")]
)
"""An impact: the state right after it (s, m, m/s, rad/s), its kind, and the index of the peg or
wall."""


def impacts_of(events: Floats, marks: npt.NDArray[np.int32]) -> npt.NDArray[np.void]:
    """The events, shape (n, 6), and marks, shape (n, 2), of a log as an array of dtype IMPACT."""
    rows = np.concatenate((float_bits(events), marks.view("<f8")), axis=1)
    return rows.view(IMPACT)[:, 0]


def events_in(impacts: npt.NDArray[np.void]) -> Floats:
    """t, x, y, vx, vy, omega of impacts, shape (n, 6)."""
    return impacts.view("<f8").reshape(-1, 7)[:, :6]


def marks_in(impacts: npt.NDArray[np.void]) -> npt.NDArray[np.int32]:
    """kind and index of impacts, shape (n, 2)."""
    return impacts.view("<i4").reshape(-1, 14)[:, 12:]


class Trajectory(msgspec.Struct, frozen=True, eq=False):
    """The whole motion of one ball.

    start and end: states, shape (7,): t, x, y, vx, vy, theta, omega. impacts, shape (n,), dtype
    IMPACT: all events, whose columns are `events`, shape (n, 6), and `marks`, shape (n, 2).
    segments: what `states_at` reads. All are read-only.
    """

    board: BoardFields
    solver: Solver
    start: Floats
    end: Floats
    outcome: int
    bin: int
    impacts: npt.NDArray[np.void]
    segments: Floats

    def __post_init__(self) -> None:
        for array in (self.start, self.end, self.impacts, self.segments):
            array.setflags(write=False)

    def __repr__(self) -> str:
        return f"<Trajectory on {self.board.name!r} of {len(self.impacts)} events>"

    @property
    def events(self) -> Floats:
        return events_in(self.impacts)

    @property
    def marks(self) -> npt.NDArray[np.int32]:
        return marks_in(self.impacts)

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
    """State of a ball at rest at x in m, at the height of the start; shape (7,)."""
    state = np.zeros(body.SIZE)
    state[body.X] = x
    state[body.Y] = board.drop.y
    return state


_IN_FLIGHT: Final = in_flight(1)


class _Flight:
    """A prepared call of a solver's kernel for one ball on a board, with the arrays it works on."""

    def __init__(
        self, arrays: BoardArrays, solver: Solver, max_events: int, max_time: float, rows: int
    ) -> None:
        log = new_log(rows, rows)
        state, initial = np.zeros((1, body.SIZE)), _IN_FLIGHT.copy()
        ends = np.empty(1, np.int8), np.empty(1, np.int32), np.empty(1, np.int32)
        if isinstance(solver, Stepped):
            self._call = in_place(
                trace_stepped_many,
                arrays, state, solver.h, solver.correction, max_events, log, *ends,
            )  # fmt: skip
            self._initial = initial
        else:
            self._call = in_place(
                trace_many,
                arrays, state, initial, max_events, max_time, new_series(), log, *ends,
            )  # fmt: skip
            self._initial = self._call.view(initial)
        view = self._call.view
        self._state = view(state)[0]
        self._events, self._marks = view(log.events), view(log.marks)
        self._segments, self._counts = view(log.segments), view(log.counts)
        self._outcome, self._bin = view(ends[0]), view(ends[1])

    def follow(self, board: BoardFields, start: Floats, solver: Solver) -> Trajectory | int:
        """Return the trajectory from `start`, or the rows that it needs if the log has fewer."""
        self._state[:] = start
        self._initial[:] = _IN_FLIGHT
        self._counts[:] = 0
        self._call.run()
        events, segments, _ = self._counts.tolist()
        rows: int = max(events, segments)
        if rows > len(self._events):
            return rows
        return Trajectory(
            board=board,
            solver=solver,
            start=start,
            end=self._state.copy(),
            outcome=int(self._outcome[0]),
            bin=int(self._bin[0]),
            impacts=impacts_of(self._events[:events], self._marks[:events]),
            segments=self._segments[:segments].copy(),
        )


class _Flights:
    """Idle flights on a board, with the parameters of most drops, for reuse by any thread."""

    def __init__(self, board: BoardFields) -> None:
        self.arrays = arrays_of(board)
        self._idle: list[_Flight] = []

    def take(self) -> _Flight:
        """Return an idle flight, or a new one; the caller returns it with `give`."""
        try:
            return self._idle.pop()
        except IndexError:
            return _Flight(self.arrays, Exact(), MAX_EVENTS, MAX_TIME, _ROOM)

    def give(self, flight: _Flight) -> None:
        self._idle.append(flight)


def _bytes_of(flights: _Flights) -> int:
    """Bytes of one flight; a board has more than one only if threads use it at the same time."""
    return _MACHINE + sum(each.nbytes for each in flights.arrays if isinstance(each, np.ndarray))


_flights_of: Final = BoardCache(_Flights, _bytes_of, _KEPT)


def prepare(board: BoardFields) -> None:
    """Prepare the first flight on a board, which takes 2 to 14 ms on a preset."""
    flights = _flights_of(board)
    flights.give(flights.take())


def follow(
    board: BoardFields,
    start: Floats,
    solver: Solver,
    max_events: int = MAX_EVENTS,
    max_time: float = MAX_TIME,
) -> Trajectory:
    """Return one ball's trajectory from the state `start`, (7,): t, x, y, vx, vy, theta, omega.

    It calls the kernels for many balls with one. The trajectory has at most about `max_events`
    events. The exact solver also ends it at the first event or segment after `max_time` in s.
    """
    rows = _ROOM
    if isinstance(solver, Exact) and max_events == MAX_EVENTS and max_time == MAX_TIME:
        flights = _flights_of(board)
        flight = flights.take()
        found = flight.follow(board, start, solver)
        flights.give(flight)  # not in a `finally`: a flight that has raised is not reused
        if isinstance(found, Trajectory):
            return found
        rows = found
    while True:
        flight = _Flight(arrays_of(board), solver, max_events, max_time, rows)
        found = flight.follow(board, start, solver)
        if isinstance(found, Trajectory):
            return found
        rows = found


def digest_of(board_digest: str, path: Trajectory) -> str:
    """The digest of the drop with this path, 64 hex digits."""
    _, x, y, vx, vy, _, omega = path.start.tolist()
    start = (x, y, vx, vy, omega)
    return drop_digest(board_digest, path.solver, start, path.outcome, path.impacts)
