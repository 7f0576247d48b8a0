"""Brings rooms from the ledger into this server's memory.

Where several servers share a ledger, only one server has a room at a time. This server takes a room
when a client asks for it here, or when the server that had it has failed.
"""

import asyncio
import logging
from collections.abc import Callable, Coroutine
from typing import Final

from plinko.app.concurrency.single_flight import SingleFlight
from plinko.app.errors import LeaseLostError, LedgerError, RebuildingError
from plinko.app.live.leaving import Leaving
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.open_rooms import OpenRooms
from plinko.app.live.public_tables import PublicTables
from plinko.app.persistence.service import PersistenceService
from plinko.app.persistence.statements import lease_store
from plinko.app.rooms.records import LeaseRow
from plinko.app.rooms.room import Room

_ARRIVAL_SECONDS: Final = 10.0
"""s that a client waits for a room before it gets RebuildingError."""

_AT_ONCE: Final = 4  # rooms loaded at a time

_log = logging.getLogger("plinko")

Claim = Callable[[str, LeaseRow | None], int | None]
"""Decides whether this server may take a room whose lease has this row.

Returns the number of the lease that the new one must follow, or None if any will do. Raises
LeaseLostError if the room belongs to another server."""


def any_room(room_id: str, row: LeaseRow | None) -> None:
    """A claim that allows every room."""


class Arriving:
    """For the event loop's thread."""

    def __init__(
        self,
        claim: Claim,
        persistence: PersistenceService,
        rooms: OpenRooms,
        public: PublicTables,
        leaving: Leaving,
    ) -> None:
        self._leases = persistence.leases
        self._claim = claim
        self._persistence = persistence
        self._rooms = rooms
        self._public = public
        self._leaving = leaving
        # Rooms for which `begin_work` runs.
        self.coming: dict[str, asyncio.Task[LiveRoom | None]] = {}
        self._lookups = SingleFlight[
            tuple[bool, int | None]
        ]()  # reads of leases in progress, by room
        self._places = asyncio.Semaphore(_AT_ONCE)

    async def fetch(self, room_id: str) -> None:
        """Bring the room with this id into memory, if it exists.

        Raises what the claim raises, LedgerError, DamagedRoomError, and RebuildingError if it takes
        too long.
        """
        await self._leaving.until_left(room_id)
        if room_id in self._rooms.in_memory:
            await self._confirm(room_id)
        if room_id in self._rooms.in_memory:
            return
        self._persistence.recovery.check(room_id)
        exists, after = True, None
        if room_id not in self.coming:
            exists, after = await self._lookups.do(room_id, lambda: self._look_up(room_id))
        if exists:
            await self.take(room_id, after)

    async def _look_up(self, room_id: str) -> tuple[bool, int | None]:
        """Whether the room exists, and the lease that this server's lease must follow."""
        exists, row = await self._persistence.ledger.read(lease_store.standing, room=room_id)
        exists = exists or room_id in self._public
        return exists, self._claim(room_id, row) if exists else None

    async def _confirm(self, room_id: str) -> None:
        """Remove a room that another server has taken.

        A server that was frozen could still show its clients a state that another server has
        replaced. While the ledger cannot be read, the room stays.
        """
        lease = self._leases.book.of(room_id)
        try:
            await self._leases.confirm_lately(room_id)
        except LeaseLostError:
            # Otherwise the room left meanwhile, and may have come back under another lease.
            if self._leases.book.of(room_id) == lease:
                self._leaving.put_away(room_id)
        except LedgerError as error:
            _log.info("cannot confirm the lease of a room: %s", error, extra={"room": room_id})

    async def begin(self, room_id: str) -> None:
        """Take the lease of a new room; raises what the claim raises, and LedgerError."""
        if self._leases.book.alone:
            return
        row = await self._persistence.ledger.read(lease_store.holder_of, room=room_id)
        await self._leases.take(room_id, self._claim(room_id, row), self._leaving.put_away)

    async def take(self, room_id: str, after: int | None = None) -> LiveRoom | None:
        """Take a room to this server, even from another; returns None if it does not exist.

        `after` is as for `Leases.take`. Raises LeaseLostError, LedgerError, DamagedRoomError, and
        RebuildingError if it takes too long.
        """
        live = self._rooms.in_memory.get(room_id)
        if live is not None:
            return live
        if room_id not in self.coming:
            self.begin_work(room_id, self._bring(room_id, after))
        try:
            async with asyncio.timeout(_ARRIVAL_SECONDS):
                return await asyncio.shield(self.coming[room_id])
        except TimeoutError:
            raise RebuildingError(
                f"room {room_id!r} is being replayed from the ledger; it is not lost, try again "
                "soon",
                field="room",
            ) from None

    def begin_work(
        self, room_id: str, work: Coroutine[None, None, LiveRoom | None]
    ) -> "asyncio.Task[LiveRoom | None]":
        """Run `work` on a room that is not in memory; clients that want the room wait for it."""
        task = self.coming[room_id] = asyncio.create_task(work, name=room_id)
        task.add_done_callback(self._came)
        return task

    def _came(self, task: "asyncio.Task[LiveRoom | None]") -> None:
        room_id = task.get_name()
        del self.coming[room_id]
        if not task.cancelled() and task.exception() is not None:
            _log.info("cannot bring a room here: %s", task.exception(), extra={"room": room_id})

    async def _bring(self, room_id: str, after: int | None) -> LiveRoom | None:
        lease = await self._leases.take(room_id, after, self._leaving.put_away)
        try:
            async with self._places:
                room = await self._load(room_id)
        except BaseException:
            self._leases.book.drop(room_id)
            raise
        if self._leases.book.of(room_id) != lease:
            raise LeaseLostError(f"another server has taken room {room_id!r}", field="room")
        if room is None:
            self._leases.let_go(room_id)
            return None
        return self._rooms.add(room)

    async def _load(self, room_id: str) -> Room | None:
        ground = self._public.ground(room_id)
        room = await self._persistence.recovery.load(room_id, ground_now=ground)
        if room is None and ground is not None:
            room = await self._rooms.make(room_id, *self._public.find(room_id))
            runs = self._persistence.runs
            runs.begin(room_id, await runs.new_run(room_id))
        return room
