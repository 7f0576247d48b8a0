"""The ledger's thread: takes what waits, commits or reads it, and tries again when it cannot.

A commit ends in one of three ways. It succeeds. It fails before its COMMIT was sent: then the
database does not have it. Or its COMMIT was sent and no answer came: then nothing else is done, and
nothing is said, until the database has told what became of it.
"""

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import sqlalchemy as sa

from app.errors import DamagedRoomError, LeaseLostError, LedgerError
from app.persistence.ledger.commit_queue import CommitQueue, Fate, Job, LostError, RevokedError
from app.persistence.ledger.database import Database, InDoubtError, reason
from app.persistence.statements import lease_store, writing
from app.rooms.records import Lease, LogLeaf

_RETRY: Final = (0.25, 2.0)  # s between attempts while the database is lost: at first, and at most

_log = logging.getLogger("plinko")

_FAILURES = (sa.exc.SQLAlchemyError, OSError, LedgerError)
_REJECTIONS = (sa.exc.IntegrityError, sa.exc.DataError)


@dataclass(frozen=True, slots=True)
class Doubt:
    """The jobs of a commit that was not answered, and what came instead of the answer."""

    jobs: Sequence[Job]
    why: str


@dataclass(frozen=True, kw_only=True)
class Answers:
    """What is called with what came of jobs, by `call(function, *values)`, in order.

    committed: jobs that are durable, and the seconds their commit took; refused: jobs that never
    will be, and why; read: one job with its result, or why there is none; mended: the failure that
    is over, all refused jobs told; lost: rooms that are another server's by now, and the jobs that
    are refused for it.
    """

    call: Callable[..., None]
    committed: Callable[[Sequence[Job], float], None]
    refused: Callable[[Sequence[Job], LedgerError], None]
    read: Callable[[Sequence[Job], LedgerError | None], None]
    mended: Callable[[LedgerError], None]
    lost: Callable[[Sequence[Lease], Sequence[Job], LeaseLostError], None]


class Committer:
    """Works off a queue over one database; every method but the constructor is the thread's.

    At most one commit starts in each `period` seconds of `clock`. `targets` are the addresses of
    webhooks.
    """

    def __init__(
        self,
        database: Database,
        queue: CommitQueue,
        answers: Answers,
        *,
        period: float,
        clock: Callable[[], float] = time.monotonic,
        targets: Sequence[str] = (),
    ) -> None:
        self._database = database
        self._targets = targets
        self._queue = queue
        self._answers = answers
        self._call = answers.call
        self._period = period
        self._clock = clock
        self._next_commit = clock()
        self._delay = _RETRY[0]
        self._doubt: Doubt | None = None

    def run(self) -> None:
        """Work until the queue is closed and empty, then close the database."""
        while self.turn():
            pass
        self._database.close()

    def turn(self) -> bool:
        """Wait for work and do it; returns whether there will be more."""
        if self._doubt is not None:
            time.sleep(max(0.0, self.pause()))
            self._settle(self._doubt)
            return True
        jobs = self._queue.take(self.pause)
        if jobs is None:
            return False
        if jobs and jobs[0].read is not None:
            self._read(jobs[0])
        else:
            self._write(jobs)
        return True

    def pause(self) -> float:
        """Seconds until a commit may start; negative where one might have."""
        return self._next_commit - self._clock()

    def _write(self, jobs: Sequence[Job]) -> bool:
        """Commit these; returns whether the others that were taken with them are still in hand."""
        began = self._clock()
        self._next_commit = began + self._period
        try:
            self._commit(jobs)
        except RevokedError:
            self._queue.revoked()
            return False
        except LostError as error:
            self._lose(error.leases)
            return False
        except InDoubtError as doubt:
            self._settle(Doubt(jobs, str(doubt)))
            return False
        except Exception as error:  # noqa: BLE001 - whatever it is, the thread must go on
            if isinstance(error, _FAILURES) and not isinstance(error, _REJECTIONS):
                self._suffer(error)
                return False
            self._sift(jobs, error)
            return True
        self._committed(jobs, self._clock() - began)
        return True

    def _commit(self, jobs: Sequence[Job]) -> None:
        with self._database.batch() as connection:
            # Before anything is written: what another server has written meanwhile is in the way.
            leases = [lease for job in jobs for lease in job.leases]
            if leases and (lost := lease_store.lost(connection, leases)):
                raise LostError(lost)
            writes = [write for job in jobs for write in job.writes]
            if self._database.shared and any(isinstance(write, LogLeaf) for write in writes):
                lease_store.wait_for_log(connection)
            # A database that was lost must take a page again before it is trusted with a drop.
            if not writes or self._queue.failure is not None:
                writing.probe(connection)
            writing.apply(connection, writes, self._targets)
            self._queue.send(jobs)

    def _committed(self, jobs: Sequence[Job], seconds: float) -> None:
        self._delay = _RETRY[0]
        outlived = self._queue.done(jobs)
        self._call(self._answers.committed, jobs, seconds)
        if outlived is not None:
            self._call(self._answers.mended, outlived)

    def _settle(self, doubt: Doubt) -> None:
        """Ask the database what became of a commit that was not answered."""
        began = self._clock()
        try:
            there = self._database.has_batch()
        except Exception as error:  # noqa: BLE001 - whatever it is, it is asked again
            self._doubt = doubt
            failure = LedgerError(f"the ledger does not say what it has: {reason(error)}")
            self._suffered(failure, self._queue.doubted(failure))
            return
        self._doubt = None
        if there:
            self._committed(doubt.jobs, self._clock() - began)
        else:
            self._suffer(LedgerError(doubt.why))

    def _lose(self, leases: Sequence[Lease]) -> None:
        """These rooms are another server's; all else is as before."""
        rooms = ", ".join(sorted(repr(lease.room) for lease in leases))
        failure = LeaseLostError(f"another server has {rooms} now", field="room")
        self._call(self._answers.lost, leases, self._queue.lost(leases), failure)

    def _sift(self, jobs: Sequence[Job], error: BaseException) -> None:
        """The database is well, but one of these it will never take: the others one by one."""
        if len(jobs) > 1:
            for job in jobs:
                if job.fate is Fate.OPEN and not self._write([job]):
                    return
            return
        (job,) = jobs
        _log.error("the ledger refuses %r: %s", job.writes, reason(error))
        failure = LedgerError(f"the ledger refuses it: {reason(error)}")
        self._call(self._answers.refused, self._queue.rejected(job, failure), failure)

    def _read(self, job: Job) -> None:
        assert job.read is not None
        failure: LedgerError | None = None
        try:
            with self._database.transaction() as connection:
                job.result = job.read(connection)
        except DamagedRoomError as error:
            failure = error  # the database is well, and so are other rooms
        except Exception as error:  # noqa: BLE001 - whoever asked is to hear of it
            failure = LedgerError(f"the ledger cannot be read: {reason(error)}")
        self._queue.done([job])
        if job.fate is Fate.DONE:
            self._call(self._answers.read, [job], failure)

    def _suffer(self, error: BaseException) -> None:
        """The database has nothing of what was taken: refuse all that waits."""
        known = self._queue.failure
        failure = LedgerError(f"the ledger cannot be written: {reason(error)}")
        if known is not None and self._queue.silent:  # its line was cut, for a reason
            failure = LedgerError(str(known))
        first = known is None
        self._suffered(failure, self._queue.failed(failure), first=first)
        if self._queue.closing and (lost := self._queue.abandon()):
            _log.error("%d writes are left to the next start to compute again", lost)

    def _suffered(
        self, failure: LedgerError, refused: Sequence[Job], *, first: bool = True
    ) -> None:
        """Say so; the next attempt comes in a while."""
        if first:
            _log.error("%s", failure)
        self._call(self._answers.refused, refused, failure)
        self._next_commit = self._clock() + self._delay
        self._delay = min(2.0 * self._delay, _RETRY[1])
