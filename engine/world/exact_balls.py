"""The balls of a world with the exact solver: each is traced when it is added, then looked up."""

from typing import Any

import numpy as np

from engine.board.model import Board
from engine.drops.digest import drop_digest
from engine.drops.trajectory import Trajectory, at_start, follow, start_row
from engine.exact import event_log
from engine.exact.board_arrays import arrays_of
from engine.exact.sampling import sample
from engine.parameters import Exact
from engine.physics import body
from engine.physics.contact import new_series
from engine.world.ball_set import End, Progress


class ExactBalls:
    """Balls of the exact solver: each is traced once when it is added, and then looked up.

    A trajectory does not depend on when it is looked at, so neither does anything here.
    """

    def __init__(self, board: Board, dt: float) -> None:
        self._board = board
        self._arrays = arrays_of(board)
        self._dt = dt
        self._paths: list[Trajectory] = []
        self._ticks = np.zeros(0, np.int64)
        self._first = np.zeros(0, np.int64)
        self._last = np.zeros(0, np.int64)
        self._next_event = np.zeros(0, np.int64)
        self._next_time = np.zeros(0)
        self._pool = np.empty((0, event_log.SEGMENT_SIZE))
        self._series = new_series()
        self.states = np.zeros((0, body.SIZE))

    def add(self, x: float) -> None:
        """Append a ball at rest at (x, drop.y)."""
        self._append(self._followed(x), 0)

    def _followed(self, x: float) -> Trajectory:
        return follow(self._board, at_start(self._board, x), Exact())

    def _append(self, path: Trajectory, ticks: int) -> None:
        used = int(self._last[-1]) if len(self._last) else 0
        needed = used + len(path.segments)
        if needed > len(self._pool):
            used = self._repack(len(path.segments))
            needed = used + len(path.segments)
        self._pool[used:needed] = path.segments
        self._paths.append(path)
        self._ticks = np.append(self._ticks, ticks)
        self._first = np.append(self._first, used)
        self._last = np.append(self._last, needed)
        seen = int(np.searchsorted(path.events[:, 0], ticks * self._dt, side="right"))
        self._next_event = np.append(self._next_event, seen if ticks else 0)
        self._next_time = np.append(self._next_time, _time_of(path, int(self._next_event[-1])))
        self.states = np.vstack([self.states, path.states_at(np.array([ticks * self._dt]))])

    def _repack(self, more: int) -> int:
        """Move the segments still needed to the front of a pool with room for `more`."""
        parts = [self._pool[a:b] for a, b in zip(self._first, self._last, strict=True)]
        used = sum(len(part) for part in parts)
        pool = np.empty((max(256, 2 * (used + more)), event_log.SEGMENT_SIZE))
        if parts:
            pool[:used] = np.concatenate(parts)
        ends = np.cumsum([len(part) for part in parts], dtype=np.int64)
        self._first = ends - (self._last - self._first)
        self._last = ends
        self._pool = pool
        return used

    def path(self, row: int) -> Trajectory:
        """The whole motion of the ball in `row`, its future included."""
        return self._paths[row]

    def step(self) -> list[Progress]:
        """Advance all balls by one step of the world."""
        self._ticks += 1
        times = np.multiply(self._ticks, self._dt, dtype=np.float64)
        sample(
            self._arrays, self._pool, self._first, self._last, times, False, self._series,
            self.states,
        )  # fmt: skip
        return [self._progress(int(row)) for row in np.flatnonzero(self._next_time <= times)]

    def _progress(self, row: int) -> Progress:
        path = self._paths[row]
        time = float(self._ticks[row] * self._dt)
        first = int(self._next_event[row])
        last = int(np.searchsorted(path.events[:, 0], time, side="right"))
        self._next_event[row] = last
        self._next_time[row] = _time_of(path, last)
        end = None
        if path.end[body.T] <= time:
            self.states[row] = path.end
            end = End(
                path.outcome,
                path.bin,
                float(path.end[body.T]),
                float(path.end[body.X]),
                _digest(path),
            )
        return Progress(row, path.events[first:last], path.marks[first:last], end)

    def remove(self, rows: list[int]) -> None:
        """Take out balls whose drop has ended."""
        self._paths = [path for row, path in enumerate(self._paths) if row not in rows]
        for name in ("_ticks", "_first", "_last", "_next_event", "_next_time", "states"):
            setattr(self, name, np.delete(getattr(self, name), rows, axis=0))

    def saved(self) -> list[dict[str, Any]]:
        """What `load` needs of each ball: all else follows from it."""
        return [
            {"x": float(path.start[body.X]), "frames": int(ticks)}
            for path, ticks in zip(self._paths, self._ticks, strict=True)
        ]

    def load(self, balls: list[dict[str, Any]]) -> None:
        """Append saved balls."""
        for ball in balls:
            self._append(self._followed(ball["x"]), ball["frames"])


def _time_of(path: Trajectory, event: int) -> float:
    """Time of an event, or of the end after the last one."""
    return float(path.events[event, 0] if event < len(path.events) else path.end[body.T])


def _digest(path: Trajectory) -> str:
    return drop_digest(
        path.board.digest, path.solver, start_row(path), path.outcome, path.events, path.marks
    )
