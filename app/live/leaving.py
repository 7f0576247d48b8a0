"""Gives rooms of this server up, where several servers share a ledger.

A handover is orderly: everything is committed, and another server continues the room.
A room that another server has taken is removed at once.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Final

from plinko.app.concurrency.single_flight import to_the_end
from plinko.app.errors import LeaseLostError, UnknownRoomError
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.open_rooms import OpenRooms
from plinko.app.persistence.service import PersistenceService

_ENTRY_SECONDS: Final = 2.0
"""s that drops on their way may take to enter before a room is handed over."""

_ENTRY_POLL: Final = 0.005  # s between two checks whether they have entered

_log = logging.getLogger("plinko")


async def _to_nobody() -> None:
    """Hand over to no particular server: the next one that a client asks takes the room."""


class Leaving:
    """For the event loop's thread."""

    def __init__(self, persistence: PersistenceService, rooms: OpenRooms) -> None:
        self._leases = persistence.leases
        self._persistence = persistence
        self._rooms = rooms
        self._leaving: dict[str, asyncio.Future[None]] = {}

    def check(self, room_id: str) -> None:
        """Raise LeaseLostError for a room that is being handed over."""
        if room_id in self._leaving:
            raise _going(room_id)

    async def until_left(self, room_id: str) -> None:
        """Wait until the handover of a room, if any, has finished."""
        if room_id in self._leaving:
            await asyncio.wait([self._leaving[room_id]])

    async def migrate(
        self,
        room_id: str,
        receive: Callable[[], Awaitable[object]] = _to_nobody,
        *,
        holder: str = "",
        address: str = "",
    ) -> None:
        """Hand a room over to another server, which continues it.

        First the drops on their way enter. Then the lease goes to `holder`, at `address`, and
        `receive` makes that server take the room. Only then are the room's clients sent there, so
        that they find it ready. Raises UnknownRoomError, and LedgerError if the room could not be
        committed completely; even then this server has given the room up.
        """
        if room_id not in self._rooms.in_memory:
            raise UnknownRoomError(f"room {room_id!r} is not at this server", field="room")
        await to_the_end(self._migrate(room_id, receive, holder, address))

    async def _migrate(
        self, room_id: str, receive: Callable[[], Awaitable[object]], holder: str, address: str
    ) -> None:
        if room_id in self._leaving:
            await self.until_left(room_id)
            return
        away = LeaseLostError(f"room {room_id!r} has moved to another server", field="room")
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
            self._rooms.give_up(live, away)
            if lease is not None:
                await self._leases.release(lease, holder, address)
            await receive()
        finally:
            del self._leaving[room_id]
            if room_id not in self._rooms.in_memory:
                self._rooms.send_away(room_id, away)
            left.set_result(None)

    async def _settle(self, live: LiveRoom) -> None:
        """Wait until the drops on their way have entered; the ledger has those that have not."""
        clock = asyncio.get_running_loop().time
        end = clock() + _ENTRY_SECONDS
        while clock() < end and live.gone is None and live.busy:
            await asyncio.sleep(_ENTRY_POLL)

    def put_away(self, room_id: str) -> None:
        """Remove a room that another server has taken; nothing more of it is sent or written."""
        self._leases.book.drop(room_id)
        _log.warning("another server has taken a room", extra={"room": room_id})
        live = self._rooms.in_memory.get(room_id)
        if live is not None:
            away = LeaseLostError(f"room {room_id!r} is at another server now", field="room")
            self._rooms.send_away(room_id, away)
            self._rooms.give_up(live, away)


def _going(room_id: str) -> LeaseLostError:
    return LeaseLostError(f"room {room_id!r} is moving to another server", field="room")
