"""Rooms of a ledger that several servers share leave this one.

In order, from the very tick at which they are and with all that is known of them written down; or
at once, when another server has taken them.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Final, Protocol

from app.concurrency.to_the_end import to_the_end
from app.errors import LeaseLostError, UnknownRoomError
from app.live.live_room import LiveRoom
from app.live.open_rooms import OpenRooms
from app.persistence.leases import Leases
from app.persistence.service import PersistenceService
from app.rooms.room import Room

_ENTRY_SECONDS: Final = 2.0
"""s that drops which were taken may need to enter before a room is handed over."""

_ENTRY_POLL: Final = 0.005  # s between two polls of whether they have

_log = logging.getLogger("plinko")


class Memory(Protocol):
    """What is done with rooms in memory, by `Rooms`."""

    def add(self, room: Room) -> LiveRoom:
        """Take a room into memory."""

    def drop_from_memory(self, live: LiveRoom, error: LeaseLostError) -> None:
        """Have a room no more: it ticks no more, and all who wait for something get `error`."""

    def send_away(self, room_id: str, error: LeaseLostError) -> None:
        """Have all who watch a room look for it elsewhere."""


async def _to_nobody() -> None:
    """No server in particular is to go on with a room: the next one that is asked for it does."""


class Leaving:
    """For the event loop's thread."""

    def __init__(
        self, leases: Leases, persistence: PersistenceService, rooms: OpenRooms, memory: Memory
    ) -> None:
        self._leases = leases
        self._persistence = persistence
        self._rooms = rooms
        self._memory = memory
        self._leaving: dict[str, asyncio.Future[None]] = {}

    def check(self, room_id: str) -> None:
        """Raise LeaseLostError for a room that takes nothing more here."""
        if room_id in self._leaving:
            raise _going(room_id)

    async def until_left(self, room_id: str) -> None:
        """Return once a room that is on its way to another server is there; at once for others."""
        if room_id in self._leaving:
            await asyncio.wait([self._leaving[room_id]])

    async def hand_over(
        self,
        room_id: str,
        receive: Callable[[], Awaitable[object]] = _to_nobody,
        *,
        holder: str = "",
        address: str = "",
    ) -> None:
        """Let a room go on at another server, from the very tick at which it is here.

        What was taken enters first. Then the lease is passed on to `holder`, at `address`;
        `receive` has that server take the room, and only then are the room's clients sent there:
        they need not wait for it again and again. Raises UnknownRoomError, and LedgerError where it
        could not be told all; the room is gone from here then as well.
        """
        if room_id not in self._rooms.in_memory:
            raise UnknownRoomError(f"room {room_id!r} is not at this server", field="room")
        await to_the_end(self._hand_over(room_id, receive, holder, address))

    async def _hand_over(
        self, room_id: str, receive: Callable[[], Awaitable[object]], holder: str, address: str
    ) -> None:
        if room_id in self._leaving:
            await self.until_left(room_id)
            return
        away = LeaseLostError(f"room {room_id!r} goes on at another server", field="room")
        left = self._leaving[room_id] = asyncio.get_running_loop().create_future()
        try:
            live = self._rooms.in_memory.get(room_id)
            if live is None:
                return
            with live.taking_nothing(_going(room_id)):
                await self._settle(live)
            if live.gone is not None:
                return
            self._persistence.leave([live.room] if live.room.awake else [])
            lease = self._leases.book.drop(room_id)
            self._memory.drop_from_memory(live, away)
            if lease is not None:
                await self._leases.release(lease, holder, address)
            await receive()
        finally:
            del self._leaving[room_id]
            if room_id not in self._rooms.in_memory:
                self._memory.send_away(room_id, away)
            left.set_result(None)

    async def _settle(self, live: LiveRoom) -> None:
        """Wait until what was taken has entered; what has not is in the ledger all the same."""
        clock = asyncio.get_running_loop().time
        end = clock() + _ENTRY_SECONDS
        while clock() < end and live.gone is None and live.room.planned:
            await asyncio.sleep(_ENTRY_POLL)

    def put_away(self, room_id: str) -> None:
        """A room is another server's: nothing more is sent of it, nor written."""
        self._leases.book.drop(room_id)
        _log.warning("another server has taken a room", extra={"room": room_id})
        live = self._rooms.in_memory.get(room_id)
        if live is not None:
            away = LeaseLostError(f"room {room_id!r} is at another server now", field="room")
            self._memory.send_away(room_id, away)
            self._memory.drop_from_memory(live, away)


def _going(room_id: str) -> LeaseLostError:
    return LeaseLostError(f"room {room_id!r} is going to another server", field="room")
