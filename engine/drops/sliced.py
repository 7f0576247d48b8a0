"""One ball followed a slice of events at a time: the same bits as `trajectory.follow` at once.

For whoever must not be kept waiting by a ball that bounces a hundred thousand times.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from engine.board.model import Board
from engine.constants import MAX_TIME
from engine.drops.trajectory import at_start
from engine.errors import EffortError
from engine.exact import event_log
from engine.exact.board_arrays import BoardArrays, arrays_of
from engine.exact.event_log import Log, new_log
from engine.exact.initial_state import Ints, in_flight
from engine.exact.outcome import EVENT_LIMIT, MAX_EVENTS, RUNNING
from engine.exact.trace import trace_many
from engine.jit.limits import at_most
from engine.physics import body
from engine.physics.contact import new_series

Floats = npt.NDArray[np.float64]

EFFORT: Final = 40_000_000
"""Instructions of WebAssembly in a slice, some 6 ms: of a preset one takes a four-hundredth."""

_BEYOND = 8  # events that mostly follow the one at which a slice is asked to end, at the most


@dataclass(frozen=True, slots=True, eq=False)
class Slice:
    """What a ball did in a slice: rows of a log, as those of a `Trajectory`."""

    events: Floats  # (n, 6)
    marks: npt.NDArray[np.int32]  # (n, 2)
    segments: Floats  # (m, 11)


class SlicedPath:
    """The path of a ball that starts at rest at (x, drop.y), m, as far as it has been followed.

    state, shape (7,): where it is by now, its end once `outcome` is not RUNNING any more.
    """

    def __init__(self, board: Board, x: float, max_events: int = MAX_EVENTS) -> None:
        self.board = board
        self.start = at_start(board, x)
        self.state = self.start.copy()
        self.outcome = RUNNING
        self.bin = -1
        self.events = 0  # so far
        self._initial = in_flight(1)
        self._max_events = self._most = max_events
        self._series = new_series()
        self._arrays: BoardArrays | None = None  # until it is followed

    @property
    def ended(self) -> bool:
        """Whether all of it is known."""
        return self.outcome != RUNNING

    @property
    def known(self) -> float:
        """Time in s before which all is known; later ones are too once it has ended."""
        return float(self.state[body.T])

    def follow(self, most: int) -> Slice:
        """Follow it for `most` events more, or a few besides; nothing once it has ended.

        Where calls are limited (`limit_calls`) and so many take more than EFFORT, it is followed
        for fewer at a time from then on; raises EffortError where a single event takes more.
        """
        if self.ended:
            return _slice(new_log(0, 0))
        while True:
            limit = min(most, self._most, self._max_events - self.events)
            try:
                with at_most(EFFORT):
                    return self._followed(limit)
            except EffortError:
                if limit == 1:
                    raise
                self._most = max(1, limit // 8)

    def _followed(self, limit: int) -> Slice:
        events = limit + _BEYOND
        segments = 4 * events
        while True:
            log = new_log(events, segments)
            state, initial = self.state.reshape(1, body.SIZE).copy(), self._initial.copy()
            outcome, where = self._trace(state, initial, limit, log)
            counts = log.counts.tolist()
            if counts[event_log.EVENTS] <= events and counts[event_log.SEGMENTS] <= segments:
                break
            events = max(events, counts[event_log.EVENTS])
            segments = max(segments, counts[event_log.SEGMENTS])
        self.state, self._initial = state[0], initial
        self.events += int(log.counts[event_log.EVENTS])
        if outcome != EVENT_LIMIT or self.events >= self._max_events:
            self.outcome, self.bin = outcome, where
        return _slice(log)

    def _trace(self, state: Floats, initial: Ints, limit: int, log: Log) -> tuple[int, int]:
        if self._arrays is None:
            self._arrays = arrays_of(self.board)
        outcome, where, impacts = np.empty(1, np.int8), np.empty(1, np.int32), np.empty(1, np.int32)
        trace_many(
            self._arrays, state, initial, limit, MAX_TIME, self._series, log, outcome,
            where, impacts,
        )  # fmt: skip
        return int(outcome[0]), int(where[0])


def _slice(log: Log) -> Slice:
    events, segments = log.counts[event_log.EVENTS], log.counts[event_log.SEGMENTS]
    return Slice(log.events[:events], log.marks[:events], log.segments[:segments])
