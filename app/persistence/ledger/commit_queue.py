"""The queue of jobs that wait for a commit. It decides the fate of each, once, in order. No I/O.

Two threads share the queue. The event loop puts jobs in, and refuses them if the ledger's thread
takes too long. The ledger's thread takes them out and commits them. A job's fate changes only under
the queue's lock:

- OPEN: the job waits, or its statements are running. The event loop may still refuse it; then the
  transaction is rolled back.
- SENT: its COMMIT may reach the database. From here on only the database decides.
- DONE: the job is durable. REFUSED: it never will be.

Inputs get their numbers in the transaction that commits them, so a refused input never had one, and
the order in which jobs are refused does not matter. A failure refuses all open jobs in one step and
shuts the gate: the queue accepts no new job until a later commit has succeeded. Nothing else is
written before the fate of SENT jobs is decided.

If the database works but rejects a single job, only that job is refused.
"""

import asyncio
import enum
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection

from plinko.app.errors import LedgerError
from plinko.app.rooms.keys import KeyUse
from plinko.app.rooms.records import Lease, Write

Done = Callable[[LedgerError | None], None]


class Fate(enum.Enum):
    """The state of a job, see above."""

    OPEN = enum.auto()
    SENT = enum.auto()
    DONE = enum.auto()
    REFUSED = enum.auto()


@dataclass(slots=True, eq=False)
class Job:
    """Writes to commit in one transaction, or a read.

    done: called on the event loop with None, or with the error that refused the job.
    leases: those of the rooms that are written; the job is refused if this server has lost one.
    task: the caller's task; None if no task waits.
    use: of the request's idempotency key; unless it is new, the writes are skipped.
    keep: retried through all failures; refused only if the database rejects it or a lease is lost.
    asked: when it was put in, in s of a monotonic clock.
    number: its place in the order in which jobs were put in, from 1.
    """

    writes: Sequence[Write] = ()
    done: Done | None = None
    leases: tuple[Lease, ...] = ()
    task: "asyncio.Task[object] | None" = None
    use: KeyUse | None = None
    keep: bool = False
    read: Callable[[Connection], object] | None = None
    result: Any = None
    asked: float = 0.0
    fate: Fate = Fate.OPEN
    number: int = 0

    @property
    def kinds(self) -> str:
        """What is written, for the log: the kinds of rows; their values may be secret."""
        counts = Counter(type(write).__name__ for write in self.writes)
        return ", ".join(f"{count} {kind}" for kind, count in counts.items())


class RevokedError(Exception):
    """A job of the transaction was refused before its COMMIT, so it must be rolled back."""


class LostError(Exception):
    """Another server has taken a room of the transaction, so it must be rolled back."""

    def __init__(self, leases: Sequence[Lease]) -> None:
        super().__init__(leases)
        self.leases = leases


class CommitQueue:
    """Jobs between the event loop and the ledger's thread; see above for its guarantees."""

    def __init__(self) -> None:
        self.failure: LedgerError | None = LedgerError("the ledger is not open")
        self.silent = False  # the thread took too long and has not come back yet
        self.progress = 0  # how many times the thread has come back with a result
        self.closing = False
        self._changed = threading.Condition()
        self._waiting: deque[Job] = deque()
        self._reads: deque[Job] = deque()
        self._taken: list[Job] = []  # jobs that the thread is working on
        self._put_in = 0

    # The event loop's side.

    def put(self, job: Job) -> None:
        """Add a job; raises LedgerError if the gate is shut."""
        with self._changed:
            if not job.keep:
                self._check(job)
            self._put_in += 1
            job.number = self._put_in
            (self._waiting if job.read is None else self._reads).append(job)
            self._changed.notify()

    @property
    def awaited(self) -> bool:
        """Whether a caller waits for a job."""
        with self._changed:
            undecided = (Fate.OPEN, Fate.SENT)
            return any(not job.keep and job.fate in undecided for job in self._all())

    @property
    def writes(self) -> bool:
        """Whether the queue has writes that are not durable yet."""
        with self._changed:
            return any(job.read is None for job in (*self._taken, *self._waiting))

    def give_up(self, failure: LedgerError) -> list[Job]:
        """Shut the gate and refuse all open jobs, because the thread does not come back.

        Returns the refused jobs. Sent jobs wait for the database's decision.
        """
        with self._changed:
            self.silent = True
            return self._shut(failure, self._all())

    def open(self, failure: LedgerError | None = None) -> None:
        """Open the gate, unless a newer failure than this one has shut it."""
        with self._changed:
            if failure is None or self.failure is failure:
                self.failure = None

    def close(self) -> None:
        """Accept no more jobs; the thread does those that are here, and ends."""
        with self._changed:
            self.closing = True
            self._changed.notify()

    # The thread's side.

    def take(self, pause: Callable[[], float]) -> list[Job] | None:
        """Wait for the next work: all waiting writes, or one read. None: the queue is closed.

        pause: returns the seconds until a commit may start. Writes wait for at most one read, and a
        read sees all writes that were put in before it, unless writes fail. While the gate is shut,
        the result may be an empty list, for a commit of a probe.
        """
        with self._changed:
            while True:
                seconds = 0.0 if self.closing else pause()
                wanted = bool(self._waiting) or (self.failure is not None and not self.closing)
                if wanted and seconds <= 0.0:
                    self._taken = list(self._waiting)
                    self._waiting.clear()
                elif self._reads and not self._writes_precede(self._reads[0]):
                    self._taken = [self._reads.popleft()]
                elif self.closing:
                    return None
                else:
                    self._changed.wait(seconds if wanted else None)
                    continue
                return list(self._taken)

    def _writes_precede(self, read: Job) -> bool:
        """Whether writes that were put in before this read will be committed first."""
        if self.failure is not None or not self._waiting:
            return False
        return self._waiting[0].number < read.number

    def send(self, jobs: Sequence[Job]) -> None:
        """Mark the jobs as sent, just before COMMIT; raises RevokedError if one was refused."""
        with self._changed:
            if any(job.fate is Fate.REFUSED for job in jobs):
                raise RevokedError
            for job in jobs:
                job.fate = Fate.SENT

    def done(self, jobs: Sequence[Job]) -> LedgerError | None:
        """Mark jobs as durable, or read.

        Returns the failure that ends with this successful commit, if any. A read may have been
        refused meanwhile; a sent write cannot have been.
        """
        with self._changed:
            self._back(jobs)
            for job in jobs:
                if job.fate is not Fate.REFUSED:
                    job.fate = Fate.DONE
            wrote = all(job.read is None for job in jobs)
            return self.failure if wrote else None

    def revoked(self) -> None:
        """Put the jobs of a rolled-back commit that are still open back into the queue."""
        with self._changed:
            self._return(self._back())

    def failed(self, failure: LedgerError) -> list[Job]:
        """Refuse all jobs, as the commit failed without effect; returns the refused jobs.

        Kept jobs of the commit wait again.
        """
        with self._changed:
            taken = self._back()
            for job in taken:
                job.fate = Fate.REFUSED if job.fate is Fate.REFUSED else Fate.OPEN
            refused = self._shut(failure, [*taken, *self._waiting])
            self._return(taken)
            return refused

    def doubted(self, failure: LedgerError) -> list[Job]:
        """Refuse the waiting jobs, as the outcome of a commit is unknown; returns them."""
        with self._changed:
            return self._shut(failure, self._waiting)

    def rejected(self, job: Job) -> list[Job]:
        """Refuse a job that the database rejects."""
        with self._changed:
            return _refuse(self._back([job]))

    def lost(self, leases: Sequence[Lease]) -> list[Job]:
        """Refuse all jobs of rooms that another server has taken, and return them.

        Kept jobs of these rooms are refused too. The other jobs of the commit wait again.
        """
        with self._changed:
            gone, taken = set(leases), self._back()
            refused = _refuse(j for j in (*taken, *self._waiting) if not gone.isdisjoint(j.leases))
            self._waiting = deque(job for job in self._waiting if job.fate is Fate.OPEN)
            self._return(taken)
            return refused

    def abandon(self) -> int:
        """Drop the waiting jobs of a server that stops and cannot write; returns their number."""
        with self._changed:
            lost = len(self._waiting)
            self._waiting.clear()
            return lost

    # The lock must be held.

    def _all(self) -> Iterable[Job]:
        return (*self._taken, *self._waiting, *self._reads)

    def _check(self, job: Job) -> None:
        if self.closing:
            raise LedgerError("the server is stopping")
        # While writes fail, reads may still work, unless the thread does not come back.
        if self.failure is not None and (job.read is None or self.silent):
            raise LedgerError(str(self.failure))

    def _back(self, jobs: Sequence[Job] | None = None) -> list[Job]:
        """Note that the thread has come back with these jobs, or with all that it had taken."""
        self.progress += 1
        self.silent = False
        back = self._taken if jobs is None else list(jobs)
        self._taken = [job for job in self._taken if job not in back]
        return back

    def _return(self, jobs: Sequence[Job]) -> None:
        """Put open jobs back at the head of the queue, in their order."""
        self._waiting.extendleft(job for job in reversed(jobs) if job.fate is Fate.OPEN)

    def _shut(self, failure: LedgerError, jobs: Iterable[Job]) -> list[Job]:
        """Shut the gate, and refuse and return the open ones of `jobs` that are not kept."""
        refused = _refuse(job for job in jobs if not job.keep)
        self._waiting = deque(job for job in self._waiting if job.fate is Fate.OPEN)
        self._reads = deque(job for job in self._reads if job.fate is Fate.OPEN)
        self.failure = failure
        self._changed.notify()
        return refused


def _refuse(jobs: Iterable[Job]) -> list[Job]:
    refused = [job for job in jobs if job.fate is Fate.OPEN]
    for job in refused:
        job.fate = Fate.REFUSED
    return refused
