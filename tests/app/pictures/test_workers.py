"""Heavy work: off the loop, bounded, refused with 503 beyond the bound."""

import asyncio
import threading

import pytest

from app.errors import BusyError, answer
from app.pictures.workers import Workers
from tests.waiting import eventually


async def test_work_runs_in_another_thread_and_its_errors_come_back() -> None:
    workers = Workers(1, 1)
    assert await workers.run(threading.get_ident) != threading.get_ident()
    with pytest.raises(ZeroDivisionError):
        await workers.run(lambda: 1 // 0)
    await asyncio.sleep(0)
    assert workers.jobs == 0
    workers.close()


async def test_a_full_queue_refuses_and_takes_work_again_once_it_drains() -> None:
    workers = Workers(1, 2)
    gate = threading.Event()
    waiting = [asyncio.create_task(workers.run(gate.wait)) for _ in range(3)]
    await asyncio.sleep(0)
    assert workers.full
    with pytest.raises(BusyError, match="2 jobs wait") as caught:
        await workers.run(gate.wait)
    assert answer(caught.value).status == 503
    gate.set()
    assert await asyncio.gather(*waiting) == [True] * 3
    await asyncio.sleep(0)
    assert not workers.full
    assert await workers.run(lambda: 7) == 7
    workers.close()


async def test_a_client_gone_early_frees_its_place_only_when_the_work_ends() -> None:
    workers = Workers(1, 0)
    gate = threading.Event()
    task = asyncio.create_task(workers.run(gate.wait))
    await asyncio.sleep(0)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert workers.full
    gate.set()
    await eventually(lambda: not workers.full)
    workers.close()
