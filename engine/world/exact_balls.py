"""The balls of a world with the exact solver, whose paths are computed ahead of its clock."""

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
"""Pegs and walls of a board whose arrays take more than 1 ms to make."""


class ExactBalls:
    """Balls of the exact solver. Each path is computed in slices, and a step samples its state.

    No result depends on when a path is sampled or how it is sliced. `look_ahead` computes paths
    before a step needs them, to keep the step short; a step computes the rest. The board's arrays
    are dropped when there is no ball.

    `_pool` has the segments of all balls. Those of a ball are rows `_begin` to `_last` - 1, and
    `_first`, between them, is the current one. A slice is appended to the pool's end, and with it a
    copy of the ball's segments that are still needed: the current one, the one before it, and all
    later ones. `_passed` counts the ball's segments that were dropped.
    """

    def __init__(self, board: Board, dt: float) -> None:
        self._board = board
        self._arrays: BoardArrays | None = None
        self._dt = dt
        self._paths: list[ExactPath] = []
        self._ticks = np.zeros(0, np.int64)
        self._first = np.zeros(0, np.int64)
        self._last = np.zeros(0, np.int64)
        self._begin = np.zeros(0, np.int64)
        self._passed = np.zeros(0, np.int64)
        self._next_time = np.zeros(0)
        self._known = np.zeros(0)
        self._kept = np.zeros(0, np.int64)  # events in memory
        self._full = np.zeros(0, np.bool_)
        self._pool = np.empty((0, event_log.SEGMENT_SIZE))
        self._used = 0
        self._series = new_series()
        self.states = np.zeros((0, body.SIZE))

    def add(self, x: float) -> None:
        """Append a ball at rest at (x, drop.y)."""
        self.add_at(x, 0)

    def add_at(self, x: float, ticks: int) -> None:
        """Append a ball in the state that it has `ticks` steps after its start at (x, drop.y)."""
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
        """Compute the path of a new ball up to its time, and sample its state there."""
        path, time = self._paths[row], float(self._ticks[row] * self._dt)
        while (known := path.known) <= time:
            self._advance(row)
            self._look_up(row, known)  # so that earlier segments can be dropped
        self._look_up(row, time)

    def _look_up(self, row: int, time: float) -> None:
        """Sample the state of a ball at `time` in s, up to which its path must be known."""
        path = self._paths[row]
        path.pass_to(time)
        self._next_time[row] = path.next_time()
        one = slice(row, row + 1)
        sample(
            self._made(), self._pool, self._first[one], self._last[one], np.array([time]), False,
            self._series, self.states[one],
        )  # fmt: skip

    # Computing paths.

    @property
    def prepared(self) -> bool:
        """Whether the board's arrays are made, not needed, or quick to make (1 ms)."""
        if self._arrays is not None or not self._paths:
            return True
        return len(self._board.pegs) + len(self._board.walls) < LARGE

    def prepare(self) -> None:
        """Make the board's arrays; may run on any thread."""
        self._made()

    def _made(self) -> BoardArrays:
        if self._arrays is None:
            self._arrays = arrays_of(self._board)
        return self._arrays

    @property
    def known(self) -> list[float]:
        """For each ball, the time in s since its start up to which its path is known."""
        found: list[float] = self._known.tolist()
        return found

    @property
    def events(self) -> int:
        """Number of events in memory."""
        return int(self._kept.sum())

    @property
    def ready(self) -> bool:
        """Whether all paths are known up to the next step."""
        return not bool((self._known <= (self._ticks + 1) * self._dt).any())

    def look_ahead(self) -> bool:
        """Compute one slice of the path that is known least far ahead; return if more would help.

        A new ball comes first, because nothing of its path is known yet.
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
        """Compute one more slice of a ball's path, and move all its segments to the pool's end."""
        path = self._paths[row]
        segments = path.advance()
        if len(segments):
            # The segment before the current one is still needed: it says how a flight began.
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
        """Drop the past events and segments of a ball that has bounced very often."""
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
        """Compute the whole trajectory of the ball in `row`, including its future, in one call."""
        return follow(self._board, self._paths[row].sliced.start, Exact())

    def ahead(self, row: int) -> tuple[int, Trajectory]:
        """The known part of a ball's path from now on, and the number of segments before it."""
        begin, last = int(self._begin[row]), int(self._last[row])
        return int(self._passed[row]), self._paths[row].trajectory(self._pool[begin:last])

    # Advancing time.

    def step(self) -> list[Progress]:
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
        self._paths = [path for row, path in enumerate(self._paths) if row not in rows]
        for name in (
            "_ticks", "_first", "_last", "_begin", "_passed", "_next_time", "_known", "_kept",
            "_full", "states",
        ):  # fmt: skip
            setattr(self, name, np.delete(getattr(self, name), rows, axis=0))
        if not self._paths:
            self._arrays = None

    def saved(self) -> list[dict[str, Any]]:
        """The start and the age of each ball, from which `load` computes everything else."""
        return [
            {"x": float(path.sliced.start[body.X]), "frames": int(ticks)}
            for path, ticks in zip(self._paths, self._ticks, strict=True)
        ]

    def load(self, balls: list[dict[str, Any]]) -> None:
        for ball in balls:
            self.add_at(ball["x"], ball["frames"])
