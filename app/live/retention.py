"""Deletes old rows of the ledger while the server runs, a few in each write."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Final

from plinko.app.errors import AppError, LedgerError
from plinko.app.live.sessions.fair_sessions import FairSessions
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import fair_store, retention
from plinko.app.rooms.records import Prune

_SWEEP: Final = 3600.0  # s between two sweeps
_REST: Final = 0.1  # s between two writes: players' drops come first
_DAY: Final = 86_400.0

_log = logging.getLogger("plinko")


class Retention:
    """For the event loop's thread. `days` as in the setting; `now` returns Unix time in s.

    Where several servers share the ledger, only the one whose `mine` returns True deletes.
    """

    def __init__(
        self,
        ledger: Ledger,
        fair: FairSessions,
        days: float,
        *,
        mine: Callable[[], bool] = lambda: True,
        now: Callable[[], float],
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._ledger = ledger
        self._fair = fair
        self._seconds = days * _DAY
        self._mine = mine
        self._now = now
        self._sleep = sleep

    async def run(self) -> None:
        """Sweep every hour, until cancelled."""
        while True:
            try:
                if self._mine():
                    await self.sweep()
            except LedgerError as error:
                _log.info("old rows stay until the next sweep: %s", error)
            await self._sleep(_SWEEP)

    async def sweep(self) -> int:
        """Delete all that is old; returns the number of deleted drops. Raises LedgerError."""
        kept, now = self._seconds, self._now()
        keys = min(retention.KEY_SECONDS, kept or retention.KEY_SECONDS)
        await self._prune(None, now - keys)
        if not kept:
            return 0
        await self._end_sessions(now - kept)
        runs = await self._ledger.read(retention.runs, before=now - kept)
        drops = sum([await self._prune(run, now - kept) for run in runs])
        if drops:
            _log.warning("%d drops older than %g days are deleted", drops, kept / _DAY)
        return drops

    async def _prune(self, run: int | None, before: float) -> int:
        step, drops = Prune(run, before), 0
        while True:
            await self._ledger.commit(step)
            drops += step.drops
            if step.next is None:
                return drops
            step = Prune(run, before, step.next)
            await self._sleep(_REST)

    async def _end_sessions(self, before: float) -> None:
        """End sessions that began before this time and that nobody uses any more."""
        for session in await self._ledger.read(fair_store.unended_before, before=before):
            try:
                await self._fair.find(session)
            except LedgerError:
                raise
            except AppError as error:
                _log.info("a session stays open: %s", error)
