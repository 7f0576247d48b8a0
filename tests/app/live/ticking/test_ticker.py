"""The ticker does not drift, catches up a bounded number of ticks, and sleeps when idle."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.app.live.ticking.ticker import Schedule, Ticker
from tests.kit.waiting import turns

PERIOD = 1.0 / 60.0


class FakeClock:
    """A clock that advances only during sleeps; each may take longer than asked."""

    def __init__(self, late: list[float] | None = None) -> None:
        self.now = 1000.0
        self.late = late or []
        self.sleeps = 0

    def __call__(self) -> float:
        return self.now

    async def sleep(self, seconds: float) -> None:
        if seconds > 0.0:
            self.now += seconds + (self.late[self.sleeps % len(self.late)] if self.late else 0.0)
            self.sleeps += 1
        await asyncio.sleep(0)


@given(
    st.lists(st.floats(0.0, 4.9 * PERIOD), min_size=1, max_size=300),
    st.floats(0.0, 1e6),
)
def test_whatever_the_delays_the_ticks_follow_the_clock(lates: list[float], start: float) -> None:
    schedule = Schedule(PERIOD, 5)
    schedule.start(start)
    now, ticks = start, 0
    for late in lates:
        now += late
        ticks += schedule.due(now)
    assert abs(ticks - (now - start) / PERIOD) < 1.0 + 1e-3
    assert schedule.skipped == 0


def test_after_a_pause_the_cap_is_caught_up_the_rest_counted() -> None:
    schedule = Schedule(PERIOD, 5)
    schedule.start(0.0)
    assert schedule.due(60.5 * PERIOD) == 5
    assert (schedule.overruns, schedule.skipped) == (1, 55)
    assert schedule.due(60.6 * PERIOD) == 0, "the next tick keeps to the old rhythm"
    assert schedule.due(61.0 * PERIOD) == 1


def ticker_of(tick: Callable[[int], list[bool]], clock: FakeClock, **options: Any) -> Ticker:
    return Ticker(Schedule(PERIOD, 5), tick, clock=clock, sleep=clock.sleep, **options)


async def ticker_run(ticker: Ticker) -> None:
    task = asyncio.create_task(ticker.run())
    await turns(5000)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task


async def test_a_ticker_does_nothing_until_woken_and_sleeps_again_once_nothing_moves() -> None:
    clock = FakeClock(late=[0.001, 0.0, 0.004])
    left = [10]

    def tick(due: int) -> list[bool]:
        left[0] -= due
        return [left[0] > 0]

    ticker = ticker_of(tick, clock)
    await ticker_run(ticker)
    assert (ticker.ticks, ticker.wakeups, clock.sleeps, ticker.asleep) == (0, 0, 0, True)
    ticker.wake()
    await ticker_run(ticker)
    assert (ticker.ticks, ticker.wakeups, ticker.asleep) == (10, 1, True)
    ticker.wake()
    left[0] = 3
    await ticker_run(ticker)
    assert (ticker.ticks, ticker.wakeups, ticker.asleep) == (13, 2, True)


async def test_a_ticker_woken_while_awake_goes_on_with_its_rhythm() -> None:
    clock = FakeClock()
    times: list[float] = []

    def tick(due: int) -> list[bool]:
        times.append(clock.now)
        ticker.wake()
        return [len(times) < 50]

    ticker = ticker_of(tick, clock)
    ticker.wake()
    await ticker_run(ticker)
    assert times[:50] == pytest.approx([1000.0 + (k + 1) * PERIOD for k in range(50)])


async def test_a_slow_tick_is_an_overrun_and_is_caught_up() -> None:
    clock = FakeClock()
    dues: list[int] = []

    def tick(due: int) -> list[bool]:
        dues.append(due)
        if len(dues) == 1:
            clock.now += 2.5 * PERIOD
        return [len(dues) < 5]

    ticker = ticker_of(tick, clock)
    ticker.wake()
    await ticker_run(ticker)
    assert dues == [1, 2, 1, 1, 1]
    assert ticker.schedule.overruns == 1


async def test_each_tick_s_lateness_and_duration_are_reported() -> None:
    clock = FakeClock(late=[0.001, 0.0, 0.004])
    journal: list[tuple[float, float]] = []
    left = [3]

    def tick(due: int) -> list[bool]:
        left[0] -= due
        clock.now += 0.002
        return [left[0] > 0]

    def ticked(late: float, duration: float) -> None:
        journal.append((round(late, 6), round(duration, 6)))

    ticker = ticker_of(tick, clock, ticked=[ticked])
    await ticker_run(ticker)
    assert journal == []
    ticker.wake()
    await ticker_run(ticker)
    assert journal == [(0.001, 0.002), (0.0, 0.002), (0.004, 0.002)]


async def test_a_ticker_that_is_cancelled_is_asleep() -> None:
    clock = FakeClock()
    asleep: list[bool] = []
    ticker: Ticker = ticker_of(
        lambda due: [True], clock, ticked=[lambda late, duration: asleep.append(ticker.asleep)]
    )
    ticker.wake()
    await ticker_run(ticker)
    assert (any(asleep), len(asleep) > 0, ticker.asleep) == (False, True, True)
