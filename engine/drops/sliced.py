"""Computes a flight in slices of events, with the same bits as `fly` in one call.

A live room uses this, because a ball that bounces a hundred thousand times must not delay a tick.
"""

from typing import Any, Final

import numpy as np

from plinko.engine.board.model import Board
from plinko.engine.constants import MAX_TIME
from plinko.engine.drops.flight import Flight
from plinko.engine.drops.trajectory import Trajectory, at_start, impacts_of
from plinko.engine.errors import EffortError
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import BoardArrays, arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.initial_state import in_flight
from plinko.engine.exact.outcome import EVENT_LIMIT, MAX_EVENTS, RUNNING
from plinko.engine.exact.trace import trace_many
from plinko.engine.jit.limits import at_most
from plinko.engine.parameters import Exact
from plinko.engine.physics import body
from plinko.engine.physics.contact import new_series

EFFORT: Final = 40_000_000
"""Most WebAssembly instructions in a slice, about 6 ms; on a preset a slice needs 1/400 of that."""

_BEYOND = 8  # log rows for events beyond the limit; a slice that needs more is computed again


class SlicedFlight:
    """The flight of a ball that starts at rest at (x, drop.y) in m, by a thread that others wait
    for."""

    def __init__(self, board: Board, x: float, max_events: int = MAX_EVENTS) -> None:
        self._board = board
        self._start = at_start(board, x)
        self._state = self._start.copy()
        self._outcome = RUNNING
        self._bin = -1
        self._initial = in_flight(1)
        self._left = self._most = max_events  # events until the limit, and in a slice
        self._series = new_series()
        self._arrays: BoardArrays | None = None  # made for the first slice
        self._parts: list[tuple[Any, Any]] = []  # impacts and segments of each slice

    def advance(self, events: int) -> bool:
        """Compute about `events` more events, sometimes a few beyond; return whether it has ended.

        If this process limits its calls (`limit_calls`) and the slice takes more than EFFORT, this
        and later slices are shorter. Raises EffortError if a single event takes more.
        """
        if self._arrays is None:
            self._arrays = arrays_of(self._board)  # not limited, unlike a slice
        while self._outcome == RUNNING:
            limit = min(events, self._most, self._left)
            try:
                at_most(EFFORT, self._follow, self._arrays, limit)
                break
            except EffortError:
                if limit == 1:
                    raise
                self._most = max(1, limit // 8)
        return self._outcome != RUNNING

    def _follow(self, arrays: BoardArrays, limit: int) -> None:
        rows, segments = limit + _BEYOND, 4 * (limit + _BEYOND)
        while True:
            log = new_log(rows, segments)
            state, initial = self._state.reshape(1, body.SIZE).copy(), self._initial.copy()
            ends = np.empty(1, np.int8), np.empty(1, np.int32), np.empty(1, np.int32)
            trace_many(arrays, state, initial, limit, MAX_TIME, self._series, log, *ends)
            counts = log.counts.tolist()
            events, pieces = counts[event_log.EVENTS], counts[event_log.SEGMENTS]
            if events <= rows and pieces <= segments:
                break
            rows, segments = max(rows, events), max(segments, pieces)
        self._state, self._initial = state[0], initial
        impacts = impacts_of(log.events[:events], log.marks[:events])
        self._parts.append((impacts, log.segments[:pieces]))
        self._left -= events
        if ends[0][0] != EVENT_LIMIT or self._left <= 0:
            self._outcome, self._bin = int(ends[0][0]), int(ends[1][0])

    def flight(self) -> Flight:
        """The flight as far as it is computed, with its digest once it has ended."""
        impacts, segments = (np.concatenate(each) for each in zip(*self._parts, strict=True))
        path = Trajectory(
            self._board, Exact(), self._start, self._state, self._outcome, self._bin,
            impacts, segments,
        )  # fmt: skip
        found = Flight(self._board, path)
        if self._outcome != RUNNING:
            _ = found.digest  # now, because it takes milliseconds if the flight is long
        return found
