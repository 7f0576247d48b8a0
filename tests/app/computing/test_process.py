"""Workers as real processes: their work, their limits, and how they end."""

import asyncio
import errno
import functools
import os
import signal
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.scenes.expensive_boards import hall
from plinko.app.computing import process
from plinko.app.computing.inside import KEPT
from plinko.app.computing.pool import Workers
from plinko.app.computing.process import WorkerProcess
from plinko.app.errors import CostError, DeadlineError, EndedError, InvalidValueError, response_for
from plinko.engine import Board, drop_many
from plinko.engine.drops.batch import LEAST_CHUNK
from tests.kit.waiting import eventually, lives

FOR_EVER = functools.partial(time.sleep, 3600.0)


@pytest.fixture
async def workers() -> AsyncIterator[Workers]:
    made = Workers(2, 4)
    yield made
    made.close()


@pytest.fixture
async def fork_server(workers: Workers) -> AsyncIterator[int]:
    """The process that starts and reaps workers; it is continued if the test stopped it."""
    pid = await workers.run(os.getppid)
    yield pid
    os.kill(pid, signal.SIGCONT)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[WorkerProcess]:
    """Every worker process started during the test."""
    found: list[WorkerProcess] = []

    class Noted(WorkerProcess):
        def __init__(self) -> None:
            super().__init__()
            found.append(self)

    monkeypatch.setattr(process, "WorkerProcess", Noted)
    return found


def refuse() -> None:
    raise InvalidValueError("7 is too many", field="balls")


def spin() -> None:
    while True:
        pass


def pid_once_told(fifo: Path) -> int:
    """Block until the test writes to this pipe; returns the worker's process id."""
    fifo.read_bytes()
    return os.getpid()


async def running(workers: Workers, count: int) -> list[int]:
    await eventually(lambda: len(workers._working) == count)
    return [worker.pid for worker in workers._working]


async def gone(pid: int) -> None:
    await eventually(lambda: not lives(pid))


async def test_another_process_does_the_work_and_returns_its_errors(workers: Workers) -> None:
    assert await workers.run(os.getpid) != os.getpid()
    with pytest.raises(InvalidValueError, match="7 is too many") as caught:
        await workers.run(refuse)
    assert caught.value.field == "balls"
    assert workers.jobs == 0
    # A result that cannot be pickled is an error, too.
    pid = await workers.run(os.getpid)
    with pytest.raises(TypeError, match="pickle"):
        await workers.run(functools.partial(open, os.devnull))
    assert await workers.run(os.getpid) == pid


async def test_a_worker_is_polite_but_not_the_fork_server(workers: Workers) -> None:
    """A server that starts or stops on a busy machine waits for its fork server."""
    maker = await workers.run(os.getppid)
    own = os.getpriority(os.PRIO_PROCESS, 0)
    theirs = await workers.run(functools.partial(os.getpriority, os.PRIO_PROCESS, 0))
    assert theirs == min(own + 10, 19)
    assert os.getpriority(os.PRIO_PROCESS, maker) == own


_boards: list[Board] = []


def met_before(board: Board) -> bool:
    """Whether the previous call in this worker was given the same object."""
    met = bool(_boards) and _boards[-1] is board
    _boards.append(board)
    return met


async def test_a_board_is_packed_once_and_unpacked_once(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not await workers.run(functools.partial(met_before, Board.from_json(hall())))
    monkeypatch.setattr(Board, "__reduce_ex__", refuse)
    assert await workers.run(functools.partial(met_before, Board.from_json(hall())))


async def test_a_worker_that_gets_no_core_is_waited_for(workers: Workers) -> None:
    """It sleeps for five times its limit: only the time in which it computes counts."""
    pid = await workers.run(os.getpid)
    await workers.run(functools.partial(time.sleep, 0.5), deadline=0.1)
    assert await workers.run(os.getpid) == pid


def compute_and_wait(fifo: Path) -> None:
    """Compute for 0.2 s, sleep for half a second, tell the test, and never return."""
    while time.process_time() < 0.2:
        pass
    time.sleep(0.5)
    fifo.write_bytes(b"computed")
    FOR_EVER()


async def test_a_caller_that_leaves_has_spent_what_was_computed(
    workers: Workers, tmp_path: Path
) -> None:
    os.mkfifo(fifo := tmp_path / "fifo")
    spent: list[float] = []
    work = functools.partial(compute_and_wait, fifo)
    asking = asyncio.create_task(workers.measured(work, spend=spent.append))
    await asyncio.to_thread(fifo.read_bytes)
    asking.cancel()
    await asyncio.wait([asking])
    assert len(spent) == 1
    assert 0.1 < spent[0] < 0.5, "the time that it slept is not the caller's"
    assert workers.seconds == spent[0]


async def test_a_caller_that_leaves_before_its_turn_has_spent_nothing(workers: Workers) -> None:
    spent: list[float] = []
    asking: list[asyncio.Task[Any]] = [asyncio.create_task(workers.run(FOR_EVER)) for _ in range(2)]
    await running(workers, 1)
    asking.append(asyncio.create_task(workers.measured(FOR_EVER, spend=spent.append)))
    await eventually(lambda: workers.jobs == 3)
    for each in reversed(asking):
        each.cancel()
    await asyncio.wait(asking)
    assert spent == []


HALL = Board.from_json(hall())
"""On it balls bounce 100,000 times, in one call of a kernel that takes minutes."""


@pytest.mark.parametrize(
    "work", [spin, functools.partial(drop_many, HALL, range(LEAST_CHUNK), threads=1)]
)
async def test_work_over_its_deadline_is_ended_has_spent_it_and_the_next_is_done(
    workers: Workers, work: Callable[[], object]
) -> None:
    pid, spent = await workers.run(os.getpid), list[float]()
    with pytest.raises(DeadlineError, match=r"longer than the 0\.1 s") as caught:
        await workers.measured(work, deadline=0.1, spend=spent.append)
    assert (spent, response_for(caught.value).status) == ([0.1], 422)
    await gone(pid)
    assert await workers.run(os.getpid) != pid


async def test_a_caller_that_leaves_before_the_start_leaves_no_process(
    workers: Workers, fork_server: int, made: list[WorkerProcess], tmp_path: Path
) -> None:
    os.mkfifo(fifo := tmp_path / "fifo")
    first = asyncio.create_task(workers.run(functools.partial(pid_once_told, fifo)))
    await running(workers, 1)
    os.kill(fork_server, signal.SIGSTOP)
    asking = asyncio.create_task(workers.run(FOR_EVER, quick=True))
    await eventually(lambda: workers.jobs == 2)
    asking.cancel()
    await asyncio.wait([asking])
    assert made == []
    os.kill(fork_server, signal.SIGCONT)
    await eventually(lambda: made and not lives(made[0].pid))
    fifo.write_bytes(b"go on")
    assert await workers.run(os.getpid, quick=True) != await first


@pytest.mark.parametrize("watched", [True, False])
async def test_a_caller_that_leaves_ends_its_work(
    workers: Workers, monkeypatch: pytest.MonkeyPatch, watched: bool
) -> None:
    """A process that the system cannot watch is killed by its number."""

    def unknown(pid: int) -> int:
        raise OSError(errno.ENOSYS, "no such system call")

    if not watched:
        monkeypatch.setattr(os, "pidfd_open", unknown, raising=False)
    asking = asyncio.create_task(workers.run(FOR_EVER))
    (pid,) = await running(workers, 1)
    asking.cancel()
    await asyncio.wait([asking])
    assert workers.jobs == 0
    await gone(pid)


@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="not on this system")
async def test_a_number_that_may_be_another_process_s_is_not_killed(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    pid = await workers.run(os.getpid)
    os.kill(pid, signal.SIGKILL)
    await eventually(lambda: not Path(f"/proc/{pid}").exists())
    killed: list[int] = []
    monkeypatch.setattr(os, "kill", lambda pid, _: killed.append(pid))
    workers.close()
    assert killed == []


async def test_memory_has_a_bound(workers: Workers) -> None:
    with pytest.raises(CostError, match="more memory"):
        await workers.run(functools.partial(np.ones, 10**9))
    assert await workers.run(os.getpid) != os.getpid()


_held: list[object] = []


def hold(count: int) -> int:
    """Allocate this many bytes and never free them; returns the worker's process id."""
    _held.append(np.ones(count, np.uint8))
    return os.getpid()


async def test_a_worker_that_has_grown_ends_with_its_work(workers: Workers) -> None:
    little, much = (functools.partial(hold, part) for part in (KEPT // 4, KEPT))
    pid = await workers.run(little)
    assert await workers.run(little) == pid
    assert await workers.run(much) == pid, "what came of its work is there"
    await gone(pid)
    assert await workers.run(little) != pid


async def test_killing_an_idle_worker_loses_no_answer(
    workers: Workers, fork_server: int, tmp_path: Path
) -> None:
    """The fork server is stopped, so it cannot report that the worker has ended."""
    os.mkfifo(fifo := tmp_path / "fifo")
    first = asyncio.create_task(workers.run(functools.partial(pid_once_told, fifo)))
    await running(workers, 1)
    other = await workers.run(os.getpid, quick=True)
    fifo.write_bytes(b"go on")
    newest = await first  # the pool would ask this worker next
    assert newest != other
    os.kill(fork_server, signal.SIGSTOP)
    os.kill(newest, signal.SIGKILL)
    await gone(newest)
    assert await workers.run(os.getpid) == other


def exit_after_writing(file: Path) -> None:
    with file.open("a") as lines:
        lines.write("begun\n")
    os._exit(1)


async def test_work_that_has_begun_is_never_done_twice(workers: Workers, tmp_path: Path) -> None:
    await workers.run(os.getpid)
    with pytest.raises(EndedError) as caught:
        await workers.run(functools.partial(exit_after_writing, tmp_path / "lines"))
    assert response_for(caught.value).status == 503
    assert (tmp_path / "lines").read_text() == "begun\n"
    assert await workers.run(os.getpid) != os.getpid(), "another worker took its place"


async def test_closing_ends_what_runs_and_what_waits() -> None:
    workers = Workers(1, 4)
    asking = [asyncio.create_task(workers.run(FOR_EVER)) for _ in range(3)]
    (pid,) = await running(workers, 1)
    workers.close()
    ends = await asyncio.gather(*asking, return_exceptions=True)
    assert [response_for(end).status for end in ends if isinstance(end, Exception)] == [503] * 3
    await gone(pid)
