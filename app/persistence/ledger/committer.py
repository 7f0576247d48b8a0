"""The ledger's thread: takes jobs from the queue, commits or reads them, and retries on failure.

A commit ends in one of three ways. It succeeds. It fails before its COMMIT was sent: then the
database does not have it. Or its COMMIT was sent and no answer came: then the thread writes nothing
else, and reports nothing about these jobs, until the database has answered whether it has them.
"""

import logging
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import sqlalchemy as sa

from plinko.app.errors import DamagedRoomError, LeaseLostError, LedgerError, PrunedError
from plinko.app.persistence.ledger.commit_queue import (
    CommitQueue,
    Fate,
    Job,
    LostError,
    RevokedError,
)
from plinko.app.persistence.ledger.database import Database, InDoubtError, reason
from plinko.app.persistence.statements import keys, lease_store, writing
from plinko.app.rooms.records import Lease, NewDrop, Write

_RETRY: Final = (0.25, 2.0)  # s between attempts while the database fails: at first, and at most

_log = logging.getLogger("plinko")

_FAILURES = (sa.exc.SQLAlchemyError, OSError, LedgerError)
_REJECTIONS = (sa.exc.IntegrityError, sa.exc.DataError)


@dataclass(frozen=True, slots=True)
class Doubt:
    """The jobs of a commit that got no answer, and the error that came instead."""

    jobs: Sequence[Job]
    why: str


@dataclass(frozen=True, kw_only=True)
class Answers:
    """Callbacks with the outcome of jobs; each is called by `call(function, *values)`, in order.

    committed: jobs that are durable, and how long their commit took, in s.
    refused: jobs that will never be durable, and the error.
    read: one job with its result, or the error.
    recovered: the failure that is over; all refusals were reported before.
    lost: leases that other servers have taken, the jobs refused for that, and the error.
    """

    call: Callable[..., None]
    committed: Callable[[Sequence[Job], float], None]
    refused: Callable[[Sequence[Job], LedgerError], None]
    read: Callable[[Sequence[Job], LedgerError | None], None]
    recovered: Callable[[LedgerError], None]
    lost: Callable[[Sequence[Lease], Sequence[Job], LeaseLostError], None]


class Committer:
    """Commits and reads the jobs of a queue. All methods run on the ledger's thread.

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
        """Work until the queue is closed and empty, then close the database.

        Stops the server if a later release has changed the tables: it would fail at each write.
        """
        while (more := self.turn()) and not self._database.outdated:
            pass
        if more:
            _log.error("the server stops: in its ledger, %s", self._database.outdated)
            signal.raise_signal(signal.SIGTERM)
            while self.turn():
                pass
        self._database.close()

    def turn(self) -> bool:
        """Wait for work and do it; returns False when the queue is closed and empty."""
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
        """Seconds until a commit may start; negative if it may start now."""
        return self._next_commit - self._clock()

    def _write(self, jobs: Sequence[Job]) -> bool:
        """Commit jobs; returns whether other jobs of the same turn may still be committed."""
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
        except Exception as error:  # noqa: BLE001 - the thread must survive every error
            if isinstance(error, _FAILURES) and not isinstance(error, _REJECTIONS):
                self._fail(error)
                return False
            self._isolate(jobs, error)
            return True
        self._committed(jobs, self._clock() - began)
        return True

    def _commit(self, jobs: Sequence[Job]) -> None:
        with self._database.batch() as connection:
            # Check the leases before writing: rows that the room's new server has written since
            # would make a write fail with another error.
            leases = [lease for job in jobs for lease in job.leases]
            if leases and (lost := lease_store.lost(connection, leases)):
                raise LostError(lost)
            writes = [write for job in jobs for write in job.writes]
            if self._database.shared and any(map(_is_signed, writes)):
                lease_store.wait_for_log(connection)
            keys.decide(connection, [job.use for job in jobs if job.use is not None])
            new = [job for job in jobs if job.use is None or job.use.is_new]
            writes = [write for job in new for write in job.writes]
            # After a failure, write a probe first: the database must accept a page again before it
            # gets a drop.
            if not writes or self._queue.failure is not None:
                writing.probe(connection)
            writing.apply(connection, writes, self._targets)
            self._queue.send(jobs)

    def _committed(self, jobs: Sequence[Job], seconds: float) -> None:
        self._delay = _RETRY[0]
        ended = self._queue.done(jobs)
        self._call(self._answers.committed, jobs, seconds)
        if ended is not None:
            self._call(self._answers.recovered, ended)

    def _settle(self, doubt: Doubt) -> None:
        """Ask the database whether it has a commit that got no answer."""
        began = self._clock()
        try:
            there = self._database.has_batch()
        except Exception as error:  # noqa: BLE001 - the next turn asks again
            self._doubt = doubt
            failure = LedgerError(f"the ledger does not say if it has the write: {reason(error)}")
            self._report(failure, self._queue.doubted(failure))
            return
        self._doubt = None
        if there:
            self._committed(doubt.jobs, self._clock() - began)
        else:
            self._fail(LedgerError(doubt.why))

    def _lose(self, leases: Sequence[Lease]) -> None:
        """Refuse the jobs of rooms that another server has taken."""
        rooms = ", ".join(sorted(repr(lease.room) for lease in leases))
        failure = LeaseLostError(f"another server has {rooms} now", field="room")
        self._call(self._answers.lost, leases, self._queue.lost(leases), failure)

    def _isolate(self, jobs: Sequence[Job], error: BaseException) -> None:
        """Find the job that the database rejects: commit the jobs one by one, and refuse it."""
        if len(jobs) > 1:
            for job in jobs:
                if job.fate is Fate.OPEN and not self._write([job]):
                    return
            return
        (job,) = jobs
        _log.error("the ledger rejects %s: %s", job.kinds, reason(error))
        failure = LedgerError(f"the ledger rejects this write: {reason(error)}")
        self._call(self._answers.refused, self._queue.rejected(job), failure)

    def _read(self, job: Job) -> None:
        assert job.read is not None
        failure: LedgerError | None = None
        try:
            with self._database.transaction() as connection:
                job.result = job.read(connection)
        except (DamagedRoomError, PrunedError) as error:
            failure = error  # of one room; the database works
        except Exception as error:  # noqa: BLE001 - the caller gets it
            failure = LedgerError(f"the ledger cannot be read: {reason(error)}")
        self._queue.done([job])
        if job.fate is Fate.DONE:
            self._call(self._answers.read, [job], failure)

    def _fail(self, error: BaseException) -> None:
        """Refuse all jobs after a commit that failed without effect."""
        known = self._queue.failure
        failure = LedgerError(f"the ledger cannot be written: {reason(error)}")
        if known is not None and self._queue.silent:
            # The event loop has cut the connection after a time-out, which is the true reason.
            failure = LedgerError(str(known))
        first = known is None
        self._report(failure, self._queue.failed(failure), first=first)
        if self._queue.closing and (lost := self._queue.abandon()):
            _log.error("%d writes are lost at the stop; the next start computes them again", lost)

    def _report(self, failure: LedgerError, refused: Sequence[Job], *, first: bool = True) -> None:
        """Log the first failure, report the refusals, and delay the next attempt."""
        if first:
            _log.error("%s", failure)
        self._call(self._answers.refused, refused, failure)
        self._next_commit = self._clock() + self._delay
        self._delay = min(2.0 * self._delay, _RETRY[1])


def _is_signed(write: Write) -> bool:
    """Whether a write appends a receipt to the log."""
    return isinstance(write, NewDrop) and write.session is not None
