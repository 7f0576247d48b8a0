"""The ledger as the event loop sees it: writes handed to one thread, one commit for all that waits.

What is submitted is either durable or refused when its caller hears of it. When a commit fails or
does not come back, all that waits is refused at once, later submissions too, and the thread tries
by itself until the database takes writes again. What a refused submission may have left behind, as
nobody knows what became of a commit that was cut off, is taken out before anything else is written.
Deferred writes (results, how far rooms have come) wait for as long as that takes; they follow from
what is in the ledger, so a crash in between loses nothing.
"""

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import sqlalchemy as sa
from sqlalchemy import Connection

from app.errors import DamagedRoomError, LedgerError
from app.persistence import store
from app.persistence.database import Database, reason
from app.rooms.records import Write

T = TypeVar("T")
Done = Callable[[LedgerError | None], None]

_RETRY = (0.25, 2.0)  # s between attempts while the database is lost: at first, and at most
_FORGET = 0.9  # what a commit leaves of the longest latency before it

_log = logging.getLogger("plinko")

_FAILURES = (sa.exc.SQLAlchemyError, OSError, LedgerError)


class _Job:
    """Writes to commit together, or something to read."""

    __slots__ = ("asked", "done", "given_up", "keep", "read", "result", "timer", "undo", "writes")

    def __init__(
        self,
        writes: Sequence[Write] = (),
        *,
        undo: Sequence[Write] = (),
        done: Done | None = None,
        keep: bool = False,
        read: Callable[[Connection], Any] | None = None,
    ) -> None:
        self.writes = writes
        self.undo = undo
        self.done = done
        self.keep = keep
        self.read = read
        self.result: Any = None
        self.asked = 0.0
        self.given_up = False
        self.timer: asyncio.TimerHandle | None = None


class Ledger:
    """All methods but `open` are for the event loop's thread; none of them blocks it.

    At most one commit starts in each `period` seconds, so drops of one tick share one. A commit
    that takes longer than `patience` seconds counts as failed.
    """

    keeps = True

    def __init__(self, database: Database, *, period: float, patience: float) -> None:
        self.database = database
        self.period = period
        self.patience = patience
        self.commits = 0
        self.failures = 0
        self.lag = 0.0  # s from submission to durability, the longest of late
        self.on_commit: Callable[[float], None] = lambda seconds: None
        self._problem: str | None = "the ledger is not open"
        self._stuck = False
        self._jobs: deque[_Job] = deque()
        self._changed = threading.Condition()
        self._closing = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = threading.Thread(target=self._run, name="ledger", daemon=True)

    def open(self) -> None:
        """Open the database unless it is; blocks. Raises SettingError when it cannot be used."""
        if not self.database.is_open:
            self.database.open()

    def start(self) -> None:
        """Begin to take writes, in the running event loop."""
        self._loop = asyncio.get_running_loop()
        self._problem = None
        self._thread.start()

    @property
    def problem(self) -> str | None:
        """Why nothing can be written now; None while all is well."""
        if self._stuck:
            return f"the ledger has not answered for {self.patience:g} seconds"
        return self._problem

    @property
    def up(self) -> bool:
        """Whether writes are taken."""
        return self.problem is None

    def submit(self, writes: Sequence[Write], done: Done, *, undo: Sequence[Write] = ()) -> None:
        """Have `writes` made durable in one transaction, then call `done(None)`, or with why not.

        `undo` takes them out again should it remain open whether they were committed. Raises
        LedgerError when the ledger cannot be written now; `done` is then not called.
        """
        self._check()
        self._put(_Job(writes, undo=undo, done=done))

    async def commit(self, *writes: Write, undo: Sequence[Write] = ()) -> None:
        """Return once `writes` are durable; raises LedgerError when they will not be."""
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.submit(writes, _settle(future), undo=undo)
        await future

    def defer(self, writes: Sequence[Write], done: Done | None = None) -> None:
        """Have `writes` made durable some time; they outlast every failure but the process's.

        `done` is called unless the ledger failed in between.
        """
        if writes:
            self._put(_Job(writes, done=done, keep=True), patient=True)

    async def read(self, read: Callable[[Connection], T]) -> T:
        """What `read` finds after all that was submitted before; raises LedgerError."""
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        if self._stuck or self._closing:
            raise LedgerError(self.problem or "the server is stopping")
        job = _Job(read=read, done=_settle(future))
        self._put(job)
        await future
        result: T = job.result
        return result

    async def probe(self) -> None:
        """Write something and take it out again; raises LedgerError when that fails."""
        await self.commit()

    async def close(self) -> None:
        """Write what waits, then let go of the database."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        await asyncio.to_thread(self._thread.join)

    def _check(self) -> None:
        if self._closing:
            raise LedgerError("the server is stopping")
        if self.problem is not None:
            raise LedgerError(self.problem)

    def _put(self, job: _Job, *, patient: bool = False) -> None:
        assert self._loop is not None
        job.asked = time.monotonic()
        if not patient:
            job.timer = self._loop.call_later(self.patience, self._give_up, job)
        with self._changed:
            self._jobs.append(job)
            self._changed.notify()

    def _give_up(self, job: _Job) -> None:
        """The thread hangs: refuse what waits, and all else until it is back."""
        job.given_up = True
        self._stuck = True
        self.failures += 1
        if job.done is not None:
            job.done(LedgerError(str(self.problem)))

    def _finish(self, jobs: Sequence[_Job], error: LedgerError | None, began: float) -> None:
        """On the event loop: the thread is through with these jobs, one way or the other."""
        now = time.monotonic()
        self._stuck = False
        if error is None:
            self.commits += 1
            self.on_commit(now - began)
        else:
            self.failures += 1
        for job in jobs:
            if job.timer is not None:
                job.timer.cancel()
            if job.given_up:
                if error is None and job.undo:
                    self.defer(job.undo)
            elif job.done is not None:
                self.lag = max(now - job.asked, _FORGET * self.lag)
                job.done(error)

    def _recovered(self) -> None:
        _log.warning("the ledger %s takes writes again", self.database.name)
        self._problem = None

    # The rest is the thread's.

    def _run(self) -> None:
        started = 0.0
        while self._wait_for_work():
            pause = started + self.period - time.monotonic()
            if pause > 0.0:
                time.sleep(pause)
            started = time.monotonic()
            with self._changed:
                jobs = list(self._jobs)
                self._jobs.clear()
            self._work([job for job in jobs if not job.given_up])
        self.database.close()

    def _wait_for_work(self) -> bool:
        with self._changed:
            while not self._jobs and not self._closing:
                self._changed.wait()
            return bool(self._jobs)

    def _work(self, jobs: list[_Job]) -> None:
        """Commit all writes, then read what is asked for."""
        writing = [job for job in jobs if job.read is None]
        if writing:
            self._write(writing)
        for job in jobs:
            if job.read is not None:
                self._read(job)

    def _write(self, jobs: list[_Job]) -> None:
        began = time.monotonic()
        try:
            self._commit(jobs)
        except (sa.exc.IntegrityError, sa.exc.DataError) as error:
            if len(jobs) == 1:
                # The database is well; it is this one that it will never take.
                _log.error("the ledger refuses %r: %s", jobs[0].writes, reason(error))
                self._tell(jobs, LedgerError(f"the ledger refuses it: {reason(error)}"), began)
                return
            for job in jobs:
                self._write([job])
        except _FAILURES as error:
            self._suffer(jobs, error, began)
        else:
            self._tell(jobs, None, began)

    def _commit(self, jobs: Sequence[_Job]) -> None:
        with self.database.transaction() as connection:
            writes = [write for job in jobs for write in job.writes]
            if not writes:
                store.probe(connection)
            store.apply(connection, writes)

    def _read(self, job: _Job) -> None:
        assert job.read is not None
        began = time.monotonic()
        try:
            with self.database.transaction() as connection:
                job.result = job.read(connection)
        except DamagedRoomError as error:
            self._tell([job], error, began)  # the database is well, and so are other rooms
        except (*_FAILURES, ValueError) as error:
            self._tell([job], LedgerError(f"the ledger cannot be read: {reason(error)}"), began)
        else:
            self._tell([job], None, began)

    def _suffer(self, jobs: list[_Job], error: BaseException, began: float) -> None:
        """Refuse all that waits, and try until the database takes writes again."""
        failure = LedgerError(f"the ledger cannot be written: {reason(error)}")
        _log.error("%s", failure)
        self._problem = str(failure)
        kept: list[_Job] = []
        self._refuse(jobs, failure, kept, began)
        delay = _RETRY[0]
        retry_at = began + delay
        while not self._closing:
            with self._changed:
                pause = max(0.0, retry_at - time.monotonic())
                self._changed.wait_for(lambda: bool(self._closing or self._jobs), pause)
                jobs = list(self._jobs)
                self._jobs.clear()
            # Submitted before the loop heard of the failure.
            self._refuse(jobs, failure, kept, began)
            for job in jobs:
                if job.read is not None and not job.given_up:
                    self._read(job)
            if time.monotonic() < retry_at:
                continue
            try:
                self._commit([])
                self._commit_kept(kept)
            except _FAILURES as again:
                self._problem = f"the ledger cannot be written: {reason(again)}"
                delay = min(2.0 * delay, _RETRY[1])
                retry_at = time.monotonic() + delay
            else:
                self._call(self._recovered)
                return

    def _commit_kept(self, kept: Sequence[_Job]) -> None:
        """Commit what outlasted the failure; what the database will never take is left out."""
        try:
            self._commit(kept)
        except (sa.exc.IntegrityError, sa.exc.DataError) as error:
            if len(kept) > 1:
                for job in kept:
                    self._commit_kept([job])
            else:
                _log.error("the ledger refuses %r: %s", kept[0].writes, reason(error))

    def _refuse(
        self, jobs: Sequence[_Job], failure: LedgerError, kept: list[_Job], began: float
    ) -> None:
        """Tell those who wait for a commit, and see to it that nothing of theirs remains."""
        kept += [job for job in jobs if job.keep]
        refused = [job for job in jobs if not job.keep and job.read is None]
        kept += [_Job(job.undo, keep=True) for job in refused if job.undo]
        if refused:
            self._tell(refused, failure, began)

    def _tell(self, jobs: Sequence[_Job], error: LedgerError | None, began: float) -> None:
        self._call(self._finish, jobs, error, began)

    def _call(self, function: Callable[..., None], *values: Any) -> None:
        assert self._loop is not None
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(function, *values)


def _settle(future: "asyncio.Future[None]") -> Done:
    """A `done` that settles a future whose owner may have gone away."""

    def done(error: LedgerError | None) -> None:
        if future.done():
            return
        if error is None:
            future.set_result(None)
        else:
            future.set_exception(error)

    return done
