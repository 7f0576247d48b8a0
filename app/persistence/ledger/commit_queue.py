"""The jobs that wait for a commit, and the fate of each: decided once, in order. No I/O.

Two threads share the queue: the event loop puts jobs in and may lose its patience, the ledger's
thread takes them out and commits them. A job's fate is decided under the one lock:

- OPEN: the job waits, or its statements are being run. The loop may still refuse it, and a
  transaction with a refused job is rolled back.
- SENT: its COMMIT may reach the database. From here on only the database decides.
- DONE: the database has it. REFUSED: the database never will.

A failure refuses every open job at one stroke and shuts the gate: nothing is put in any more. The
gate opens after a later commit has succeeded and the owners of the refused jobs were told. So of
each line's jobs, which bear consecutive numbers, the database always has the first ones, and the
next job that is put in follows the last one that is durable. docs/ledger.md has the proof.
"""

import asyncio
import enum
import threading
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection

from app.errors import LedgerError
from app.rooms.records import Lease, Write

Done = Callable[[LedgerError | None], None]


class Fate(enum.Enum):
    """What has become of a job, see above."""

    OPEN = enum.auto()
    SENT = enum.auto()
    DONE = enum.auto()
    REFUSED = enum.auto()


@dataclass(slots=True, eq=False)
class Job:
    """Writes to commit together, or something to read.

    done: called on the event loop with the fate.
    leases: of the rooms that are written; where one of them is another server's, it is refused.
    line: the room run in which the writes are an input with a number; its jobs share a refusal.
    task: of whoever asked; None where nobody waits for it there.
    keep: never refused for a failure, but tried until the database has it.
    asked: when it was put in, s of a monotonic clock.
    number: how many were put in before it.
    """

    writes: Sequence[Write] = ()
    done: Done | None = None
    leases: tuple[Lease, ...] = ()
    line: int | None = None
    task: "asyncio.Task[object] | None" = None
    keep: bool = False
    read: Callable[[Connection], object] | None = None
    result: Any = None
    asked: float = 0.0
    fate: Fate = Fate.OPEN
    number: int = 0


class RevokedError(Exception):
    """Some of the jobs of a commit were refused before it was made: it must not be."""


class LostError(Exception):
    """Some rooms of a commit are another server's by now: it must not be made."""

    def __init__(self, leases: Sequence[Lease]) -> None:
        super().__init__(leases)
        self.leases = leases


class CommitQueue:
    """Jobs between the event loop and the ledger's thread; see above for what it promises."""

    def __init__(self) -> None:
        self.failure: LedgerError | None = LedgerError("the ledger is not open")
        self.silent = False  # the thread was given up on and has not come back yet
        self.progress = 0  # times that the thread has come back with something
        self.closing = False
        self._changed = threading.Condition()
        self._waiting: deque[Job] = deque()
        self._reads: deque[Job] = deque()
        self._taken: list[Job] = []  # in the thread's hands
        self._put_in = 0
        self._broken: dict[int, LedgerError] = {}  # lines of which not all is taken back

    # The event loop's side.

    def put(self, job: Job) -> None:
        """Have a job done; raises LedgerError where it would be refused."""
        with self._changed:
            if not job.keep:
                self._check(job)
            self._put_in += 1
            job.number = self._put_in
            (self._waiting if job.read is None else self._reads).append(job)
            self._changed.notify()

    @property
    def awaited(self) -> bool:
        """Whether there is a job that somebody waits for."""
        with self._changed:
            undecided = (Fate.OPEN, Fate.SENT)
            return any(not job.keep and job.fate in undecided for job in self._all())

    @property
    def writes(self) -> bool:
        """Whether there is something to write that is not durable yet."""
        with self._changed:
            return any(job.read is None for job in (*self._taken, *self._waiting))

    @property
    def empty(self) -> bool:
        with self._changed:
            return not (self._waiting or self._reads or self._taken or self.failure)

    def give_up(self, failure: LedgerError) -> list[Job]:
        """Shut the gate and refuse all that is open, as the thread does not come back.

        Returns the refused jobs. What was sent waits for the database's word.
        """
        with self._changed:
            self.silent = True
            return self._shut(failure, self._all())

    def open(self, failure: LedgerError | None = None) -> None:
        """Let jobs in, unless another failure than this one came after it."""
        with self._changed:
            if failure is None or self.failure is failure:
                self.failure = None

    def mend(self, line: int) -> None:
        """Let jobs of this line in: what was refused of it is taken back."""
        with self._changed:
            self._broken.pop(line, None)

    def close(self) -> None:
        """Let no jobs in any more; the thread does those that are here and ends."""
        with self._changed:
            self.closing = True
            self._changed.notify()

    # The thread's side.

    def take(self, pause: Callable[[], float]) -> list[Job] | None:
        """The next work: all writes that wait, else one read; None at the end. Blocks.

        pause: seconds until a commit may start. Reads never keep writes waiting for more than one,
        and see all that was put in before them, unless writes fail. While the gate is shut there
        is always something to commit, be it nothing: a probe.
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
        """Whether writes that were put in before a read will be made soon."""
        if self.failure is not None or not self._waiting:
            return False
        return self._waiting[0].number < read.number

    def send(self, jobs: Sequence[Job]) -> None:
        """The last word before a COMMIT; raises RevokedError when it must not be sent."""
        with self._changed:
            if any(job.fate is Fate.REFUSED for job in jobs):
                raise RevokedError
            for job in jobs:
                job.fate = Fate.SENT

    def done(self, jobs: Sequence[Job]) -> LedgerError | None:
        """These are durable, or read; returns the failure that writes have thereby outlived.

        A read may have been refused meanwhile; a write that was sent was not.
        """
        with self._changed:
            self._back(jobs)
            for job in jobs:
                if job.fate is not Fate.REFUSED:
                    job.fate = Fate.DONE
            wrote = all(job.read is None for job in jobs)
            return self.failure if wrote else None

    def revoked(self) -> None:
        """The commit was not made, as some of its jobs were refused: the others wait again."""
        with self._changed:
            self._return(self._back())

    def failed(self, failure: LedgerError) -> list[Job]:
        """The database does not have what was taken, nor takes the rest: refuse all.

        Returns the refused jobs.
        """
        with self._changed:
            taken = self._back()
            for job in taken:
                job.fate = Fate.REFUSED if job.fate is Fate.REFUSED else Fate.OPEN
            refused = self._shut(failure, [*taken, *self._waiting])
            self._return(taken)
            return refused

    def doubted(self, failure: LedgerError) -> list[Job]:
        """Nobody can say yet what became of the commit: refuse what waits; returns it."""
        with self._changed:
            return self._shut(failure, self._waiting)

    def rejected(self, job: Job, failure: LedgerError) -> list[Job]:
        """The database will never take this job: refuse it and those that number on from it."""
        with self._changed:
            self._back([job])
            if job.keep or job.line is None:
                return _refuse([job])
            self._broken[job.line] = failure
            later = (each for each in (*self._taken, *self._waiting) if each.line == job.line)
            refused = _refuse([job, *later])
            self._taken = [each for each in self._taken if each.fate is Fate.OPEN]
            self._waiting = deque(each for each in self._waiting if each.fate is Fate.OPEN)
            return refused

    def lost(self, leases: Sequence[Lease]) -> list[Job]:
        """The commit was not made, as these rooms are another server's: refuse all that is theirs.

        What is kept for a failure too; returns it. The other jobs of the commit wait again.
        """
        with self._changed:
            gone, taken = set(leases), self._back()
            refused = _refuse(j for j in (*taken, *self._waiting) if not gone.isdisjoint(j.leases))
            self._waiting = deque(job for job in self._waiting if job.fate is Fate.OPEN)
            self._return(taken)
            return refused

    def abandon(self) -> int:
        """Forget what waits, as the server stops and cannot write; returns how many jobs."""
        with self._changed:
            lost = len(self._waiting)
            self._waiting.clear()
            return lost

    # Under the lock.

    def _all(self) -> Iterable[Job]:
        return (*self._taken, *self._waiting, *self._reads)

    def _check(self, job: Job) -> None:
        if self.closing:
            raise LedgerError("the server is stopping")
        # While writes fail, what is there can still be read, unless the thread is away.
        if self.failure is not None and (job.read is None or self.silent):
            raise LedgerError(str(self.failure))
        if job.line in self._broken:
            raise LedgerError(str(self._broken[job.line]))

    def _back(self, jobs: Sequence[Job] | None = None) -> list[Job]:
        """The thread has come back with these, or with all it had taken."""
        self.progress += 1
        self.silent = False
        back = self._taken if jobs is None else list(jobs)
        self._taken = [job for job in self._taken if job not in back]
        return back

    def _return(self, jobs: Sequence[Job]) -> None:
        """What is open waits again, before what came later."""
        self._waiting.extendleft(job for job in reversed(jobs) if job.fate is Fate.OPEN)

    def _shut(self, failure: LedgerError, jobs: Iterable[Job]) -> list[Job]:
        """Let nothing in, and refuse the open ones of `jobs`; returns those."""
        refused = _refuse(job for job in jobs if not job.keep)
        self._waiting = deque(job for job in self._waiting if job.fate is Fate.OPEN)
        self._reads = deque(job for job in self._reads if job.fate is Fate.OPEN)
        self.failure = failure
        self._changed.notify()
        return refused


def _refuse(jobs: Iterable[Job]) -> list[Job]:
    """Refuse those whose fate is open; returns them."""
    refused = [job for job in jobs if job.fate is Fate.OPEN]
    for job in refused:
        job.fate = Fate.REFUSED
    return refused
