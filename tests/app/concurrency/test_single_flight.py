"""Work runs once for all callers that ask for it while it runs."""

import asyncio

import pytest

from plinko.app.concurrency.single_flight import Signal, SingleFlight
from plinko.app.errors import LedgerError
from tests.kit.waiting import turns


class Ledger:
    """A ledger that answers when the test sets `answers`."""

    def __init__(self) -> None:
        self.looks = 0
        self.answers = asyncio.Event()
        self.broken = False

    async def look(self) -> int:
        self.looks += 1
        number = self.looks
        await self.answers.wait()
        if self.broken:
            raise LedgerError("it is gone")
        return number


async def test_callers_meanwhile_share_one_run_and_later_ones_the_next() -> None:
    ledger, flights = Ledger(), SingleFlight[int]()
    asking = [asyncio.create_task(flights.do("main", ledger.look)) for _ in range(100)]
    other = asyncio.create_task(flights.do("classic", ledger.look))
    await turns()
    ledger.answers.set()
    assert await asyncio.gather(*asking) == [1] * 100
    assert await other == 2
    assert await flights.do("main", ledger.look) == 3


async def test_a_cancelled_caller_harms_no_other_and_all_get_errors() -> None:
    ledger, flights = Ledger(), SingleFlight[int]()
    first, second, third = (asyncio.create_task(flights.do("main", ledger.look)) for _ in range(3))
    await turns()
    first.cancel()
    await turns()
    ledger.broken = True
    ledger.answers.set()
    for asked in (second, third):
        with pytest.raises(LedgerError, match="it is gone"):
            await asked
    assert ledger.looks == 1


class Work:
    """Work that runs until it is cancelled or the test sets `ends`."""

    def __init__(self) -> None:
        self.begun = self.cancelled = 0
        self.ends = asyncio.Event()

    async def do(self) -> int:
        self.begun += 1
        number = self.begun
        try:
            await self.ends.wait()
        except asyncio.CancelledError:
            self.cancelled += 1
            raise
        return number


async def leave(*callers: "asyncio.Task[int]") -> None:
    for caller in callers:
        caller.cancel()
    await asyncio.gather(*callers, return_exceptions=True)
    await turns()


@pytest.mark.parametrize("abandons", [False, True])
async def test_work_without_callers_goes_on_unless_it_may_be_abandoned(abandons: bool) -> None:
    work, flights = Work(), SingleFlight[int](abandons=abandons)
    callers = [asyncio.create_task(flights.do("a", work.do)) for _ in range(2)]
    await turns()
    await leave(callers[0])
    assert work.cancelled == 0, "another caller waits"
    await leave(callers[1])
    assert work.cancelled == int(abandons)
    again = asyncio.create_task(flights.do("a", work.do))
    await turns()
    work.ends.set()
    assert await again == (2 if abandons else 1)


async def test_a_signal_wakes_all_who_wait_and_later_ones_wait_for_the_next() -> None:
    signal, woken = Signal(), list[str]()

    async def wait(name: str) -> None:
        await signal.wait()
        woken.append(name)

    signal.send()
    async with asyncio.TaskGroup() as tasks:
        for name in ("a", "b"):
            tasks.create_task(wait(name))
        await turns()
        assert woken == []
        signal.send()
        tasks.create_task(wait("later"))
        await turns()
        assert sorted(woken) == ["a", "b"]
        signal.send()
    assert woken[2:] == ["later"]
