"""The workers: a bounded queue before a few processes, quick things first, an end to everything."""

import asyncio
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Final, TypeVar, cast

from app.computing.process import Done, WorkerProcess, prepare
from app.errors import BusyError, EndedError

T = TypeVar("T")

DEADLINE: Final = 10.0  # s of a core that one thing may compute


@dataclass(slots=True, eq=False)
class _Job:
    work: Callable[[], Any]
    seconds: float
    quick: bool
    future: "asyncio.Future[Done]"
    worker: WorkerProcess | None = None


class Workers:
    """Processes that compute what is asked for; for the event loop's thread.

    They are started when there is work for them. What takes long never holds all of them, so that
    what is quick never waits for it, unless there is only one.
    """

    def __init__(self, processes: int, max_jobs: int) -> None:
        self.processes = processes
        self.max_jobs = max_jobs
        self.jobs = 0  # running or waiting
        self.seconds = 0.0  # computed so far, of one core
        self._quick: deque[_Job] = deque()
        self._long: deque[_Job] = deque()
        self._running: set[_Job] = set()
        self._idle: list[WorkerProcess] = []
        # Each waits for one process and does little besides. They may have to start it, and it
        # leaves a core of those that whoever starts it has: so they have all.
        self._threads = ThreadPoolExecutor(processes, thread_name_prefix="worker")
        self._closed = False

    @property
    def full(self) -> bool:
        """Whether more work would be refused."""
        return self.jobs >= self.max_jobs + self.processes

    @property
    def pids(self) -> list[int]:
        """Of the processes that compute something now."""
        found = (job.worker.pid for job in self._running if job.worker is not None)
        return [pid for pid in found if pid is not None]

    def prepare(self) -> None:
        """Begin to load what the processes need."""
        if not self._closed:
            prepare()

    async def run(
        self, work: Callable[[], T], *, quick: bool = False, deadline: float = DEADLINE
    ) -> T:
        """The result of `work()`, a function of a module, done in a process.

        Raises what it raises; BusyError when too much waits, DeadlineError when it computes for
        more than so many s of a core, however long it had to wait for one. Who is cancelled
        meanwhile ends it.
        """
        done = await self.measured(work, quick=quick, deadline=deadline)
        if done.error is not None:
            raise done.error
        return cast(T, done.value)

    async def measured(
        self, work: Callable[[], Any], *, quick: bool = False, deadline: float = DEADLINE
    ) -> Done:
        """`run`, with what it took; an error of the work's own is in the result."""
        if self.full or self._closed:
            raise BusyError(f"{self.jobs} jobs are computed or wait already")
        future: asyncio.Future[Done] = asyncio.get_running_loop().create_future()
        job = _Job(work, deadline, quick, future)
        self.jobs += 1
        (self._quick if quick else self._long).append(job)
        self._dispatch()
        try:
            return await future
        except asyncio.CancelledError:
            self._drop(job)
            raise

    def close(self) -> None:
        """Drop what waits and end what runs."""
        self._closed = True
        for job in [*self._quick, *self._long]:
            self._drop(job)
            job.future.set_exception(BusyError("the server is stopping"))
        for job in self._running:
            if job.worker is not None:
                job.worker.end()
        for worker in self._idle:
            worker.end()
        self._idle.clear()
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _drop(self, job: _Job) -> None:
        """Nobody waits for this job any more."""
        if job in self._running:
            if job.worker is not None:
                job.worker.end()
            return
        for queue in (self._quick, self._long):
            if job in queue:
                queue.remove(job)
                self.jobs -= 1

    def _dispatch(self) -> None:
        while not self._closed and (job := self._next()) is not None:
            job.worker = self._idle.pop() if self._idle else WorkerProcess()
            self._running.add(job)
            loop = asyncio.get_running_loop()
            answer = loop.run_in_executor(self._threads, job.worker.do, job.work, job.seconds)
            answer.add_done_callback(lambda done, job=job: self._finish(job, done))  # type: ignore[misc]

    def _next(self) -> _Job | None:
        """The job whose turn it is, if there is a process for it."""
        if len(self._running) >= self.processes:
            return None
        if self._quick:
            return self._quick.popleft()
        long = sum(not job.quick for job in self._running)
        if self._long and long < max(1, self.processes - 1):
            return self._long.popleft()
        return None

    def _finish(self, job: _Job, answer: "asyncio.Future[Done]") -> None:
        self._running.discard(job)
        self.jobs -= 1
        error = None if answer.cancelled() else answer.exception()
        ended = answer.cancelled() or isinstance(error, EndedError)
        if job.worker is not None and not ended and not self._closed:
            self._idle.append(job.worker)
        if not answer.cancelled() and error is None:
            self.seconds += answer.result().seconds
        if not job.future.done():
            if answer.cancelled():
                job.future.cancel()
            elif error is not None:
                job.future.set_exception(error)
            else:
                job.future.set_result(answer.result())
        self._dispatch()
