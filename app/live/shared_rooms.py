"""The rooms of a ledger that several servers share: listed and counted over all servers.

How they come to this server is in `arriving`, how they leave it in `leaving`.
"""

import asyncio
import contextlib
import logging
import math
from collections.abc import AsyncIterator
from typing import Final

from app.errors import DamagedRoomError, LeaseLostError
from app.live.arriving import Arriving
from app.live.leaving import Leaving
from app.live.open_rooms import REST_SECONDS, UNUSED_SECONDS, OpenRooms
from app.live.public_tables import PublicTables
from app.persistence.leases import Leases
from app.persistence.service import PersistenceService
from app.persistence.statements import store
from app.rooms.records import Listed, Parked

_SEARCH_SECONDS: Final = 60.0  # between two searches for rooms that nobody uses
_UNUSED_AT_ONCE: Final = 20  # of them closed at a time
_DIRECTORY_SECONDS: Final = 1.0  # for which a list of all rooms is given again

_log = logging.getLogger("plinko")


class UnsharedRooms:
    """Stands for `SharedRooms` where one server has the ledger alone: every room is its own."""

    alone = True

    def check(self, room_id: str) -> None:
        """No room is at another server."""

    async def fetch(self, room_id: str) -> None:
        """No room is brought here."""

    async def begin(self, room_id: str) -> None:
        """A new room is this server's without a lease."""

    def let_go(self, room_id: str) -> None:
        """Nobody else is to have it."""

    @contextlib.asynccontextmanager
    async def having(self, room_id: str) -> AsyncIterator[None]:
        """Every room is here."""
        yield

    async def directory(self) -> list[Listed]:
        """No room but those that this server knows."""
        return []

    async def made_by(self, creator: str) -> int | None:
        """None: this server alone knows, and counts itself."""
        return None

    async def make_place(self) -> None:
        """`OpenRooms` does so."""

    async def look_after(self) -> None:
        """`OpenRooms` does so."""


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
        self._listed: list[Listed] = []
        self._listed_at = -math.inf

    def check(self, room_id: str) -> None:
        """Raise LeaseLostError for a room that is not here, but is or may be at another server."""
        self.leaving.check(room_id)  # who still watches is sent on, whatever they ask for
        if room_id in self._public:
            raise LeaseLostError(f"room {room_id!r} is not at this server", field="room")

    async def fetch(self, room_id: str) -> None:
        """Have a room in memory, if there is one of this id; raises what `Arriving.fetch` does."""
        await self.arriving.fetch(room_id)

    async def begin(self, room_id: str) -> None:
        """Have a room that nobody had: its id is new; raises what `Arriving.begin` does."""
        await self.arriving.begin(room_id)

    def let_go(self, room_id: str) -> None:
        """A room has left the memory, and all of it is written: any server may have it."""
        self.leases.let_go(room_id)

    @contextlib.asynccontextmanager
    async def having(self, room_id: str) -> AsyncIterator[None]:
        """Have a room here for a while, even one that is closed; raises what `fetch` raises."""
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

    async def directory(self) -> list[Listed]:
        """Every open room at any server, as the ledger last heard of it; raises LedgerError."""
        now = self._persistence.now()
        if not self._listed_at <= now < self._listed_at + _DIRECTORY_SECONDS:
            self._listed = await self._ledger.read(store.directory)
            self._listed_at = now
        return self._listed

    async def made_by(self, creator: str) -> int | None:
        """How many open rooms bear this mark of who made them, anywhere; raises LedgerError."""
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
            # Another server has it, and so it is in use; or it cannot be read.
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
