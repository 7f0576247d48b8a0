"""The clocks that rooms and records go by: steady Unix time, and the tick of a table's run."""

import math
import time
from collections.abc import Callable
from typing import Final

EARLY: Final = 0.1
"""Of a tick: a tick counts from this much before its time, so that a ticker that wakes exactly at
the time of a tick never finds the one before it."""


class SteadyClock:
    """Unix time in s, read once and then advanced by the monotonic clock.

    If the machine's time is set while the server runs, nothing here changes.
    """

    def __init__(
        self,
        monotonic: Callable[[], float] = time.monotonic,
        unix: Callable[[], float] = time.time,
    ) -> None:
        self._monotonic = monotonic
        self._offset = unix() - monotonic()

    def __call__(self) -> float:
        return self._offset + self._monotonic()

    def set(self, unix: float) -> None:
        """Go by another clock from now on, such as that of the database that servers share."""
        self._offset = unix - self._monotonic()


def tick_at(seconds: float, rate: int) -> int:
    """The number of ticks of `rate` Hz until this Unix time, in s. All tables tick together."""
    return math.floor(seconds * rate + EARLY)


class RunClock:
    """The ticks of one run, which begin at Unix time `opened`; `now` returns the Unix time.

    It never stands before `least`, the tick of the run's last fact: if the machine's time was set
    back between two starts, the clock goes on from there.
    """

    def __init__(self, now: Callable[[], float], rate: int, opened: float, least: int = 0) -> None:
        self._now = now
        self._rate = rate
        self._first = min(tick_at(opened, rate), tick_at(now(), rate) - least)

    @property
    def tick(self) -> int:
        return max(0, tick_at(self._now(), self._rate) - self._first)
