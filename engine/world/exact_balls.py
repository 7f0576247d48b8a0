"""The balls of a world with the exact solver: followed a little ahead of its clock, looked up."""

from typing import Any, Final

import numpy as np

from engine.board.model import Board
from engine.drops.trajectory import Trajectory, at_start, follow
from engine.exact import event_log
from engine.exact.board_arrays import BoardArrays, arrays_of
from engine.exact.sampling import sample
from engine.parameters import Exact
from engine.physics import body
from engine.physics.contact import new_series
from engine.world.ball_set import Progress
from engine.world.exact_path import AHEAD, ExactPath

LARGE: Final = 500
"""Pegs and walls of a board from which on its arrays take more than a ms to make."""


class ExactBalls:
    """Balls of the exact solver: each path is followed in slices, and looked up where it is known.

    A path depends neither on when it is looked at nor on how it is sliced, so neither does
    anything here. A step follows what it needs itself; `look_ahead` before it makes it short.
    Where there is no ball, nothing is kept of the board but itself.
    """

    def __init__(self, board: Board, dt: float) -> None:
        self._board = board
        self._arrays: BoardArrays | None = None
        self._dt = dt
        self._paths: list[ExactPath] = []
        self._ticks = np.zeros(0, np.int64)
        self._first = np.zeros(0, np.int64)  # segments in use in the pool
        self._last = np.zeros(0, np.int64)
        self._begin = np.zeros(0, np.int64)  # of a ball's segments in the pool, past ones too
        self._passed = np.zeros(0, np.int64)  # segments of a ball before those in the pool
        self._next_time = np.zeros(0)
        self._known = np.zeros(0)
        self._kept = np.zeros(0, np.int64)  # events of a ball
        self._full = np.zeros(0, np.bool_)
        self._pool = np.empty((0, event_log.SEGMENT_SIZE))
        self._used = 0
        self._series = new_series()
        self.states = np.zeros((0, body.SIZE))

    def add(self, x: float) -> None:
        """Append a ball at rest at (x, drop.y)."""
        self.add_at(x, 0)

    def add_at(self, x: float, ticks: int) -> None:
        """Append a ball where it is so many steps after it was at rest at (x, drop.y)."""
        self._paths.append(ExactPath(self._board, x))
        self._ticks = np.append(self._ticks, ticks)
        for name in ("_first", "_last", "_begin"):
            setattr(self, name, np.append(getattr(self, name), self._used))
        self._passed = np.append(self._passed, 0)
        self._next_time = np.append(self._next_time, np.inf)
        self._known = np.append(self._known, 0.0)
        self._kept = np.append(self._kept, 0)
        self._full = np.append(self._full, False)
        self.states = np.vstack([self.states, at_start(self._board, x)])
        if ticks:
            self._go_on(len(self._paths) - 1)

    def _go_on(self, row: int) -> None:
        """Bring a ball that was saved to where it was."""
        path, time = self._paths[row], float(self._ticks[row] * self._dt)
        while (known := path.known) <= time:
            self._advance(row)
            self._look_up(row, known)  # so that what lies before may go
        self._look_up(row, time)

    def _look_up(self, row: int, time: float) -> None:
        """Put a ball where it is at a time in s before which its path is known."""
        path = self._paths[row]
        path.pass_to(time)
        self._next_time[row] = path.next_time()
        one = slice(row, row + 1)
        sample(
            self._made(), self._pool, self._first[one], self._last[one], np.array([time]), False,
            self._series, self.states[one],
        )  # fmt: skip

    # Following.

    @property
    def prepared(self) -> bool:
        """Whether the board's arrays are there, or not needed, or made within a ms."""
        if self._arrays is not None or not self._paths:
            return True
        return len(self._board.pegs) + len(self._board.walls) < LARGE

    def prepare(self) -> None:
        """Make the board's arrays, on any thread."""
        self._made()

    def _made(self) -> BoardArrays:
        if self._arrays is None:
            self._arrays = arrays_of(self._board)
        return self._arrays

    @property
    def known(self) -> list[float]:
        """For each ball the time in s since its start before which its path is known."""
        found: list[float] = self._known.tolist()
        return found

    @property
    def events(self) -> int:
        """Events kept of the balls."""
        return int(self._kept.sum())

    @property
    def ready(self) -> bool:
        """Whether the next step finds all it needs."""
        return not bool((self._known <= (self._ticks + 1) * self._dt).any())

    def look_ahead(self) -> bool:
        """Follow the ball a slice further whose path is known least far; whether more would help.

        Nothing is known of a ball at first: this is a ball's turn before its first step, too.
        """
        ahead = self._known - self._ticks * self._dt
        for row in np.flatnonzero(self._full & (ahead < AHEAD)).tolist():
            self._forget(row)
        short = (ahead < AHEAD) & (~self._full | (self._known <= (self._ticks + 1) * self._dt))
        if not short.any():
            return False
        self._advance(int(np.argmin(np.where(short, ahead, np.inf))))
        return True

    def _advance(self, row: int) -> None:
        """Follow a ball a slice further; its segments go to the end of the pool."""
        path = self._paths[row]
        segments = path.advance()
        if len(segments):
            # The one before that in use says what a flight began with.
            begin = max(int(self._begin[row]), int(self._first[row]) - 1)
            kept = int(self._last[row]) - begin
            if self._used + kept + len(segments) > len(self._pool):
                self._repack(kept + len(segments))
                begin = max(int(self._begin[row]), int(self._first[row]) - 1)
            used, end = self._used, self._used + kept
            self._pool[used:end] = self._pool[begin : self._last[row]]
            self._pool[end : end + len(segments)] = segments
            self._used = end + len(segments)
            self._passed[row] += begin - self._begin[row]
            self._first[row] += used - begin
            self._begin[row], self._last[row] = used, self._used
        self._known[row] = path.known
        self._next_time[row] = path.next_time()
        self._forget(row)

    def _forget(self, row: int) -> None:
        """Keep of a ball that has bounced very often only what is still needed."""
        path = self._paths[row]
        if path.full:
            begin = max(int(self._begin[row]), int(self._first[row]) - 1)
            self._passed[row] += begin - self._begin[row]
            self._begin[row] = begin
            path.forget(float(self._pool[begin, body.T]))
        self._kept[row], self._full[row] = path.events, path.full

    def _repack(self, more: int) -> None:
        """Move the segments still needed to the front of a pool with room for `more`."""
        begins = np.maximum(self._begin, self._first - 1)
        parts = [self._pool[a:b] for a, b in zip(begins, self._last, strict=True)]
        self._used = sum(len(part) for part in parts)
        pool = np.empty((max(256, 2 * (self._used + more)), event_log.SEGMENT_SIZE))
        if parts:
            pool[: self._used] = np.concatenate(parts)
        ends = np.cumsum([len(part) for part in parts], dtype=np.int64)
        self._passed += begins - self._begin
        self._first = ends - (self._last - self._first)
        self._begin = ends - (self._last - begins)
        self._last = ends
        self._pool = pool

    def whole(self, row: int) -> Trajectory:
        """The whole motion of the ball in `row`, its future included, followed at once."""
        return follow(self._board, self._paths[row].sliced.start, Exact())

    def ahead(self, row: int) -> tuple[int, Trajectory]:
        """What is known of a ball's path from now on, and how many segments of it lie before."""
        begin, last = int(self._begin[row]), int(self._last[row])
        return int(self._passed[row]), self._paths[row].trajectory(self._pool[begin:last])

    # Time.

    def step(self) -> list[Progress]:
        """Advance all balls by one step of the world."""
        self._ticks += 1
        times = np.multiply(self._ticks, self._dt, dtype=np.float64)
        for row in np.flatnonzero(self._known <= times).tolist():
            while self._known[row] <= times[row]:
                self._advance(row)
        sample(
            self._made(), self._pool, self._first, self._last, times, False, self._series,
            self.states,
        )  # fmt: skip
        return [self._progress(int(row)) for row in np.flatnonzero(self._next_time <= times)]

    def _progress(self, row: int) -> Progress:
        path = self._paths[row]
        events, marks, end = path.pass_to(float(self._ticks[row] * self._dt))
        self._next_time[row] = path.next_time()
        if end is not None:
            self.states[row] = path.sliced.state
        return Progress(row, events, marks, end)

    def remove(self, rows: list[int]) -> None:
        """Take out balls whose drop has ended."""
        self._paths = [path for row, path in enumerate(self._paths) if row not in rows]
        for name in (
            "_ticks", "_first", "_last", "_begin", "_passed", "_next_time", "_known", "_kept",
            "_full", "states",
        ):  # fmt: skip
            setattr(self, name, np.delete(getattr(self, name), rows, axis=0))
        if not self._paths:
            self._arrays = None

    def saved(self) -> list[dict[str, Any]]:
        """What `load` needs of each ball: all else follows from it."""
        return [
            {"x": float(path.sliced.start[body.X]), "frames": int(ticks)}
            for path, ticks in zip(self._paths, self._ticks, strict=True)
        ]

    def load(self, balls: list[dict[str, Any]]) -> None:
        """Append saved balls."""
        for ball in balls:
            self.add_at(ball["x"], ball["frames"])
