"""A client with a hundred requests delays another client by one request."""

import asyncio
from collections.abc import Awaitable, Callable

from hypothesis import given
from hypothesis import strategies as st

from plinko.app.concurrency.fair_queue import FairLock, FairQueue
from tests.kit.waiting import turns


@given(st.lists(st.tuples(st.booleans(), st.sampled_from("abc")), max_size=100))
def test_clients_are_served_in_turn_and_each_in_its_own_order(
    acts: list[tuple[bool, str]],
) -> None:
    queue: FairQueue[tuple[str, int]] = FairQueue()
    waiting: dict[str, list[int]] = {client: [] for client in "abc"}
    passed = dict.fromkeys("abc", 0)  # turns of others since a waiting client's last turn
    for number, (comes, client) in enumerate(acts):
        if comes:
            queue.put(client, (client, number))
            waiting[client].append(number)
            continue
        taken = queue.take()
        if taken is None:
            assert not any(waiting.values())
            continue
        whose, which = taken
        assert which == waiting[whose].pop(0)
        for other, waits in waiting.items():
            passed[other] = passed[other] + 1 if waits and other != whose else 0
            assert passed[other] <= 2


class Desk:
    """Callers that keep a lock until the test releases them."""

    def __init__(self) -> None:
        self.lock = FairLock()
        self.had: list[str] = []
        self.at_once = self.most = 0
        self._leave = asyncio.Semaphore(0)

    def come(self, client: str) -> "asyncio.Task[None]":
        return asyncio.create_task(self._have(client))

    async def _have(self, client: str) -> None:
        async with self.lock.turn(client):
            self.had.append(client)
            self.at_once += 1
            self.most = max(self.most, self.at_once)
            try:
                await self._leave.acquire()
            finally:
                self.at_once -= 1

    async def let_go(self, count: int = 1) -> None:
        for _ in range(count):
            self._leave.release()
            await turns()


async def test_one_has_the_lock_at_a_time_and_clients_have_it_in_turn() -> None:
    desk = Desk()
    callers = [desk.come(client) for client in ("flood", "flood", "flood", "one", "two", "one")]
    await turns()
    await desk.let_go(len(callers))
    await asyncio.gather(*callers)
    assert desk.had == ["flood", "flood", "one", "two", "flood", "one"]
    assert desk.most == 1


async def cancelled_before(desk: Desk, caller: "asyncio.Task[None]") -> None:
    caller.cancel()
    await turns()
    await desk.let_go()


async def cancelled_with_its_turn(desk: Desk, caller: "asyncio.Task[None]") -> None:
    desk._leave.release()
    while desk.at_once:  # until the lock is released, and before the next caller runs
        await asyncio.sleep(0)
    caller.cancel()
    await turns()


async def cancelled_while_it_has_it(desk: Desk, caller: "asyncio.Task[None]") -> None:
    await desk.let_go()
    caller.cancel()
    await turns()


async def test_a_cancelled_caller_does_not_keep_the_lock() -> None:
    ways: list[Callable[[Desk, asyncio.Task[None]], Awaitable[None]]] = [
        cancelled_before,
        cancelled_with_its_turn,
        cancelled_while_it_has_it,
    ]
    for way in ways:
        desk = Desk()
        first, caller, last = (desk.come(client) for client in "abc")
        await turns()
        await way(desk, caller)
        assert caller.cancelled()
        await desk.let_go()
        await asyncio.gather(first, last)
        assert desk.had[-1] == "c"
        after = desk.come("d")
        await turns()
        await desk.let_go()
        await after
