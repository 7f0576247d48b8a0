"""The balls of a world with the exact solver: whole flights, sampled at the world's clock."""

from typing import Any

import numpy as np

from plinko.engine.board.model import Board
from plinko.engine.drops.flight import Flight, fly
from plinko.engine.drops.trajectory import Trajectory, at_start
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import BoardArrays, arrays_of
from plinko.engine.exact.sampling import sample
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats
from plinko.engine.physics.contact import new_series
from plinko.engine.world.events import End, Progress

_PER_BALL = ("_ticks", "_first", "_last", "_event", "_next_time", "states")


class ExactBalls:
    """Balls of the exact solver. A step samples their flights, and costs the same for any step.

    states, shape (n, 7): t (s since a ball's own start), x, y, vx, vy, theta, omega of each ball.

    `_pool` has the segments of all flights, one after another: those of a ball are rows up to
    `_last` - 1, and `_first` is the current one. `_event` is its next event, at `_next_time`; after
    the last event that is the flight's end. The board's arrays are dropped when there is no ball.
    """

    def __init__(self, board: Board, dt: float) -> None:
        self._board = board
        self._arrays: BoardArrays | None = None
        self._dt = dt
        self._flights: list[Flight] = []
        self._ticks = np.zeros(0, np.int64)
        self._first = np.zeros(0, np.int64)
        self._last = np.zeros(0, np.int64)
        self._event = np.zeros(0, np.int64)
        self._next_time = np.zeros(0)
        self._pool = np.empty((0, event_log.SEGMENT_SIZE))
        self._used = 0
        self._series = new_series()
        self.states = np.zeros((0, body.SIZE))

    @property
    def events(self) -> int:
        return sum(len(flight.trajectory.impacts) for flight in self._flights)

    def add(self, x: float) -> None:
        self.add_flight(fly(self._board, x), 0)

    def add_flight(self, flight: Flight, ticks: int) -> tuple[Floats, Progress | None]:
        """Append a ball that started `ticks` steps ago.

        Returns its state one step ago, and its progress in the last step, if any.
        """
        start = at_start(self._board, flight.x_start)
        self._flights.append(flight)
        self._ticks = np.append(self._ticks, max(ticks - 1, 0))
        self._first = np.append(self._first, self._used)
        self._put(flight.trajectory.segments)
        self._last = np.append(self._last, self._used)
        self._event = np.append(self._event, 0)
        self._next_time = np.append(self._next_time, 0.0)
        self.states = np.vstack([self.states, start])
        row = len(self._flights) - 1
        self._progress(row)
        if not ticks:
            return start, None
        self._sample(slice(row, row + 1))
        before = self.states[row].copy()
        self._ticks[row] += 1
        self._sample(slice(row, row + 1))
        passed = self._next_time[row] <= self._ticks[row] * self._dt
        return before, self._progress(row) if passed else None

    def _put(self, segments: Floats) -> None:
        """Append segments to the pool; drop those of removed balls if it must grow."""
        end = self._used + len(segments)
        if end > len(self._pool):
            parts = [flight.trajectory.segments for flight in self._flights[:-1]]
            live = sum(map(len, parts))
            pool = np.empty((max(256, 2 * (live + len(segments))), event_log.SEGMENT_SIZE))
            begin = 0
            for row, part in enumerate(parts):
                pool[begin : begin + len(part)] = part
                self._first[row] += begin + len(part) - self._last[row]
                self._last[row] = begin = begin + len(part)
            self._first[-1] = begin
            self._pool, self._used, end = pool, begin, begin + len(segments)
        self._pool[self._used : end] = segments
        self._used = end

    def whole(self, row: int) -> Trajectory:
        """The whole trajectory of the ball in `row`, including its future."""
        return self._flights[row].trajectory

    def step(self, ticks: int = 1) -> list[Progress]:
        """Advance all balls; return the progress of balls with events, by row."""
        self._ticks += ticks
        self._sample(slice(None))
        due = self._next_time <= self._ticks * self._dt
        return [self._progress(int(row)) for row in np.flatnonzero(due)]

    def _sample(self, rows: slice) -> None:
        if self._arrays is None:
            self._arrays = arrays_of(self._board)
        times = np.multiply(self._ticks[rows], self._dt, dtype=np.float64)
        sample(
            self._arrays, self._pool, self._first[rows], self._last[rows], times, False,
            self._series, self.states[rows],
        )  # fmt: skip

    def _progress(self, row: int) -> Progress:
        """The events of a ball since the last call."""
        flight, time = self._flights[row], float(self._ticks[row] * self._dt)
        impacts, first = flight.trajectory.impacts, int(self._event[row])
        last = first + int(impacts["t"][first:].searchsorted(time, side="right"))
        self._event[row] = last
        self._next_time[row] = impacts["t"][last] if last < len(impacts) else flight.duration
        end = self._end(flight) if flight.duration <= time else None
        return Progress(row, impacts[first:last], end)

    def _end(self, flight: Flight) -> End:
        path, ticks = flight.trajectory, flight.ticks(self._dt)
        return End(path.outcome, path.bin, flight.duration, flight.x_end, flight.digest, ticks)

    def remove(self, rows: list[int]) -> None:
        self._flights = [each for row, each in enumerate(self._flights) if row not in rows]
        for name in _PER_BALL:
            setattr(self, name, np.delete(getattr(self, name), rows, axis=0))
        if not self._flights:
            self._arrays, self._used = None, 0

    def saved(self) -> list[dict[str, Any]]:
        """The start and the age of each ball, from which `load` computes everything else."""
        return [
            {"x": flight.x_start, "frames": int(ticks)}
            for flight, ticks in zip(self._flights, self._ticks, strict=True)
        ]

    def load(self, balls: list[dict[str, Any]]) -> None:
        for ball in balls:
            self.add_flight(fly(self._board, ball["x"]), ball["frames"])
