"""The queue in front of the workers; the test decides each step of the workers."""

import asyncio

import pytest

from plinko.app.computing.pool import Workers
from plinko.app.computing.process import Done, WorkerProcess
from plinko.app.errors import BusyError, EndedError, response_for
from tests.kit.waiting import turns


def nothing() -> object:
    """Work that a scripted worker never runs."""
    raise AssertionError


class Scripted(WorkerProcess):
    """A worker whose replies the test makes."""

    def __init__(self) -> None:
        self.spent = 0.0
        self.ends = False
        self.ended = False
        self.asked: list[bytes] = []
        self.said: asyncio.Future[Done | None] = asyncio.get_running_loop().create_future()

    @property
    def pid(self) -> int:
        return id(self)

    async def do(self, work: bytes, seconds: float) -> Done | None:
        self.asked.append(work)
        self.said = asyncio.get_running_loop().create_future()
        return await self.said

    def says(self, value: object) -> None:
        self.spent = 0.5
        self.said.set_result(Done(value, None, self.spent))

    def kill(self) -> None:
        self.said.set_exception(EndedError("killed"))

    def end(self) -> None:
        self.ended = True


class Pool(Workers):
    """A pool of scripted workers; `made` lists them in the order of their start."""

    def __init__(self, processes: int, max_jobs: int) -> None:
        self.made: list[Scripted] = []
        super().__init__(processes, max_jobs, start=self._scripted)

    async def _scripted(self) -> WorkerProcess:
        self.made.append(Scripted())
        return self.made[-1]

    async def asks(self, *, quick: bool = False) -> asyncio.Task[object]:
        """Start a caller, and return when its work has begun or is queued."""
        asking = asyncio.create_task(self.run(nothing, quick=quick))
        await turns()
        return asking


async def test_one_worker_does_one_thing_after_the_other() -> None:
    pool = Pool(1, 4)
    first, second = await pool.asks(), await pool.asks()
    (worker,) = pool.made
    assert len(worker.asked) == 1
    worker.says("one")
    await turns()
    worker.says("two")
    assert [await first, await second] == ["one", "two"]
    assert (pool.jobs, pool.seconds, worker.ended) == (0, 1.0, False)


async def test_long_work_leaves_a_worker_for_quick_work() -> None:
    pool = Pool(2, 4)
    long = [await pool.asks() for _ in range(3)]
    assert len(pool._working) == 1
    quick = await pool.asks(quick=True)
    assert len(pool._working) == 2
    pool.made[1].says("quick")
    assert await quick == "quick"
    await turns()
    assert len(pool._working) == 1, "the others still wait for the worker that long work may have"
    pool.close()
    await asyncio.wait(long)


async def test_quick_work_goes_first() -> None:
    pool = Pool(1, 4)
    running = await pool.asks()
    long, quick = await pool.asks(), await pool.asks(quick=True)
    (worker,) = pool.made
    for value in ("running", "second", "third"):
        worker.says(value)
        await turns()
    assert [await running, await quick, await long] == ["running", "second", "third"]


async def test_a_full_queue_refuses_work_until_it_drains() -> None:
    pool = Pool(2, 4)
    asking = [await pool.asks() for _ in range(6)]
    assert pool.full
    with pytest.raises(BusyError) as caught:
        await pool.run(nothing)
    assert response_for(caught.value).status == 503
    for each in asking:
        each.cancel()
    await asyncio.wait(asking)
    assert pool.jobs == 0
    assert [worker.ended for worker in pool.made] == [True]
    again = await pool.asks()
    pool.made[-1].says(7)
    assert await again == 7


async def test_a_caller_that_leaves_the_queue_gives_up_its_turn() -> None:
    pool = Pool(1, 4)
    running, goes, stays = [await pool.asks() for _ in range(3)]
    pool.made[0].says("running")
    await running  # in this iteration of the loop the next caller is admitted, and leaves
    goes.cancel()
    await turns()
    assert goes.cancelled()
    pool.made[-1].says("stays")
    assert await stays == "stays"
    assert pool.jobs == 0


async def test_a_worker_with_an_unread_reply_is_never_used_again() -> None:
    """The caller is cancelled after the worker's reply and before it has received it."""
    pool = Pool(1, 4)
    asking = await pool.asks()
    pool.made[0].says("a reply")
    asking.cancel()
    await asyncio.wait([asking])
    assert asking.cancelled()
    assert pool.made[0].ended
    again = await pool.asks()
    assert len(pool.made) == 2
    pool.made[1].says("another")
    assert await again == "another"


async def test_work_not_begun_by_an_ended_worker_moves_to_another() -> None:
    pool = Pool(3, 4)
    asking = [await pool.asks(quick=True) for _ in range(3)]
    for number, worker in enumerate(pool.made):
        worker.says(number)
    await asyncio.wait(asking)
    again = await pool.asks()
    for worker in (pool.made[2], pool.made[1]):  # the worker used last is asked first
        worker.said.set_result(None)
        await turns()
        assert worker.ended
    pool.made[0].says("done")
    assert await again == "done"
    assert len(pool.made) == 3


async def test_a_new_worker_that_has_not_begun_is_an_error() -> None:
    """The work may be what ended it, and would end the next worker, too."""
    pool = Pool(1, 4)
    asking = await pool.asks()
    pool.made[0].said.set_result(None)
    with pytest.raises(EndedError):
        await asking
    assert pool.made[0].ended
    assert pool.jobs == 0


async def test_work_that_had_begun_is_not_done_again() -> None:
    pool = Pool(1, 4)
    first = await pool.asks()
    pool.made[0].says("first")
    await first
    second = await pool.asks()
    pool.made[0].said.set_exception(EndedError("killed while it worked"))
    with pytest.raises(EndedError):
        await second
    assert len(pool.made) == 1
    assert pool.made[0].ended


async def test_a_worker_that_ends_after_its_reply_is_not_idle() -> None:
    pool = Pool(1, 4)
    first = await pool.asks()
    pool.made[0].ends = True
    pool.made[0].says("grown")
    assert await first == "grown"
    assert pool.made[0].ended
    await pool.asks()
    assert len(pool.made) == 2
    pool.close()


async def test_closing_ends_what_runs_and_refuses_what_waits() -> None:
    pool = Pool(2, 4)
    idle = await pool.asks(quick=True)
    pool.made[0].says("idle")
    await idle
    asking = [await pool.asks() for _ in range(3)]
    pool.close()
    ends = await asyncio.gather(*asking, return_exceptions=True)
    assert [type(end) for end in ends] == [EndedError, BusyError, BusyError]
    assert [response_for(end).status for end in ends if isinstance(end, Exception)] == [503] * 3
    assert all(worker.ended for worker in pool.made)
    with pytest.raises(BusyError, match="the server is stopping"):
        await pool.run(nothing)


async def test_a_worker_that_has_started_after_the_end_is_ended() -> None:
    go = asyncio.Event()
    worker = Scripted()

    async def late() -> WorkerProcess:
        await go.wait()
        return worker

    workers = Workers(1, 4, start=late)
    asking = asyncio.create_task(workers.run(nothing))
    await turns()
    workers.close()
    go.set()
    with pytest.raises(BusyError):
        await asking
    assert worker.ended
    assert worker.asked == []


async def test_a_trial_computes_once_for_all_callers_and_says_no_where_no_process_starts() -> None:
    pool = Pool(1, 1)
    asking = [asyncio.create_task(pool.compute()) for _ in range(5)]
    await turns()
    (worker,) = pool.made
    assert len(worker.asked) == 1
    worker.says(4711)
    assert await asyncio.gather(*asking) == [True] * 5

    async def fails() -> WorkerProcess:
        raise EndedError("no process could be started for it")

    assert not await Workers(1, 1, start=fails).compute()
