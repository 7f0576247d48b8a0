"""Lists, counts and closes rooms over all servers that share a ledger.

arriving.py brings rooms to this server, leaving.py gives them up.
"""

import asyncio
import contextlib
import logging
import math
from collections.abc import AsyncIterator
from typing import Final

from plinko.app.errors import DamagedRoomError, LeaseLostError
from plinko.app.live.arriving import Arriving
from plinko.app.live.leaving import Leaving
from plinko.app.live.open_rooms import REST_SECONDS, UNUSED_SECONDS, OpenRooms
from plinko.app.live.public_tables import PublicTables
from plinko.app.persistence.leases import Leases
from plinko.app.persistence.service import PersistenceService
from plinko.app.persistence.statements import store
from plinko.app.rooms.records import Parked

_SEARCH_SECONDS: Final = 60.0  # between two searches for unused rooms
_UNUSED_AT_ONCE: Final = 20  # unused rooms closed in one search
_DIRECTORY_SECONDS: Final = 1.0  # for which the list of all rooms is cached

_log = logging.getLogger("plinko")


class UnsharedRooms:
    """Stands in for `SharedRooms` if only one server uses the ledger: it has every room."""

    alone = True

    def check(self, room_id: str) -> None:
        """Do nothing: no room is at another server."""

    async def fetch(self, room_id: str) -> None:
        """Do nothing: no room is at another server."""

    async def begin(self, room_id: str) -> None:
        """Do nothing: a room needs no lease."""

    def let_go(self, room_id: str) -> None:
        """Do nothing: a room has no lease."""

    @contextlib.asynccontextmanager
    async def having(self, room_id: str) -> AsyncIterator[None]:
        yield

    async def directory(self) -> list[Parked]:
        """An empty list: there are no rooms at other servers."""
        return []

    async def made_by(self, creator: str) -> int | None:
        """None: the caller counts by itself."""
        return None

    async def make_place(self) -> None:
        """Do nothing: `OpenRooms` makes place."""

    async def look_after(self) -> None:
        """Do nothing: `OpenRooms` closes unused rooms."""


class SharedRooms(UnsharedRooms):
    """For the event loop's thread."""

    alone = False

    def __init__(
        self,
        persistence: PersistenceService,
        rooms: OpenRooms,
        public: PublicTables,
        leases: Leases,
        leaving: Leaving,
        arriving: Arriving,
    ) -> None:
        self.leases = leases
        self.leaving = leaving
        self.arriving = arriving
        self._persistence = persistence
        self._public = public
        self._ledger = persistence.ledger
        self._rooms = rooms
        self._next_search = 0.0
        self._listed: list[Parked] = []
        self._listed_at = -math.inf

    def check(self, room_id: str) -> None:
        """Raise LeaseLostError for a room that is leaving, or is perhaps at another server."""
        self.leaving.check(room_id)
        if room_id in self._public:
            raise LeaseLostError(f"room {room_id!r} is not at this server", field="room")

    async def fetch(self, room_id: str) -> None:
        """Bring a room into memory, as `Arriving.fetch` does."""
        await self.arriving.fetch(room_id)

    async def begin(self, room_id: str) -> None:
        """Take the lease of a new room, as `Arriving.begin` does."""
        await self.arriving.begin(room_id)

    def let_go(self, room_id: str) -> None:
        """Release the lease of a room that has left memory and is completely committed."""
        self.leases.let_go(room_id)

    @contextlib.asynccontextmanager
    async def having(self, room_id: str) -> AsyncIterator[None]:
        """Have a room's lease for a while, even if it is closed; raises what `fetch` raises."""
        await self.fetch(room_id)
        if room_id in self._rooms.in_memory:
            yield
            return
        await self.begin(room_id)
        try:
            yield
        finally:
            if room_id not in self._rooms.in_memory:
                self.let_go(room_id)

    async def directory(self) -> list[Parked]:
        """Every open room at any server, as last committed; raises LedgerError."""
        now = self._persistence.now()
        if not self._listed_at <= now < self._listed_at + _DIRECTORY_SECONDS:
            self._listed = await self._ledger.read(store.directory)
            self._listed_at = now
        return self._listed

    async def made_by(self, creator: str) -> int | None:
        """How many open rooms this creator has at all servers; raises LedgerError."""
        await self._count()
        return await self._ledger.read(store.count_owned, creator=creator)

    async def make_place(self) -> None:
        """Count the rooms with owners at all servers before another is opened.

        If there are too many, close the longest unused one. Raises LedgerError.
        """
        await self._count()
        if self._rooms.free == 0:
            await self._close_unused(REST_SECONDS, "room for another", 1)
            await self._count()

    async def look_after(self) -> None:
        """Close rooms that have been unused for too long, once a minute; raises LedgerError."""
        now = self._persistence.now()
        if now >= self._next_search:
            await self._close_unused(UNUSED_SECONDS, "unused", _UNUSED_AT_ONCE)
            self._next_search = now + _SEARCH_SECONDS

    async def _count(self) -> None:
        self._rooms.count(await self._ledger.read(store.count_owned))

    async def _close_unused(self, seconds: float, why: str, most: int) -> None:
        before = self._persistence.now() - seconds
        for room in await self._ledger.read(store.unused_rooms, before=before, limit=most):
            if room.id in self._rooms.in_memory or self.arriving.is_coming(room.id):
                continue
            closing = self.arriving.begin_work(room.id, self._close(room, before, why))
            # The room is in use at another server, or it is damaged.
            with contextlib.suppress(LeaseLostError, DamagedRoomError):
                await asyncio.shield(closing)

    async def _close(self, room: Parked, before: float, why: str) -> None:
        await self.arriving.begin(room.id)
        try:
            row = await self._ledger.read(store.open_run, number=room.number)
            if row is not None and not row.awake and row.used < before:
                self._persistence.close(room)
                _log.info("room closed", extra={"room": room.id, "why": why})
        finally:
            self.leases.let_go(room.id)
