"""Workers: another process, quick things first, and an end to everything."""

import asyncio
import functools
import os
import signal
import time
from collections.abc import AsyncIterator
from typing import Any

import numpy as np
import pytest

from app.computing import packing, process
from app.computing.inside import KEPT
from app.computing.pool import Workers
from app.errors import BusyError, CostError, DeadlineError, EndedError, InvalidValueError, answer
from benchmarks.scenes.expensive_boards import hall
from engine import Board, drop, drop_many
from engine.drops.batch import LEAST_CHUNK
from tests.waiting import eventually, lives

FOR_EVER = functools.partial(time.sleep, 3600.0)


@pytest.fixture
async def workers() -> AsyncIterator[Workers]:
    made = Workers(2, 4)
    yield made
    made.close()


def refuse() -> None:
    raise InvalidValueError("7 is too many", field="balls")


def spin() -> None:
    while True:
        pass


async def running_for(workers: Workers, count: int) -> None:
    await eventually(lambda: len(workers.pids) == count)


async def test_work_is_done_in_another_process_and_its_errors_come_back(workers: Workers) -> None:
    assert await workers.run(os.getpid) != os.getpid()
    with pytest.raises(InvalidValueError, match="7 is too many") as caught:
        await workers.run(refuse)
    assert caught.value.field == "balls"
    assert workers.jobs == 0


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="not on this system")
async def test_one_core_is_left_to_the_event_loop(workers: Workers) -> None:
    cores = sorted(os.sched_getaffinity(0))
    theirs = await workers.run(functools.partial(os.sched_getaffinity, 0))
    assert sorted(theirs) == (cores[1:] or cores)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="not on this system")
async def test_a_worker_is_polite_from_its_first_instruction_on(workers: Workers) -> None:
    """As the process is that it is a fork of."""
    cores = sorted(os.sched_getaffinity(0))
    maker = await workers.run(os.getppid)
    assert sorted(os.sched_getaffinity(maker)) == (cores[1:] or cores)
    own = os.getpriority(os.PRIO_PROCESS, 0)
    theirs = await workers.run(functools.partial(os.getpriority, os.PRIO_PROCESS, 0))
    assert theirs == os.getpriority(os.PRIO_PROCESS, maker) == min(own + 10, 19)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="not on this system")
async def test_who_may_have_to_start_a_worker_leaves_no_core(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else the worker would leave one of those that are left, so two in all."""
    theirs: list[set[int]] = []

    def packed(*work: Any) -> bytes:
        theirs.append(os.sched_getaffinity(0))
        return packing.packed(*work)

    monkeypatch.setattr(process, "packed", packed)
    await workers.run(os.getpid)
    assert theirs == [os.sched_getaffinity(0)]


async def test_a_drop_has_the_same_bits_there(workers: Workers) -> None:
    board = Board.preset("triangle-16")
    assert (await workers.run(functools.partial(drop, board, 42))).digest == drop(board, 42).digest


_boards: list[Board] = []


def met_before(board: Board) -> bool:
    """Whether this very object was given the last time."""
    met = bool(_boards) and _boards[-1] is board
    _boards.append(board)
    return met


async def test_a_board_is_packed_once_and_unpacked_once(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    board = Board.from_json(hall())
    assert not await workers.run(functools.partial(met_before, board))
    monkeypatch.setattr(Board, "__reduce_ex__", refuse)
    assert await workers.run(functools.partial(met_before, Board.from_json(hall())))


async def test_what_takes_too_long_is_ended_and_the_next_is_done(workers: Workers) -> None:
    pid = await workers.run(os.getpid)
    with pytest.raises(DeadlineError, match=r"longer than the 0\.1 s"):
        await workers.run(spin, deadline=0.1)
    assert not lives(pid)
    pid = await workers.run(os.getpid)
    with pytest.raises(DeadlineError, match=r"longer than the 0\.02 s"):
        await workers.run(FOR_EVER, deadline=0.02)  # computes nothing, and never comes to an end
    assert not lives(pid)


async def test_a_board_made_to_be_expensive_takes_no_more_than_anything_else(
    workers: Workers,
) -> None:
    """Balls bounce 100,000 times, in one call of machine code that takes minutes."""
    board = Board.from_json(hall())
    pid = await workers.run(os.getpid)
    many = functools.partial(drop_many, board, range(LEAST_CHUNK), threads=1)
    with pytest.raises(DeadlineError, match=r"longer than the 0\.1 s") as caught:
        await workers.run(many, deadline=0.1)
    assert answer(caught.value).status == 422
    assert not lives(pid)
    assert await workers.run(os.getpid) != pid


async def test_a_worker_that_gets_no_core_is_waited_for(workers: Workers) -> None:
    pid = await workers.run(os.getpid)
    await workers.run(functools.partial(time.sleep, 0.3), deadline=0.1)
    assert await workers.run(os.getpid) == pid


async def test_who_goes_away_ends_the_work(workers: Workers) -> None:
    asking = asyncio.create_task(workers.run(FOR_EVER))
    await running_for(workers, 1)
    (pid,) = workers.pids
    asking.cancel()
    await asyncio.wait([asking])
    await eventually(lambda: workers.jobs == 0)
    assert not lives(pid)


async def test_what_takes_long_leaves_a_worker_for_what_is_quick(workers: Workers) -> None:
    long = [asyncio.create_task(workers.run(FOR_EVER)) for _ in range(3)]
    assert await workers.run(os.getpid, quick=True) != os.getpid()
    await running_for(workers, 1)
    for each in long:
        each.cancel()
    await asyncio.wait(long)


async def test_a_full_queue_refuses_and_takes_work_again_once_it_drains(workers: Workers) -> None:
    asking = [asyncio.create_task(workers.run(FOR_EVER)) for _ in range(6)]
    await eventually(lambda: workers.full)
    with pytest.raises(BusyError) as caught:
        await workers.run(os.getpid)
    assert answer(caught.value).status == 503
    for each in asking:
        each.cancel()
    await asyncio.wait(asking)
    await eventually(lambda: not workers.jobs)
    assert await workers.run(os.getpid) != os.getpid()


async def test_memory_has_a_bound(workers: Workers) -> None:
    with pytest.raises(CostError, match="more memory"):
        await workers.run(functools.partial(np.ones, 10**9))
    assert await workers.run(os.getpid) != os.getpid()


_held: list[object] = []


def hold(count: int) -> int:
    """Take so many bytes and let nobody have them back."""
    _held.append(np.ones(count, np.uint8))
    return os.getpid()


async def test_a_worker_that_has_grown_ends_with_its_work(workers: Workers) -> None:
    little, much = (functools.partial(hold, part) for part in (KEPT // 4, KEPT))
    pid = await workers.run(little)
    assert await workers.run(little) == pid
    assert await workers.run(much) == pid
    assert not lives(pid), "what it held is given back, and what came of its work is there"
    assert await workers.run(little) != pid


async def test_a_worker_that_dies_is_replaced(workers: Workers) -> None:
    with pytest.raises(EndedError) as caught:
        await workers.run(functools.partial(os._exit, 1))
    assert answer(caught.value).status == 503
    assert await workers.run(os.getpid) != os.getpid()


async def test_a_worker_that_is_killed_while_it_waits_costs_nobody_an_answer(
    workers: Workers,
) -> None:
    pid = await workers.run(os.getpid)
    os.kill(pid, signal.SIGKILL)
    await eventually(lambda: not lives(pid))
    assert await workers.run(os.getpid) not in (pid, os.getpid())


async def test_closing_ends_what_runs_and_what_waits() -> None:
    workers = Workers(1, 4)
    asking = [asyncio.create_task(workers.run(FOR_EVER)) for _ in range(3)]
    await running_for(workers, 1)
    (pid,) = workers.pids
    workers.close()
    ends = await asyncio.gather(*asking, return_exceptions=True)
    assert [answer(end).status for end in ends if isinstance(end, Exception)] == [503] * 3
    await eventually(lambda: not lives(pid))
    with pytest.raises(BusyError):
        await workers.run(os.getpid)
