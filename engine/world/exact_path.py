"""The path of a live ball of the exact solver, followed a slice ahead of the world's clock."""

import numpy as np
import numpy.typing as npt

from engine.board.model import Board
from engine.drops.digest import DropDigest
from engine.drops.sliced import SlicedPath
from engine.drops.trajectory import Trajectory
from engine.exact import event_log
from engine.parameters import Exact
from engine.physics import body
from engine.world.ball_set import End

SLICE = 64
"""Events followed at a time: 0.1 ms on a preset. Most drops of the presets have fewer."""

AHEAD = 0.5
"""s that a path is known ahead, so that those who draw it hear of each piece before it begins."""

KEPT = 512
"""Events that are kept of a ball, or about: all of a drop on the presets. Of one that bounces a
hundred thousand times they would be 6 MB, so its digest follows the path a second time."""

_HASHED = 4096  # events of a digest at a time: 0.3 ms


class Rows:
    """Rows of an array that grows at its end."""

    def __init__(self, width: int, dtype: npt.DTypeLike) -> None:
        self._rows = np.empty((32, width), dtype)
        self.count = 0

    def add(self, rows: npt.NDArray[np.generic]) -> None:
        """Append rows."""
        end = self.count + len(rows)
        if end > len(self._rows):
            grown = np.empty((2 * end, self._rows.shape[1]), self._rows.dtype)
            grown[: self.count] = self._rows[: self.count]
            self._rows = grown
        self._rows[self.count : end] = rows
        self.count = end

    def forget(self, rows: int) -> None:
        """Take out the first rows."""
        self._rows = self._rows[rows : self.count].copy()
        self.count -= rows

    def between(self, first: int, last: int) -> npt.NDArray[np.generic]:
        """A view of rows `first` to `last`, the latter left out."""
        return self._rows[first:last]


class ExactPath:
    """One ball: its path as far as it is known, and how far in it the world has come.

    Nothing here depends on how far ahead the path was followed when it was looked at.
    """

    def __init__(self, board: Board, x: float) -> None:
        self.sliced = SlicedPath(board, x)
        self._again: SlicedPath | None = None  # for the digest, where events were forgotten
        self._events = Rows(event_log.EVENT_SIZE, np.float64)
        self._marks = Rows(2, np.int32)
        self._next = 0
        self._forgotten = 0
        self._digest: DropDigest | None = None
        self._hashed = 0

    @property
    def known(self) -> float:
        """Time in s up to which a world can go on without following the path further."""
        if not self.sliced.ended:
            return self.sliced.known
        return np.inf if self._hashed == self.sliced.events else self.sliced.known

    @property
    def events(self) -> int:
        """How many events are kept of it."""
        return self._events.count

    @property
    def full(self) -> bool:
        """Whether it is not to be followed further before the world has come further."""
        return not self.sliced.ended and self._events.count >= KEPT

    def forget(self, time: float) -> None:
        """Keep no events of before `time`, in s, that the world has passed, where they are many."""
        if not self.full:
            return
        times = self._events.between(0, self._next)[:, 0]
        past = int(np.searchsorted(times, time))
        if past >= KEPT // 2:
            self._events.forget(past)
            self._marks.forget(past)
            self._next -= past
            self._forgotten += past

    def trajectory(self, segments: npt.NDArray[np.float64]) -> Trajectory:
        """What is known of the path from the first of these of its segments on."""
        path = self.sliced
        times = self._events.between(0, self._events.count)[:, 0]
        first = int(np.searchsorted(times, segments[0, body.T])) if len(segments) else 0
        events, marks = self._between(first, self._events.count)
        return Trajectory(
            path.board, Exact(), path.start, path.state, path.outcome, path.bin, events, marks,
            segments,
        )  # fmt: skip

    def advance(self) -> npt.NDArray[np.float64]:
        """Follow it by a slice, or make a part of its digest; the new segments, shape (m, 11)."""
        if self.sliced.ended:
            self._hash()
            return np.empty((0, event_log.SEGMENT_SIZE))
        part = self.sliced.follow(SLICE)
        self._events.add(part.events)
        self._marks.add(part.marks)
        if self.sliced.ended:
            self._hash()
        return part.segments

    def _hash(self) -> None:
        """Make the digest of a part of the events, once all are known."""
        path = self.sliced
        if self._digest is None:
            start = path.start[[body.X, body.Y, body.VX, body.VY, body.OMEGA]]
            board = path.board.digest
            self._digest = DropDigest(board, Exact(), start, path.outcome, path.events)
            if self._forgotten:
                self._again = SlicedPath(path.board, float(path.start[body.X]))
        if self._again is not None:
            part = self._again.follow(SLICE)
            self._digest.add(part.events, part.marks)
            self._hashed += len(part.events)
            return
        last = min(self._hashed + _HASHED, self._events.count)
        self._digest.add(*self._between(self._hashed, last))
        self._hashed = last

    def next_time(self) -> float:
        """When the next event is that the world has not come to, s; or the end, or inf so far."""
        if self._next < self._events.count:
            return float(self._events.between(self._next, self._next + 1)[0, 0])
        return float(self.sliced.state[body.T]) if self.sliced.ended else np.inf

    def pass_to(
        self, time: float
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32], End | None]:
        """Events since the last call up to `time`, their marks, and how the drop ended by then."""
        first = self._next
        times = self._events.between(first, self._events.count)[:, 0]
        self._next = last = first + int(times.searchsorted(time, side="right"))
        events, marks = self._between(first, last)
        return events.copy(), marks.copy(), self._end(time)

    def _end(self, time: float) -> End | None:
        state = self.sliced.state
        if not self.sliced.ended or state[body.T] > time:
            return None
        assert self._digest is not None
        return End(
            self.sliced.outcome,
            self.sliced.bin,
            float(state[body.T]),
            float(state[body.X]),
            self._digest.hexdigest(),
        )

    def _between(
        self, first: int, last: int
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]:
        events = self._events.between(first, last).astype(np.float64, copy=False)
        return events, self._marks.between(first, last).astype(np.int32, copy=False)
