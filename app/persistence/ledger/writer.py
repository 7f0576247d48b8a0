"""The ledger's interface for the event loop: hands reads and writes to the ledger's thread.

The thread commits all waiting writes in one transaction. When a caller receives the outcome of a
write, it is final: durable or refused (`commit_queue` decides). If a commit fails or takes too
long, all writes that were not sent are refused, and so are new ones until the thread has succeeded
with a commit again. Writes that were sent wait until the database has decided; `decided` raises
UndecidedError meanwhile. Kept writes (results, marks of progress, ends of runs) are retried through
all failures until they are durable. They are refused only if the database rejects them, or if
another server has taken their room.
"""

import asyncio
import logging
import threading
import time
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, Concatenate, Final, ParamSpec, TypeVar

from sqlalchemy import Connection

from plinko.app.concurrency.single_flight import log_failure
from plinko.app.errors import LeaseLostError, LedgerError, UndecidedError
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.persistence.ledger.commit_queue import CommitQueue, Done, Job
from plinko.app.persistence.ledger.committer import Answers, Committer
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.statements import keys
from plinko.app.rooms.keys import KeyUse, UsedKey
from plinko.app.rooms.records import Lease, NewDrop, Write

T = TypeVar("T")
P = ParamSpec("P")

_FORGET: Final = 0.9  # factor by which each commit lowers the remembered longest latency
COMMIT_PATIENCE: Final = 2.0  # s that a commit may take before drops get 503

_POLLS: Final = 4  # of the thread's progress within `patience`
_CLOSE_SECONDS: Final = 10.0  # for the last writes at a stop; the next start recomputes lost ones

_log = logging.getLogger("plinko")


class CommitWaiter:
    """A caller that waits for a task to end, or for the ledger to fail before that."""

    def __init__(self, task: "asyncio.Future[Any]") -> None:
        self.task = task
        self.woken: asyncio.Future[None] = task.get_loop().create_future()
        task.add_done_callback(self.wake)

    def wake(self, _: object = None) -> None:
        """Wake the caller: the task has ended, or the ledger has failed."""
        if not self.woken.done():
            self.woken.set_result(None)


class Ledger:
    """Except `open`, all methods are for the event loop's thread, and do not block it.

    At most one commit starts in each `period` seconds of `clock`, so that drops of one tick share
    one. If the thread makes no progress for `patience` seconds, all open jobs are refused.
    `on_commit` is called with the duration of each commit in s. `leases` stamps writes with leases,
    and is called with lost ones before the callers whose writes are refused for that. `targets` are
    the addresses of webhooks.
    """

    def __init__(
        self,
        database: Database,
        *,
        period: float,
        patience: float,
        clock: Callable[[], float] = time.monotonic,
        on_commit: Callable[[float], None] = lambda seconds: None,
        leases: LeaseBook | None = None,
        targets: Sequence[str] = (),
    ) -> None:
        self.database = database
        self.patience = patience
        self.commits = 0
        self.failures = 0
        self.lag = 0.0  # s from submission to durability: the longest of the recent commits
        self._on_commit = on_commit
        self.leases = leases or LeaseBook()
        self._clock = clock
        self._queue = CommitQueue()
        self._watched = False
        self._seen = 0  # progress at the last poll
        self._silence = 0  # number of polls without progress
        self._loop: asyncio.AbstractEventLoop | None = None
        self._waiters: set[CommitWaiter] = set()
        answers = Answers(
            call=self._call,
            committed=self._committed,
            refused=self._refused,
            read=_report,
            recovered=self._recovered,
            lost=self._lost,
        )
        self.committer = Committer(
            database, self._queue, answers, period=period, clock=clock, targets=targets
        )
        self._thread = threading.Thread(target=self.committer.run, name="ledger", daemon=True)

    def open(self) -> None:
        """Open the database if it is not open; blocks. Raises SettingError."""
        if not self.database.is_open:
            self.database.open()

    def start(self) -> None:
        """Begin to accept writes, in the running event loop."""
        self.attach(asyncio.get_running_loop())
        self._thread.start()

    def attach(self, loop: asyncio.AbstractEventLoop) -> None:
        """As `start`, but without the thread: the caller runs `committer`'s turns."""
        self._loop = loop
        self._queue.open()

    @property
    def problem(self) -> str | None:
        """Why nothing can be written now; None if writes work."""
        failure = self._queue.failure
        return None if failure is None else str(failure)

    @property
    def up(self) -> bool:
        return self._queue.failure is None

    def submit(self, *writes: Write, use: KeyUse | None = None) -> "asyncio.Future[None]":
        """Commit `writes` in one transaction; the future ends when they are durable or refused.

        They are skipped if the `use` of the request's key is not new.
        Raises LedgerError if the ledger cannot be written now.
        """
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        leases = [lease for lease, _ in self.leases.stamp(writes) if lease is not None]
        task = asyncio.current_task()
        self._put(Job(writes, _settle(future), tuple(leases), task=task, use=use))
        return future

    async def drop(self, request: NewDrop, *before: Write) -> NewDrop:
        """Make a drop a fact, after the writes `before`; returns the request with its fact.

        Raises LedgerError, and the error for which the writer's turn refuses the request.
        """
        await self.submit(*before, request)
        if request.error is not None:
            raise request.error
        return request

    async def commit(self, *writes: Write, use: KeyUse | None = None) -> None:
        """Return when `writes` are durable, or skipped because the `use` of their key is not new.

        Without writes, a test write is committed, which leaves no row.

        Raises LedgerError if they are refused, KeyReusedError if the key is that of another
        request.
        """
        await self.submit(*writes, use=use)
        if use is not None and use.error is not None:
            raise use.error

    async def look_up(self, use: KeyUse) -> UsedKey | None:
        """Set and return `use.earlier`, if the request is a repeat of one that is durable.

        Raises KeyReusedError, LedgerError.
        """
        if use.key is not None:
            found = await self.read(keys.used, key=use.key)
            use.earlier = None if found is None else found.check(use.key)
        return use.earlier

    async def keep(self, *writes: Write) -> None:
        """Return when `writes` are durable, however long that takes; raises LeaseLostError."""
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.defer(writes, _settle(future))
        await future

    async def decided(self, work: "Coroutine[None, None, T] | asyncio.Future[T]") -> T:
        """Await `work`, which continues even if the caller is cancelled.

        If the ledger fails meanwhile and has refused the writes of `work`, raises the refusal. If
        their outcome is still unknown, raises UndecidedError.
        """
        task = asyncio.ensure_future(work)
        waiter = CommitWaiter(task)
        self._waiters.add(waiter)
        try:
            if self.up:
                await waiter.woken
            else:  # the ledger has failed already, so only a refusal or a sent write can end this
                await asyncio.wait((waiter.woken,), timeout=self.patience)
        finally:
            self._waiters.discard(waiter)
            if not task.done():
                task.add_done_callback(log_failure)
        if task.done():
            return task.result()
        raise UndecidedError(
            "the ledger does not answer, so it is not known yet whether this was done; send the "
            "same request again, with the same key",
            retry_after=self.patience,
            outcome=task,
        )

    def defer(self, writes: Sequence[Write], done: Done | None = None) -> None:
        """Queue kept writes: they become durable, unless the process ends before.

        `done` is called when the last of them is durable, or with its LeaseLostError.
        """
        if not writes:
            return
        # One job for each room, so that a lost lease refuses only that room's writes.
        for lease, part in self.leases.stamp(writes):
            own = done if part[-1] is writes[-1] else None
            self._put(Job(part, done=own, leases=() if lease is None else (lease,), keep=True))

    async def read(
        self, read: Callable[Concatenate[Connection, P], T], *args: P.args, **values: P.kwargs
    ) -> T:
        """The result of `read`, which sees all earlier writes; raises LedgerError."""
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        task = asyncio.current_task()
        job = Job(
            read=lambda connection: read(connection, *args, **values),
            done=_settle(future),
            task=task,
        )
        self._put(job)
        await future
        result: T = job.result
        return result

    async def settled(self) -> None:
        """Return when all earlier writes are durable; raises LedgerError if the ledger fails."""
        if self._queue.writes:
            await self.commit()

    async def close(self) -> None:
        """Write all waiting jobs and close the database; gives up after ten seconds."""
        self._queue.close()
        await asyncio.to_thread(self._thread.join, _CLOSE_SECONDS)
        if self._thread.is_alive():
            _log.error("the ledger %s does not answer; stopping without it", self.database.name)

    def _put(self, job: Job) -> None:
        job.asked = self._clock()
        self._queue.put(job)
        if not job.keep and not self._watched:
            self._seen, self._silence = self._queue.progress, 0
            self._poll_later()

    # The time limit for the thread. Polls without progress are counted, not seconds: a process that
    # was stopped for a minute has polled once since, and must not conclude that the database is
    # slow.

    def _poll_later(self) -> None:
        assert self._loop is not None
        self._watched = True
        self._loop.call_later(self.patience / _POLLS, self._poll)

    def _poll(self) -> None:
        self._watched = False
        if not self._queue.awaited:
            return
        seen, self._seen = self._seen, self._queue.progress
        self._silence = self._silence + 1 if seen == self._seen else 0
        if self._silence < _POLLS:
            self._poll_later()
        else:
            self._give_up()

    def _give_up(self) -> None:
        """The thread hangs: refuse all open jobs, and new ones until it comes back."""
        failure = LedgerError(f"the ledger has not answered for {self.patience:g} seconds")
        _log.error("%s", failure)
        self._refused(self._queue.give_up(failure), failure)
        self.database.cut()

    # The committer's callbacks. They run on the event loop.

    def _call(self, function: Callable[..., None], *values: object) -> None:
        """Call a function on the event loop; for the committer's thread."""
        assert self._loop is not None
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(function, *values)

    def _committed(self, jobs: Sequence[Job], seconds: float) -> None:
        now = self._clock()
        self.commits += 1
        self._on_commit(seconds)
        for job in jobs:
            if not job.keep:
                self.lag = max(now - job.asked, _FORGET * self.lag)
        _report(jobs, None)

    def _refused(self, jobs: Sequence[Job], failure: LedgerError) -> None:
        """Report refusals, and wake all callers of `decided` whose writes were not refused."""
        self.failures += 1
        _report(jobs, failure)
        refused = {job.task for job in jobs}
        self._waiters = {each for each in self._waiters if each.task not in refused}
        if not self.up:
            for each in self._waiters:
                each.wake()

    def _lost(self, leases: Sequence[Lease], jobs: Sequence[Job], failure: LeaseLostError) -> None:
        """Drop the rooms before reporting refusals, so that their clients see no refused drop."""
        self.leases.lost(leases)
        _report(jobs, failure)

    def _recovered(self, failure: LedgerError) -> None:
        self._queue.open(failure)
        if self.up:
            _log.warning("the ledger %s accepts writes again", self.database.name)


def _report(jobs: Sequence[Job], failure: LedgerError | None) -> None:
    """Call each job's `done`. An error in one of them does not stop the others."""
    for job in jobs:
        if job.done is None:
            continue
        try:
            job.done(failure)
        except Exception:  # noqa: BLE001
            _log.exception("handling the outcome of %s failed", job.kinds)


def _settle(future: "asyncio.Future[None]") -> Done:
    """A `done` that settles a future, unless its owner has cancelled it."""

    def done(error: LedgerError | None) -> None:
        if future.done():
            return
        if error is None:
            future.set_result(None)
        else:
            future.set_exception(error)

    return done
