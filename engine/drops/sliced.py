"""Computes one path in slices of events, with the same bits as `trajectory.follow` in one call.

A live room uses this, because a ball that bounces a hundred thousand times must not delay a tick.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import MAX_TIME
from plinko.engine.drops.trajectory import at_start, impacts_of
from plinko.engine.errors import EffortError
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import BoardArrays, arrays_of
from plinko.engine.exact.event_log import Log, new_log
from plinko.engine.exact.initial_state import in_flight
from plinko.engine.exact.outcome import EVENT_LIMIT, MAX_EVENTS, RUNNING
from plinko.engine.exact.trace import trace_many
from plinko.engine.jit.limits import at_most
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats, Ints
from plinko.engine.physics.contact import new_series

EFFORT: Final = 40_000_000
"""Most WebAssembly instructions in a slice, about 6 ms; on a preset a slice needs 1/400 of that."""

_BEYOND = 8  # log rows for events beyond the limit; a slice that needs more is computed again


@dataclass(frozen=True, slots=True, eq=False)
class Slice:
    """The rows that a slice adds to a ball's log, as in a `Trajectory`."""

    impacts: npt.NDArray[np.void]  # (n,)
    segments: Floats  # (m, 11)


class SlicedPath:
    """The path of a ball that starts at rest at (x, drop.y) in m, computed slice by slice.

    state, shape (7,): the state at the end of the last slice. The path has ended once `outcome` is
    no longer RUNNING.
    """

    def __init__(self, board: Board, x: float, max_events: int = MAX_EVENTS) -> None:
        self.board = board
        self.start = at_start(board, x)
        self.state = self.start.copy()
        self.outcome = RUNNING
        self.bin = -1
        self.events = 0  # computed until now
        self._initial = in_flight(1)
        self._max_events = self._most = max_events
        self._series = new_series()
        self._arrays: BoardArrays | None = None  # made for the first slice

    @property
    def ended(self) -> bool:
        return self.outcome != RUNNING

    @property
    def known(self) -> float:
        """Time in s until which the path is known; after its end, it is known for all times."""
        return float(self.state[body.T])

    def follow(self, most: int) -> Slice:
        """Compute about `most` more events, sometimes a few beyond; nothing after the end.

        If this process limits its calls (`limit_calls`) and the slice takes more than EFFORT, this
        and later slices are shorter. Raises EffortError if a single event takes more.
        """
        if self.ended:
            return _slice(new_log(0, 0))
        if self._arrays is None:
            self._arrays = arrays_of(self.board)  # before the limit, which is that of a ball's path
        while True:
            limit = min(most, self._most, self._max_events - self.events)
            try:
                return at_most(EFFORT, self._followed, limit)
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
        assert self._arrays is not None
        outcome, where, impacts = np.empty(1, np.int8), np.empty(1, np.int32), np.empty(1, np.int32)
        trace_many(
            self._arrays, state, initial, limit, MAX_TIME, self._series, log, outcome,
            where, impacts,
        )  # fmt: skip
        return int(outcome[0]), int(where[0])


def _slice(log: Log) -> Slice:
    events, segments = log.counts[event_log.EVENTS], log.counts[event_log.SEGMENTS]
    return Slice(impacts_of(log.events[:events], log.marks[:events]), log.segments[:segments])
