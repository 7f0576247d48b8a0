"""What waits for a commit and what becomes of it: decided once, at one stroke, in order. No I/O.

Two threads share it: the event loop puts jobs in and may lose its patience, the ledger's thread
takes them out and commits them. Whoever decides a job's fate does so under the one lock, and for
all that must share it:

- OPEN becomes DONE when the thread comes back from a commit, for the jobs of that commit;
- OPEN becomes REFUSED for every job at once when a commit failed or the loop waited too long, and
  for a job that the database will never take with all later ones of its line.

A refusal shuts the gate at the same stroke: nothing is put in any more. It opens when what may
remain of the refused jobs was taken out of the database, and after their owners were told. So of
each line's jobs, which bear consecutive numbers, the database always has the first ones, and the
next that is put in follows the last one that is durable. docs/operations.md has the proof.
"""

import enum
import threading
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection

from app.errors import LedgerError
from app.rooms.records import Hold, IfHeld, Write

Done = Callable[[LedgerError | None], None]


class Fate(enum.Enum):
    """What has become of a job."""

    OPEN = enum.auto()
    DONE = enum.auto()
    REFUSED = enum.auto()


@dataclass(slots=True, eq=False)
class Job:
    """Writes to commit together, or something to read.

    undo: takes the writes out again; it must do nothing where they were never made.
    done: called on the event loop with the fate.
    holds: of the rooms that are written; where one of them is another server's, it is refused.
    line: the session in which the writes are an input with a number; its jobs share a refusal.
    keep: never refused for a failure; its writes follow from what is in the database already.
    asked: when it was put in, s of a monotonic clock.
    mends: the failure whose remains this job takes out.
    number: how many were put in before it; what was never put in by a caller comes before all.
    """

    writes: Sequence[Write] = ()
    undo: Sequence[Write] = ()
    done: Done | None = None
    holds: tuple[Hold, ...] = ()
    line: int | None = None
    keep: bool = False
    read: Callable[[Connection], Any] | None = None
    result: Any = None
    asked: float = 0.0
    fate: Fate = Fate.OPEN
    mends: LedgerError | None = None
    number: int = 0


class RevokedError(Exception):
    """Some of the jobs of a commit were refused before it was made: it must not be."""


class LostError(Exception):
    """Some rooms of a commit are another server's by now: it must not be made."""

    def __init__(self, holds: Sequence[Hold]) -> None:
        super().__init__(holds)
        self.holds = holds


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
        self._broken: dict[int, LedgerError] = {}  # lines of which not all refusals are told

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
            return any(not job.keep and job.fate is Fate.OPEN for job in self._all())

    @property
    def empty(self) -> bool:
        """Whether nothing waits."""
        with self._changed:
            return not (self._waiting or self._reads)

    def give_up(self, failure: LedgerError) -> list[Job]:
        """Refuse all that somebody waits for, as the thread does not come back; returns it."""
        with self._changed:
            refused = _refuse(job for job in self._all() if not job.keep)
            if not refused:
                return []
            self._reads.clear()
            self.silent = True
            self._shut(failure, refused)
            return refused

    def open(self, failure: LedgerError | None = None) -> None:
        """Let jobs in, unless another failure than this one came after it."""
        with self._changed:
            if failure is None or self.failure is failure:
                self.failure = None

    def mend(self, line: int) -> None:
        """Let jobs of this line in: the owners of its refused ones were told."""
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
        and see all that was put in before them, unless writes fail.
        """
        with self._changed:
            while True:
                seconds = 0.0 if self.closing else pause()
                if self._waiting and seconds <= 0.0:
                    self._taken = list(self._waiting)
                    self._waiting.clear()
                elif self._reads and not self._writes_precede(self._reads[0]):
                    self._taken = [self._reads.popleft()]
                elif self.closing:
                    return None
                else:
                    self._changed.wait(seconds if self._waiting else None)
                    continue
                return list(self._taken)

    def _writes_precede(self, read: Job) -> bool:
        """Whether writes that were put in before a read will be made soon."""
        if self.failure is not None or not self._waiting:
            return False
        return self._waiting[0].number < read.number

    def check(self, jobs: Sequence[Job]) -> None:
        """The last word before a commit; raises RevokedError when it must not be made."""
        with self._changed:
            if any(job.fate is Fate.REFUSED for job in jobs):
                raise RevokedError

    def done(self, jobs: Sequence[Job]) -> tuple[list[Job], LedgerError | None]:
        """These are durable, or read; returns whose owners are to hear, and the failure mended.

        The others were refused meanwhile: what undoes them stands first in the queue.
        """
        with self._changed:
            self._back(jobs)
            told = [job for job in jobs if job.fate is Fate.OPEN]
            for job in told:
                job.fate = Fate.DONE
            mended = any(job.mends is not None and job.mends is self.failure for job in jobs)
            return told, self.failure if mended else None

    def revoked(self) -> None:
        """The commit was not made, as some of its jobs were refused: the others wait again."""
        with self._changed:
            self._return(self._back())

    def failed(self, failure: LedgerError) -> list[Job]:
        """Nobody knows what became of the commit: refuse all; returns whose owners are to hear."""
        with self._changed:
            taken = self._back()
            refused = _refuse(job for job in (*taken, *self._waiting) if not job.keep)
            self._return(taken)
            self._shut(failure, refused)
            return refused

    def rejected(self, job: Job, failure: LedgerError) -> list[Job]:
        """The database will never take this job: refuse it and those that number on from it."""
        with self._changed:
            self._back([job])
            if job.keep or job.line is None:
                return _refuse([job])
            self._broken[job.line] = failure
            later = (each for each in (*self._taken, *self._waiting) if each.line == job.line)
            refused = _refuse([job, *later])
            self._waiting = deque(each for each in self._waiting if each.fate is Fate.OPEN)
            return refused

    def lost(self, holds: Sequence[Hold]) -> list[Job]:
        """The commit was not made, as these rooms are another server's: refuse all that is theirs.

        What is kept for a failure too; returns it. The other jobs of the commit wait again.
        """
        with self._changed:
            gone, taken = set(holds), self._back()
            refused = _refuse(j for j in (*taken, *self._waiting) if not gone.isdisjoint(j.holds))
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
        """What is open waits again, before what came later and after what undoes."""
        first = [job for job in self._waiting if job.mends is not None]
        later = [job for job in self._waiting if job.mends is None]
        kept = [job for job in jobs if job.fate is Fate.OPEN]
        self._waiting = deque([*first, *kept, *later])

    def _shut(self, failure: LedgerError, refused: Sequence[Job]) -> None:
        """Let nothing in; what was refused is taken out before anything else is written."""
        undo = [write for job in reversed(refused) for write in _undo_of(job)]
        undo += [write for job in self._waiting if job.mends is not None for write in job.writes]
        kept = [job for job in self._waiting if job.mends is None and job.fate is Fate.OPEN]
        self._waiting = deque([Job(undo, keep=True, mends=failure), *kept])
        self.failure = failure
        self._changed.notify()


def _undo_of(job: Job) -> Sequence[Write]:
    """What takes a job out again; of a room that is another server's by now that one decides."""
    if not job.holds or not job.undo:
        return job.undo
    return (IfHeld(job.holds, tuple(job.undo)),)


def _refuse(jobs: Iterable[Job]) -> list[Job]:
    """Refuse those whose fate is open; returns them."""
    refused = [job for job in jobs if job.fate is Fate.OPEN]
    for job in refused:
        job.fate = Fate.REFUSED
    return refused
