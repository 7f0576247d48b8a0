"""The ledger as the event loop sees it: writes handed to one thread, one commit for all that waits.

What the database has committed stays, and the caller hears which: a job is durable or refused when
its caller is told. `commit_queue` decides which, at one stroke for all that hangs together. When a
commit fails or does not come back, what was not sent is refused, later submissions too, and the
thread tries by itself until the database takes writes again. What was sent waits for the database's
word; whoever waits for that outside hears UndecidedError meanwhile (`decided`). Kept writes
(results, how far rooms have come, ends of runs) are tried until they are there.
"""

import asyncio
import logging
import threading
import time
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, Concatenate, Final, ParamSpec, Protocol, TypeVar

from sqlalchemy import Connection

from app.concurrency.to_the_end import log_failure
from app.errors import LeaseLostError, LedgerError, UndecidedError
from app.persistence.lease_book import LeaseBook, Unshared
from app.persistence.ledger.commit_queue import CommitQueue, Done, Job
from app.persistence.ledger.committer import Answers, Committer
from app.persistence.ledger.database import Database
from app.rooms.records import Lease, Write

T = TypeVar("T")
P = ParamSpec("P")

_FORGET: Final = 0.9  # what a commit leaves of the longest latency before it
COMMIT_PATIENCE: Final = 2.0  # s that a commit may take before drops get 503

_LOOKS: Final = 4  # at the thread within one patience; a process that was stopped counts as one
_FAREWELL: Final = 10.0  # s to write what waits at the end; the next start computes it again

_UNSHARED: Final = Unshared()

_log = logging.getLogger("plinko")


class _Waiter:
    """Somebody waits for what a task comes to, or for the ledger to fail first."""

    def __init__(self, doing: "asyncio.Future[Any]") -> None:
        self.doing = doing
        self.told: asyncio.Future[None] = doing.get_loop().create_future()
        doing.add_done_callback(self.tell)

    def tell(self, _: object = None) -> None:
        """It has come to an end, or the ledger has failed."""
        if not self.told.done():
            self.told.set_result(None)


class Loop(Protocol):
    """What the ledger needs of an event loop."""

    def call_soon_threadsafe(self, callback: Callable[..., object], *args: object) -> object:
        """Call back in the loop's thread, in the order of these calls."""

    def call_later(self, delay: float, callback: Callable[[], None]) -> object:
        """Call back so many seconds later."""

    def is_closed(self) -> bool:
        """Whether nothing will be called back any more."""


class Ledger:
    """All methods but `open` are for the event loop's thread; none of them blocks it.

    At most one commit starts in each `period` seconds of `clock`, so drops of one tick share one.
    When the thread comes back with nothing for `patience` seconds, all that waits is refused.
    `on_commit` hears how long each commit took, in s. `leases` says under which leases writes are
    made, and hears of those that are lost before the callers whose writes are refused for it.
    `targets` are the addresses that webhooks tell of drops and results.
    """

    keeps = True

    def __init__(
        self,
        database: Database,
        *,
        period: float,
        patience: float,
        clock: Callable[[], float] = time.monotonic,
        on_commit: Callable[[float], None] = lambda seconds: None,
        leases: LeaseBook | Unshared = _UNSHARED,
        targets: Sequence[str] = (),
    ) -> None:
        self.database = database
        self.patience = patience
        self.commits = 0
        self.failures = 0
        self.lag = 0.0  # s from submission to durability, the longest of late
        self._on_commit = on_commit
        self._leases = leases
        self._clock = clock
        self._queue = CommitQueue()
        self._watched = False
        self._seen = 0  # progress at the last look
        self._silence = 0  # looks since then
        self._loop: Loop | None = None
        self._waiters: set[_Waiter] = set()
        answers = Answers(
            call=self._call,
            committed=self._committed,
            refused=self._refused,
            read=_tell,
            mended=self._mended,
            lost=self._lost,
        )
        self.committer = Committer(
            database, self._queue, answers, period=period, clock=clock, targets=targets
        )
        self._thread = threading.Thread(target=self.committer.run, name="ledger", daemon=True)

    def open(self) -> None:
        """Open the database unless it is; blocks. Raises SettingError when it cannot be used."""
        if not self.database.is_open:
            self.database.open()

    def start(self) -> None:
        """Begin to take writes, in the running event loop."""
        self.attach(asyncio.get_running_loop())
        self._thread.start()

    def attach(self, loop: Loop) -> None:
        """Begin to take writes, for whoever gives `committer` its turns."""
        self._loop = loop
        self._queue.open()

    @property
    def problem(self) -> str | None:
        """Why nothing can be written now; None while all is well."""
        failure = self._queue.failure
        return None if failure is None else str(failure)

    @property
    def up(self) -> bool:
        return self._queue.failure is None

    @property
    def idle(self) -> bool:
        """Whether nothing waits for the committer."""
        return self._queue.empty

    def submit(self, *writes: Write, line: int | None = None) -> "asyncio.Future[None]":
        """Have `writes` made durable in one transaction; the future says when, or why they are not.

        Of what is submitted for the same `line`, a room run's number, a refusal takes all that is
        not durable yet, and the latest hears of it first; then `mend` lets more in. Raises
        LedgerError when the ledger cannot be written now.
        """
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        leases = [lease for lease, _ in self._leases.stamp(writes) if lease is not None]
        task = asyncio.current_task()
        self._put(Job(writes, _settle(future), tuple(leases), line, task=task))
        return future

    def mend(self, line: int) -> None:
        """Take writes of a line again: what was refused of it is taken back."""
        self._queue.mend(line)

    async def commit(self, *writes: Write) -> None:
        """Return once `writes` are durable; raises LedgerError when they never will be."""
        await self.submit(*writes)

    async def keep(self, *writes: Write) -> None:
        """Return once `writes` are durable, however long that takes; raises LeaseLostError."""
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.defer(writes, _settle(future))
        await future

    async def decided(self, work: "Coroutine[None, None, T] | asyncio.Future[T]") -> T:
        """What comes of `work`, which goes on whoever waits for it.

        Raises UndecidedError when the ledger fails while it is under way, unless what it wrote is
        refused: then it raises that.
        """
        doing = asyncio.ensure_future(work)
        waits = _Waiter(doing)
        self._waiters.add(waits)
        try:
            if self.up:
                await waits.told
            else:  # what can be refused is refused at once
                await asyncio.wait((waits.told,), timeout=self.patience)
        finally:
            self._waiters.discard(waits)
            if not doing.done():
                doing.add_done_callback(log_failure)
        if doing.done():
            return doing.result()
        raise UndecidedError(
            "the ledger does not answer, and it is not known yet whether this was done; it is not "
            "lost: ask again with the same key",
            retry_after=self.patience,
            outcome=doing,
        )

    def defer(self, writes: Sequence[Write], done: Done | None = None) -> None:
        """Have `writes` made durable some time; they outlast every failure but the process's."""
        if not writes:
            return
        # One room's loss takes nothing from the others.
        for lease, part in self._leases.stamp(writes):
            own = done if part[-1] is writes[-1] else None
            self._put(Job(part, done=own, leases=() if lease is None else (lease,), keep=True))

    async def read(
        self, read: Callable[Concatenate[Connection, P], T], *args: P.args, **values: P.kwargs
    ) -> T:
        """What `read` finds after all that was submitted before; raises LedgerError."""
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        task = asyncio.current_task()
        job = Job(read=lambda line: read(line, *args, **values), done=_settle(future), task=task)
        self._put(job)
        await future
        result: T = job.result
        return result

    async def settled(self) -> None:
        """Return once all that was submitted is durable; raises LedgerError where it cannot be."""
        if self._queue.writes:
            await self.commit()

    async def probe(self) -> None:
        """Write something and take it out again; raises LedgerError when that fails."""
        await self.commit()

    async def close(self) -> None:
        """Write what waits, then let go of the database; one that hangs is left as it is."""
        self._queue.close()
        await asyncio.to_thread(self._thread.join, _FAREWELL)
        if self._thread.is_alive():
            _log.error("the ledger %s does not come back; the server ends", self.database.name)

    def _put(self, job: Job) -> None:
        job.asked = self._clock()
        self._queue.put(job)
        if not job.keep and not self._watched:
            self._seen, self._silence = self._queue.progress, 0
            self._look_later()

    # How long the thread may be away. Only looks are counted: a process that was stopped and goes
    # on has looked once, and cannot say that the database was slow.

    def _look_later(self) -> None:
        assert self._loop is not None
        self._watched = True
        self._loop.call_later(self.patience / _LOOKS, self._look)

    def _look(self) -> None:
        self._watched = False
        if not self._queue.awaited:
            return
        seen, self._seen = self._seen, self._queue.progress
        self._silence = self._silence + 1 if seen == self._seen else 0
        if self._silence < _LOOKS:
            self._look_later()
        else:
            self._give_up()

    def _give_up(self) -> None:
        """The thread hangs: refuse what waits, and all else until it is back."""
        failure = LedgerError(f"the ledger has not answered for {self.patience:g} seconds")
        _log.error("%s", failure)
        self._refused(self._queue.give_up(failure), failure)
        self.database.cut()

    # What the committer says, on the event loop.

    def _call(self, function: Callable[..., None], *values: object) -> None:
        """From the committer's thread."""
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
        _tell(jobs, None)

    def _refused(self, jobs: Sequence[Job], failure: LedgerError) -> None:
        """Tell the owners, the latest first: numbers are given back as they were given."""
        self.failures += 1
        _tell(jobs[::-1], failure)
        refused = {job.task for job in jobs}
        self._waiters = {each for each in self._waiters if each.doing not in refused}
        if not self.up:
            for each in self._waiters:
                each.tell()

    def _lost(self, leases: Sequence[Lease], jobs: Sequence[Job], failure: LeaseLostError) -> None:
        """The rooms go before anybody hears of a refusal: whoever watched them hears of nothing."""
        self._leases.lost(leases)
        _tell(jobs[::-1], failure)

    def _mended(self, failure: LedgerError) -> None:
        self._queue.open(failure)
        if self.up:
            _log.warning("the ledger %s takes writes again", self.database.name)


def _tell(jobs: Sequence[Job], failure: LedgerError | None) -> None:
    """Let the owners hear; what one of them makes of it keeps nothing from the others."""
    for job in jobs:
        if job.done is None:
            continue
        try:
            job.done(failure)
        except Exception:  # noqa: BLE001
            _log.exception("the owner of %r failed", job.writes)


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
