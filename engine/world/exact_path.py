"""The path of one live ball of the exact solver, computed in slices ahead of the world's clock."""

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
"""Events in a slice: 0.1 ms on a preset, where most drops have fewer."""

AHEAD = 0.5
"""How far ahead a path is known, s, so that clients receive each part before they draw it."""

KEPT = 512
"""About the most events of a ball in memory, enough for a whole drop on a preset. A ball that
bounces a hundred thousand times would need 6 MB. Its old events are dropped, so its digest needs
a second computation of the path."""

_HASHED = 4096  # events that are hashed at a time: 0.3 ms


class Rows:
    """Rows of an array that grows at its end."""

    def __init__(self, width: int, dtype: npt.DTypeLike) -> None:
        self._rows = np.empty((32, width), dtype)
        self.count = 0

    def add(self, rows: npt.NDArray[np.generic]) -> None:
        end = self.count + len(rows)
        if end > len(self._rows):
            grown = np.empty((2 * end, self._rows.shape[1]), self._rows.dtype)
            grown[: self.count] = self._rows[: self.count]
            self._rows = grown
        self._rows[self.count : end] = rows
        self.count = end

    def forget(self, rows: int) -> None:
        """Remove the first `rows` rows."""
        self._rows = self._rows[rows : self.count].copy()
        self.count -= rows

    def between(self, first: int, last: int) -> npt.NDArray[np.generic]:
        """A view of rows `first` to `last` - 1."""
        return self._rows[first:last]


class ExactPath:
    """The known part of one ball's path, and the world's position in it.

    No result depends on how far ahead of the world the path is known.
    """

    def __init__(self, board: Board, x: float) -> None:
        self.sliced = SlicedPath(board, x)
        self._again: SlicedPath | None = None  # the second computation, if events were dropped
        self._events = Rows(event_log.EVENT_SIZE, np.float64)
        self._marks = Rows(2, np.int32)
        self._next = 0
        self._forgotten = 0
        self._digest: DropDigest | None = None
        self._hashed = 0

    @property
    def known(self) -> float:
        """Time in s up to which a world can advance without another call of `advance`.

        After the end of the path it becomes infinite, once the digest is complete.
        """
        if not self.sliced.ended:
            return self.sliced.known
        return np.inf if self._hashed == self.sliced.events else self.sliced.known

    @property
    def events(self) -> int:
        """Number of events in memory."""
        return self._events.count

    @property
    def full(self) -> bool:
        """Whether its memory is full, so that the world must advance before more is computed."""
        return not self.sliced.ended and self._events.count >= KEPT

    def forget(self, time: float) -> None:
        """If memory is full, drop the events before `time` in s that the world has passed."""
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
        """The known part of the path from the first of `segments` on."""
        path = self.sliced
        times = self._events.between(0, self._events.count)[:, 0]
        first = int(np.searchsorted(times, segments[0, body.T])) if len(segments) else 0
        events, marks = self._between(first, self._events.count)
        return Trajectory(
            path.board, Exact(), path.start, path.state, path.outcome, path.bin, events, marks,
            segments,
        )  # fmt: skip

    def advance(self) -> npt.NDArray[np.float64]:
        """Compute a slice and return its segments, shape (m, 11).

        After the end of the path, compute a part of the digest instead.
        """
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
        """Add some more events to the digest, which begins once all are known."""
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
        """Time in s of the first event after the world's time, or of the end; inf if not known."""
        if self._next < self._events.count:
            return float(self._events.between(self._next, self._next + 1)[0, 0])
        return float(self.sliced.state[body.T]) if self.sliced.ended else np.inf

    def pass_to(
        self, time: float
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32], End | None]:
        """Events since the last call up to `time`, their marks, and the end if it is reached."""
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
