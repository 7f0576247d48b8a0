"""A signal wakes all tasks that wait for it, and none that begins to wait later."""

import asyncio

from plinko.app.concurrency.single_flight import Signal
from tests.kit.waiting import turns


async def test_all_waiters_are_woken_and_later_ones_wait_for_the_next() -> None:
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
