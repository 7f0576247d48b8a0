"""The rooms in the ledger, of all servers that share it: brings, lists, counts and closes them.

arriving.py brings rooms into this server's memory, leaving.py gives them to other servers.
"""

import asyncio
import contextlib
import logging
import math
from collections.abc import AsyncIterator
from typing import Final

from plinko.app.errors import DamagedRoomError, LeaseLostError, RoomLimitError
from plinko.app.live.arriving import Arriving, Claim
from plinko.app.live.leaving import Leaving
from plinko.app.live.open_rooms import OpenRooms
from plinko.app.live.public_tables import PublicTables
from plinko.app.persistence.service import PersistenceService
from plinko.app.persistence.statements import store
from plinko.app.rooms.records import ListedRoom

UNUSED_SECONDS: Final = 86_400.0  # without use after which a room with an owner is closed
REST_SECONDS: Final = 3600.0
"""An unused room with an owner makes way for another only after this time: a break in a lesson."""

SEARCH_SECONDS: Final = 60.0  # between two searches for unused rooms
_UNUSED_AT_ONCE: Final = 20  # unused rooms closed in one search
_DIRECTORY_SECONDS: Final = 1.0  # for which the list of all rooms is cached

_log = logging.getLogger("plinko")


class StoredRooms:
    """For the event loop's thread. Players may open `max_rooms` rooms."""

    def __init__(
        self,
        persistence: PersistenceService,
        rooms: OpenRooms,
        public: PublicTables,
        claim: Claim,
        max_rooms: int,
    ) -> None:
        self.leases = persistence.leases
        self.leaving = Leaving(persistence, rooms)
        self.arriving = Arriving(claim, persistence, rooms, public, self.leaving)
        self._persistence = persistence
        self._public = public
        self._ledger = persistence.ledger
        self._rooms = rooms
        self._max_rooms = max_rooms
        self._next_search = 0.0
        self._listed: list[ListedRoom] = []
        self._listed_at = -math.inf

    @property
    def alone(self) -> bool:
        """Whether no other server uses the ledger."""
        return self.leases.book.alone

    def check(self, room_id: str) -> None:
        """Raise LeaseLostError for a room that is leaving, or is perhaps at another server."""
        self.leaving.check(room_id)
        if not self.alone and room_id in self._public:
            raise LeaseLostError(f"room {room_id!r} is not at this server", field="room")

    def let_go(self, room_id: str) -> None:
        """Release the lease of a room that has left memory and is completely committed."""
        self.leases.let_go(room_id)
        self._listed_at = -math.inf

    @contextlib.asynccontextmanager
    async def having(self, room_id: str) -> AsyncIterator[None]:
        """Have a room's lease for a while, even if it is closed; raises what `fetch` raises."""
        if not self.alone:
            await self.arriving.fetch(room_id)
        if self.alone or room_id in self._rooms.in_memory:
            yield
            return
        await self.arriving.begin(room_id)
        try:
            yield
        finally:
            if room_id not in self._rooms.in_memory:
                self.let_go(room_id)

    async def directory(self) -> list[ListedRoom]:
        """Every open room at any server, as last committed; raises LedgerError."""
        now = self._persistence.now()
        if not self._listed_at <= now < self._listed_at + _DIRECTORY_SECONDS:
            self._listed = await self._ledger.read(store.directory)
            self._listed_at = now
        return self._listed

    async def made_by(self, creator: str) -> int:
        """How many open rooms this creator has at all servers; raises LedgerError."""
        return await self._ledger.read(store.count_owned, creator=creator)

    async def free(self) -> int:
        """How many more rooms players can open before one must make way; raises LedgerError."""
        return max(0, self._max_rooms - await self._ledger.read(store.count_owned))

    async def make_place(self) -> None:
        """Close the longest unused room with an owner if there are too many.

        Raises RoomLimitError if all of them were used recently, LedgerError.
        """
        if not await self.free():
            await self._close_unused(REST_SECONDS, "room for another", 1)
            if not await self.free():
                raise RoomLimitError(f"all {self._max_rooms} rooms are in use; try again later")

    async def renew(self) -> None:
        """Close rooms that have been unused for too long, once a minute; raises LedgerError."""
        now = self._persistence.now()
        if now >= self._next_search:
            await self._close_unused(UNUSED_SECONDS, "unused", _UNUSED_AT_ONCE)
            self._next_search = now + SEARCH_SECONDS

    async def _close_unused(self, seconds: float, why: str, most: int) -> None:
        before, here = self._persistence.now() - seconds, self._rooms.in_memory
        self._rooms.park_unused(seconds, len(here))
        # Of a room in memory the ledger may not have the last use.
        limit = most + len(here)
        unused = await self._ledger.read(store.unused_rooms, before=before, limit=limit)
        others = [each for each in unused if each.id not in here]
        for room in others[:most]:
            if room.id in self.arriving.coming:
                continue
            closing = self.arriving.begin_work(room.id, self._close(room, before, why))
            # The room is in use at another server, or it is damaged.
            with contextlib.suppress(LeaseLostError, DamagedRoomError):
                await asyncio.shield(closing)

    async def _close(self, room: ListedRoom, before: float, why: str) -> None:
        await self.arriving.begin(room.id)
        try:
            row = await self._ledger.read(store.open_run, number=room.number)
            if row is not None and not row.awake and row.used < before:
                self._persistence.close(room)
                _log.info("room closed", extra={"room": room.id, "why": why})
        finally:
            self.leases.let_go(room.id)
