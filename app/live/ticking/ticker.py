"""The ticker: one asyncio task for all rooms that are awake, drift-free, asleep when none is."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterable, Sequence
from typing import Protocol


class Schedule:
    """When ticks are due, pure: the caller brings the time in seconds of a monotonic clock.

    Deadline k is start + k * period, computed afresh from k, so neither late wake-ups nor rounding
    add up. After a pause at most `max_catch_up` ticks are due at once and the rest is given up:
    a server that was stopped for a minute must not spend the next one catching up.
    """

    def __init__(self, period: float, max_catch_up: int) -> None:
        self.period = period
        self.max_catch_up = max_catch_up
        self.overruns = 0  # times that more than one tick was due
        self.skipped = 0  # ticks given up
        self._start = 0.0
        self._done = 0

    def start(self, now: float) -> None:
        """Begin at `now`; the first tick is due one period later."""
        self._start = now
        self._done = 0

    def delay(self, now: float) -> float:
        """Seconds from `now` until the next tick is due; never negative."""
        return max(0.0, self._start + (self._done + 1) * self.period - now)

    def lateness(self, now: float) -> float:
        """Seconds by which the next tick is overdue at `now`; never negative."""
        return max(0.0, now - self._start - (self._done + 1) * self.period)

    def due(self, now: float) -> int:
        """How many ticks to run at `now`; counts them as run."""
        # The small share of a period forgives rounding: woken on the very deadline, it is due.
        behind = int((now - self._start) / self.period + 1e-6) - self._done
        if behind <= 0:
            return 0
        self._done += behind
        if behind > 1:
            self.overruns += 1
            self.skipped += max(0, behind - self.max_catch_up)
        return min(behind, self.max_catch_up)


class Watcher(Protocol):
    """Who wants to know how the ticker does."""

    def woke(self) -> None:
        """The ticker left its sleep."""

    def ticked(self, late: float, duration: float) -> None:
        """Ticks were run `late` seconds after they were due; with the sending it took `duration`.

        There is time now until the next one.
        """

    def slept(self) -> None:
        """Nothing moves any more."""


class Ticker:
    """Calls `tick(n)` when n ticks are due, as long as it says that something still moves.

    What `tick` returns it says in steps, between which the event loop has a turn.
    """

    def __init__(
        self,
        schedule: Schedule,
        tick: Callable[[int], Iterable[bool]],
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        watchers: Sequence[Watcher] = (),
    ) -> None:
        self.schedule = schedule
        self.ticks = 0
        self.wakeups = 0  # times it left its sleep; does not grow while nothing moves
        self.asleep = True
        self._tick = tick
        self._clock = clock
        self._sleep = sleep
        self._watchers = watchers
        self._wake = asyncio.Event()

    def wake(self) -> None:
        """Something moves: start ticking, unless already at it."""
        self._wake.set()

    async def run(self) -> None:
        """Tick whenever woken, until cancelled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            self.wakeups += 1
            self.asleep = False
            for watcher in self._watchers:
                watcher.woke()
            try:
                self.schedule.start(self._clock())
                while await self._next_tick():
                    pass
            finally:
                self.asleep = True
                for watcher in self._watchers:
                    watcher.slept()

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
            # The turn of the loop in which the frames leave. uvloop also caches its clock per turn:
            # without this one the long sleep would be measured from before the broadcast.
            await self._sleep(0.0)
        duration = self._clock() - began
        for watcher in self._watchers:
            watcher.ticked(late, duration)
        return goes_on
