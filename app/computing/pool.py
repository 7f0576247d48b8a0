"""The workers: a bounded queue before a few processes, quick things first, an end to everything."""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass, field
from typing import Final, TypeVar, cast

from app.computing.packing import packed
from app.computing.process import Done, WorkerProcess, prepare, start
from app.concurrency.single_flight import SingleFlight
from app.errors import AppError, BusyError, EndedError

T = TypeVar("T")

DEADLINE: Final = 10.0  # s of a core that one thing may compute

MAX_JOBS: Final = 64  # that wait for the processes, before more are refused with 503

PATIENCE: Final = 6.0
"""Times the s that something may compute after which it is ended whatever it has computed: where
others keep the machine busy, a worker, being polite, may wait for long."""


@dataclass(slots=True, eq=False)
class _Job:
    quick: bool
    turn: asyncio.Event = field(default_factory=asyncio.Event)


class Workers:
    """Processes that compute what is asked for; for the event loop's thread.

    They are started when there is work for them. What takes long never holds all of them, so that
    what is quick never waits for it, unless there is only one.
    """

    def __init__(
        self,
        processes: int,
        max_jobs: int,
        *,
        patience: float = PATIENCE,
        start: Callable[[], Awaitable[WorkerProcess]] = start,
    ) -> None:
        self.processes = processes
        self.max_jobs = max_jobs
        self.seconds = 0.0  # computed until now, of one core
        self._patience = patience
        self._start = start
        self._waiting: list[_Job] = []
        self._running: list[_Job] = []
        self._idle: list[WorkerProcess] = []
        self._working: list[WorkerProcess] = []
        self._closed = False
        self._trial = SingleFlight[bool]()

    @property
    def jobs(self) -> int:
        """Running or waiting."""
        return len(self._waiting) + len(self._running)

    @property
    def full(self) -> bool:
        """Whether more work would be refused."""
        return self.jobs >= self.max_jobs + self.processes

    @property
    def pids(self) -> list[int]:
        """Of the processes that compute something now."""
        return [worker.pid for worker in self._working]

    def prepare(self) -> None:
        """Begin to load what the processes need."""
        if not self._closed:
            prepare()

    async def compute(self) -> bool:
        """Whether a process starts and computes something now: tried, once for all who ask."""
        return await self._trial.do("compute", self._try)

    async def _try(self) -> bool:
        try:
            return bool(await self.run(os.getpid, quick=True))
        except AppError:
            return False

    async def run(
        self, work: Callable[[], T], *, quick: bool = False, deadline: float = DEADLINE
    ) -> T:
        """The result of `work()`, a function of a module, done in a process.

        Raises what it raises; BusyError when too much waits; DeadlineError when it computes for
        more than `deadline` s of a core, however long it had to wait for one, or is not done in
        `patience` times as long; EndedError when the process ended. A caller that is cancelled
        ends the work.
        """
        done = await self.measured(work, quick=quick, deadline=deadline)
        if done.error is not None:
            raise done.error
        return cast(T, done.value)

    async def measured(
        self, work: Callable[[], object], *, quick: bool = False, deadline: float = DEADLINE
    ) -> Done:
        """`run`, with what it took; an error of the work's own is in the result."""
        if self.full or self._closed:
            raise BusyError(f"{self.jobs} jobs are computed or wait already")
        async with self._turn(quick):
            message = packed(work)
            while self._idle:  # one of them may have ended since its last work
                if done := await self._by(self._idle.pop(), message, deadline):
                    return done
            if done := await self._by(await self._start(), message, deadline):
                return done
            raise EndedError("the process that was to compute it ended")

    def close(self) -> None:
        """Refuse what waits and end what runs."""
        self._closed = True
        for job in self._waiting:
            job.turn.set()
        for worker in self._working:
            worker.kill()
        while self._idle:
            self._idle.pop().end()

    @contextlib.asynccontextmanager
    async def _turn(self, quick: bool) -> AsyncIterator[None]:
        """Wait until a process may begin this job, and keep its place until it is done."""
        job = _Job(quick)
        self._waiting.append(job)
        self._admit()
        try:
            await job.turn.wait()
            if self._closed:
                raise BusyError("the server is stopping")
            yield
        finally:
            (self._waiting if job in self._waiting else self._running).remove(job)
            self._admit()

    def _admit(self) -> None:
        """Let jobs begin, quick ones first, while there are processes for them."""
        for job in sorted(self._waiting, key=lambda job: not job.quick):
            long = sum(not other.quick for other in self._running)
            free = len(self._running) < self.processes
            if free and (job.quick or long < max(1, self.processes - 1)):
                self._waiting.remove(job)
                self._running.append(job)
                job.turn.set()

    async def _by(self, worker: WorkerProcess, work: bytes, seconds: float) -> Done | None:
        """What this worker makes of it; it is idle afterwards, or ended if anything went wrong."""
        done = None
        self._working.append(worker)
        try:
            if self._closed:
                raise BusyError("the server is stopping")
            done = await worker.do(work, seconds, self._patience * seconds)
        finally:
            self._working.remove(worker)
            if done is None or worker.ends or self._closed:
                worker.end()
            else:
                self._idle.append(worker)
        self.seconds += done.seconds if done else 0.0
        return done
