"""The pool of workers: a bounded queue for a few processes, quick jobs first, with deadlines."""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass, field
from typing import Final, TypeVar, cast

from plinko.app.computing.packing import packed
from plinko.app.computing.process import Done, WorkerProcess, prepare, start
from plinko.app.concurrency.single_flight import SingleFlight
from plinko.app.errors import AppError, BusyError, EndedError

T = TypeVar("T")

DEADLINE: Final = 10.0
"""CPU seconds that one job may take. Real time has no limit: on a busy machine a worker with its
low priority waits long for a core. If the client leaves, its job ends."""

MAX_JOBS: Final = 64  # jobs that may wait; more are refused with 503


@dataclass(slots=True, eq=False)
class _Job:
    quick: bool
    turn: asyncio.Event = field(default_factory=asyncio.Event)


class Workers:
    """Processes that compute for requests; used from the event loop's thread only.

    They are started on demand. Long jobs never occupy all of them, so that a quick job never waits
    for a long one, unless there is only one process.
    """

    def __init__(
        self,
        processes: int,
        max_jobs: int,
        *,
        start: Callable[[], Awaitable[WorkerProcess]] = start,
    ) -> None:
        self.processes = processes
        self.max_jobs = max_jobs
        self.seconds = 0.0  # CPU seconds of all jobs until now
        self._start = start
        self._waiting: list[_Job] = []
        self._running: list[_Job] = []
        self._idle: list[WorkerProcess] = []
        self._working: list[WorkerProcess] = []
        self._closed = False
        self._trial = SingleFlight[bool]()

    @property
    def jobs(self) -> int:
        """Number of jobs that run or wait."""
        return len(self._waiting) + len(self._running)

    @property
    def full(self) -> bool:
        """Whether another job would be refused."""
        return self.jobs >= self.max_jobs + self.processes

    def prepare(self) -> None:
        """Begin to load the code of the workers, in the fork server."""
        if not self._closed:
            prepare()

    async def compute(self) -> bool:
        """Whether a worker can start and compute now. Concurrent callers share one trial."""
        return await self._trial.do("compute", self._try)

    async def _try(self) -> bool:
        try:
            return bool(await self.run(os.getpid, quick=True))
        except AppError:
            return False

    async def run(
        self, work: Callable[[], T], *, quick: bool = False, deadline: float = DEADLINE
    ) -> T:
        """Run `work`, a module's function, in a worker and return its result.

        Raises what `work` raises; BusyError if too many jobs wait; DeadlineError if it takes more
        than `deadline` CPU seconds; EndedError if the worker ended. Cancelling the caller kills the
        worker.
        """
        done = await self.measured(work, quick=quick, deadline=deadline)
        if done.error is not None:
            raise done.error
        return cast(T, done.value)

    async def measured(
        self,
        work: Callable[[], object],
        *,
        quick: bool = False,
        deadline: float = DEADLINE,
        spend: Callable[[float], None] = lambda seconds: None,
    ) -> Done:
        """Like `run`, but return the time it took too; an error that `work` raised is in `Done`.

        `spend` is called with the CPU seconds used, even if the work is interrupted.
        """
        self._check_open()
        if self.full:
            raise BusyError(f"the server already has {self.jobs} jobs; try again later")
        async with self._turn(quick):
            message = packed(work)
            while self._idle:  # an idle worker may have ended since its last job
                if done := await self._by(self._idle.pop(), message, deadline, spend):
                    return done
            if done := await self._by(await self._start(), message, deadline, spend):
                return done
            raise EndedError("the process that should compute this ended; try again")

    def close(self) -> None:
        """Refuse the jobs that wait and kill those that run."""
        self._closed = True
        for job in self._waiting:
            job.turn.set()
        for worker in self._working:
            worker.kill()
        while self._idle:
            self._idle.pop().end()

    def _check_open(self) -> None:
        if self._closed:
            raise BusyError("the server is stopping")

    @contextlib.asynccontextmanager
    async def _turn(self, quick: bool) -> AsyncIterator[None]:
        """Wait for the job's turn, and occupy its place until the caller is done."""
        job = _Job(quick)
        self._waiting.append(job)
        self._admit()
        try:
            await job.turn.wait()
            self._check_open()
            yield
        finally:
            (self._waiting if job in self._waiting else self._running).remove(job)
            self._admit()

    def _admit(self) -> None:
        """Start waiting jobs, quick ones first, while processes are free."""
        for job in sorted(self._waiting, key=lambda job: not job.quick):
            long = sum(not other.quick for other in self._running)
            free = len(self._running) < self.processes
            if free and (job.quick or long < max(1, self.processes - 1)):
                self._waiting.remove(job)
                self._running.append(job)
                job.turn.set()

    async def _by(
        self, worker: WorkerProcess, work: bytes, seconds: float, spend: Callable[[float], None]
    ) -> Done | None:
        """Have this worker do the job; then keep it as idle, or end it if anything went wrong."""
        done = None
        self._working.append(worker)
        try:
            self._check_open()
            done = await worker.do(work, seconds)
        finally:
            self._working.remove(worker)
            self.seconds += worker.spent
            spend(worker.spent)
            if done is None or worker.ends or self._closed:
                worker.end()
            else:
                self._idle.append(worker)
        return done
