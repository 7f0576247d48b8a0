"""The ticker: one asyncio task that runs ticks without drift, and sleeps if no room is awake."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterable, Sequence


class Schedule:
    """Decides when ticks are due. Pure: time is an argument, in s of a monotonic clock.

    Deadline k is start + k * period, computed from k each time, so that late wake-ups and rounding
    do not add up. After a pause at most `max_catch_up` ticks are due and the others are skipped: a
    server that was stopped for a minute must not spend the next minute catching up.
    """

    def __init__(self, period: float, max_catch_up: int) -> None:
        self.period = period
        self.max_catch_up = max_catch_up
        self.overruns = 0  # times that several ticks were due at once
        self.skipped = 0  # ticks
        self._start = 0.0
        self._done = 0

    def start(self, now: float, phase: float = 0.0) -> None:
        """Start at `now`; the first tick is due one period later, or `phase` s before that."""
        self._start = now - phase
        self._done = 0

    def delay(self, now: float) -> float:
        """Seconds from `now` until the next tick is due; never negative."""
        return max(0.0, self._start + (self._done + 1) * self.period - now)

    def lateness(self, now: float) -> float:
        """Seconds by which the next tick is overdue at `now`; never negative."""
        return max(0.0, now - self._start - (self._done + 1) * self.period)

    def due(self, now: float) -> int:
        """The number of ticks to run at `now`; counts them as run."""
        # 1e-6 of a period forgives rounding: a tick is due at exactly its deadline.
        behind = int((now - self._start) / self.period + 1e-6) - self._done
        if behind <= 0:
            return 0
        self._done += behind
        if behind > 1:
            self.overruns += 1
            self.skipped += max(0, behind - self.max_catch_up)
        return min(behind, self.max_catch_up)


Ticked = Callable[[float, float], None]
"""Called after ticks: how late they began, and how long they took with the sending, in s.

There is time then until the next tick."""


class Ticker:
    """Calls `tick(n)` when n ticks are due.

    `tick` returns an iterable. Between two of its values the event loop has a turn. The last value
    says whether any room is still awake; if none is, the ticker sleeps. `phase` returns the seconds
    since a tick was due, when it wakes.
    """

    def __init__(
        self,
        schedule: Schedule,
        tick: Callable[[int], Iterable[bool]],
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        ticked: Sequence[Ticked] = (),
        phase: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self.schedule = schedule
        self.ticks = 0
        self.wakeups = 0  # times that it started ticking
        self.asleep = True
        self._tick = tick
        self._clock = clock
        self._sleep = sleep
        self._phase = phase
        self._ticked = ticked
        self._wake = asyncio.Event()

    def wake(self) -> None:
        """Start ticking, unless the ticker does already."""
        self._wake.set()

    async def run(self) -> None:
        """Tick while rooms are awake and sleep in between, until cancelled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            self.wakeups += 1
            self.asleep = False
            try:
                self.schedule.start(self._clock(), self._phase())
                while await self._next_tick():
                    pass
            finally:
                self.asleep = True

    async def _next_tick(self) -> bool:
        await self._sleep(self.schedule.delay(self._clock()))
        began = self._clock()
        late = self.schedule.lateness(began)
        due = self.schedule.due(began)
        if due == 0:
            return True
        self.ticks += due
        goes_on = False
        for moving in self._tick(due):
            goes_on = moving
            # In this turn of the loop the frames leave. uvloop also caches its clock for each
            # turn: without this one, the next sleep would be measured from before the broadcast.
            await self._sleep(0.0)
        duration = self._clock() - began
        for ticked in self._ticked:
            ticked(late, duration)
        return goes_on
