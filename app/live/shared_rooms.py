"""The rooms of a ledger that several servers share: listed and counted over all servers.

How they come to this server is in `arriving`, how they leave it in `leaving`.
"""

import asyncio
import contextlib
import logging
import math
from typing import Final

from app.errors import AppError
from app.live.arriving import Arriving
from app.live.leaving import Leaving
from app.live.open_rooms import REST_SECONDS, UNUSED_SECONDS, OpenRooms
from app.persistence.leases import Leases
from app.persistence.service import PersistenceService
from app.persistence.statements import store
from app.rooms.records import Listed, Parked
from app.settings import Settings

_SEARCH_SECONDS: Final = 60.0  # between two searches for rooms that nobody uses
_UNUSED_AT_ONCE: Final = 20  # of them closed at a time
_DIRECTORY_SECONDS: Final = 1.0  # for which a list of all rooms is given again

_log = logging.getLogger("plinko")


class SharedRooms:
    """For the event loop's thread."""

    def __init__(
        self,
        settings: Settings,
        persistence: PersistenceService,
        rooms: OpenRooms,
        leases: Leases,
        leaving: Leaving,
        arriving: Arriving,
    ) -> None:
        self.leases = leases
        self.leaving = leaving
        self.arriving = arriving
        self._settings = settings
        self._persistence = persistence
        self._ledger = persistence.ledger
        self._rooms = rooms
        self._next_search = 0.0
        self._listed: list[Listed] = []
        self._listed_at = -math.inf

    async def directory(self) -> list[Listed]:
        """Every open room at any server, as the ledger last heard of it; raises LedgerError."""
        now = self._persistence.now()
        if not self._listed_at <= now < self._listed_at + _DIRECTORY_SECONDS:
            self._listed = await self._ledger.read(store.directory)
            self._listed_at = now
        return self._listed

    async def made_by(self, creator: str) -> int:
        """How many open rooms bear this mark of who made them; raises LedgerError."""
        await self._count()
        return await self._ledger.read(store.count_owned, creator=creator)

    async def make_place(self) -> None:
        """Count players' rooms at all servers before another is made; raises LedgerError.

        With as many as there may be the longest unused one is closed, as `OpenRooms` would.
        """
        await self._count()
        if self._rooms.free == 0:
            await self._close_unused(REST_SECONDS, "room for another", 1)
            await self._count()

    async def look_after(self) -> None:
        """Now and then, close the rooms that nobody has used for too long; raises LedgerError."""
        now = self._persistence.now()
        if now >= self._next_search:
            self._next_search = now + _SEARCH_SECONDS
            await self._close_unused(UNUSED_SECONDS, "unused", _UNUSED_AT_ONCE)

    async def _count(self) -> None:
        self._rooms.count(await self._ledger.read(store.count_owned))

    async def _close_unused(self, seconds: float, why: str, most: int) -> None:
        before = self._persistence.now() - seconds
        for room in await self._ledger.read(store.unused_rooms, before=before, limit=most):
            if room.id in self._rooms.in_memory or self.arriving.is_coming(room.id):
                continue
            closing = self.arriving.begin_work(room.id, self._close(room, before, why))
            with contextlib.suppress(AppError):  # another server has it, and so it is in use
                await asyncio.shield(closing)

    async def _close(self, room: Parked, before: float, why: str) -> None:
        await self.arriving.begin(room.id)
        try:
            row = await self._ledger.read(store.open_session, number=room.number)
            if row is not None and not row.awake and row.used < before:
                self._persistence.close(room)
                _log.info("room closed", extra={"room": room.id, "why": why})
        finally:
            self.leases.let_go(room.id)
