"""Rooms of a ledger that several servers share come to this one.

A room is at one server at a time. It is brought here when a client asks for it here, or when the
server that had it is gone, and is rebuilt from what that one has written.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine
from typing import Final

from app.concurrency.single_flight import SingleFlight
from app.errors import LeaseLostError, LedgerError
from app.live.leaving import Leaving, Memory
from app.live.live_room import LiveRoom
from app.live.open_rooms import OpenRooms
from app.live.public_tables import PublicTables
from app.persistence.leases import Leases
from app.persistence.recovery.rebuild_queue import rebuilding
from app.persistence.service import PersistenceService
from app.persistence.statements import lease_store
from app.rooms.records import LeaseRow
from app.rooms.room import Ground, Room

_ARRIVAL_SECONDS: Final = 10.0
"""s that a client waits for a room; then it hears that the room takes longer."""

_AT_ONCE: Final = 4  # rooms that are rebuilt at a time

_log = logging.getLogger("plinko")

Claim = Callable[[str, LeaseRow | None], int | None]
"""Whether this server may take a room that has this row: the number of the lease that its own is to
follow, None for any, or a LeaseLostError."""


def any_room(room_id: str, row: LeaseRow | None) -> None:
    """Any room may be taken, whoever has it."""


class Arriving:
    """For the event loop's thread. `make` makes a public room that the ledger does not know."""

    def __init__(
        self,
        leases: Leases,
        claim: Claim,
        persistence: PersistenceService,
        rooms: OpenRooms,
        public: PublicTables,
        memory: Memory,
        make: Callable[[str, Ground, str], Awaitable[Room]],
        leaving: Leaving,
    ) -> None:
        self._leases = leases
        self._claim = claim
        self._persistence = persistence
        self._rooms = rooms
        self._public = public
        self._memory = memory
        self._make = make
        self._leaving = leaving
        self._coming: dict[str, asyncio.Task[LiveRoom | None]] = {}
        self._looks = SingleFlight[tuple[bool, int | None]]()  # for rooms that are not here
        self._places = asyncio.Semaphore(_AT_ONCE)

    async def fetch(self, room_id: str) -> None:
        """Have a room in memory, if there is one of this id; raises what the claim raises.

        Also LedgerError, DamagedRoomError, RebuildingError when it takes too long to wait.
        """
        await self._leaving.until_left(room_id)
        if room_id in self._rooms.in_memory:
            await self._confirm(room_id)
        if room_id in self._rooms.in_memory:
            return
        self._persistence.recovery.check(room_id)
        exists, after = True, None
        if room_id not in self._coming:
            exists, after = await self._looks.do(room_id, lambda: self._look_for(room_id))
        if exists:
            await self.take_over(room_id, after)

    async def _look_for(self, room_id: str) -> tuple[bool, int | None]:
        """Whether there is a room, and after which lease this server may take it."""
        exists, row = await self._persistence.ledger.read(lease_store.standing, room=room_id)
        exists = exists or room_id in self._public
        return exists, self._claim(room_id, row) if exists else None

    async def _confirm(self, room_id: str) -> None:
        """Put a room away that another server has taken: no client comes to it here any more.

        A server that was frozen could still show its clients a state that another server has
        replaced. While the ledger cannot be read nothing is known to be wrong.
        """
        lease = self._leases.book.of(room_id)
        try:
            await self._leases.confirm_lately(room_id)
        except LeaseLostError:
            if self._leases.book.of(room_id) == lease:  # else it left meanwhile, and may be back
                self._leaving.put_away(room_id)
        except LedgerError as error:
            _log.info("it is not seen who has a room: %s", error, extra={"room": room_id})

    async def begin(self, room_id: str) -> None:
        """Have a room that nobody had: its id is new; raises what the claim raises, LedgerError."""
        row = await self._leases.holder_of(room_id)
        after = self._claim(room_id, row)
        await self._leases.take(room_id, after, self._leaving.put_away)

    async def take_over(self, room_id: str, after: int | None = None) -> LiveRoom | None:
        """Have a room here from now on, whoever had it; None where there is no such room.

        `after` as for `Leases.take`. Raises LeaseLostError, LedgerError, DamagedRoomError, and
        RebuildingError when it takes too long to wait.
        """
        live = self._rooms.in_memory.get(room_id)
        if live is not None:
            return live
        if room_id not in self._coming:
            self.begin_work(room_id, self._bring(room_id, after))
        try:
            async with asyncio.timeout(_ARRIVAL_SECONDS):
                return await asyncio.shield(self._coming[room_id])
        except TimeoutError:
            raise rebuilding(room_id) from None

    def begin_work(
        self, room_id: str, work: Coroutine[None, None, LiveRoom | None]
    ) -> "asyncio.Task[LiveRoom | None]":
        """Run `work` for a room that is not in memory; who asks for the room waits for it."""
        task = self._coming[room_id] = asyncio.create_task(work, name=room_id)
        task.add_done_callback(self._came)
        return task

    def is_coming(self, room_id: str) -> bool:
        """Whether something is done with a room that is not in memory."""
        return room_id in self._coming

    def _came(self, task: "asyncio.Task[LiveRoom | None]") -> None:
        room_id = task.get_name()
        del self._coming[room_id]
        if not task.cancelled() and task.exception() is not None:
            _log.info("room stays away: %s", task.exception(), extra={"room": room_id})

    async def _bring(self, room_id: str, after: int | None) -> LiveRoom | None:
        await self._leases.take(room_id, after, self._leaving.put_away)
        try:
            async with self._places:
                room = await self._load(room_id)
        except BaseException:
            self._leases.book.drop(room_id)
            raise
        if self._leases.book.of(room_id) is None:
            raise LeaseLostError(f"room {room_id!r} was taken by another server", field="room")
        if room is None:
            self._leases.let_go(room_id)
            return None
        return self._memory.add(room)

    async def _load(self, room_id: str) -> Room | None:
        ground = self._public.ground(room_id)
        room = await self._persistence.recovery.load(room_id, ground_now=ground)
        if room is None and ground is not None:
            room = await self._make(room_id, *self._public.find(room_id))
        return room
