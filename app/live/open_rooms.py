"""The rooms in memory; decides which leave.

A sleeping room that nobody uses can leave memory without loss, because the ledger has all of it.
"""

import asyncio
import functools
import logging
from collections import OrderedDict

from plinko.app.errors import AppError, ClosedRoomError, LeaseLostError
from plinko.app.live.live_arena import LiveArena
from plinko.app.live.live_room import LiveRoom, RoomContext
from plinko.app.live.live_table import LiveTable
from plinko.app.live.public_tables import MAIN
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.kinds import make_room
from plinko.app.rooms.room import Basis, Room
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.settings import TICK_RATE

_IN_MEMORY = 256  # rooms; if there are more, unused ones leave
_FRESH_SECONDS = 60.0
"""A room used within this time stays in memory: its next request may be under way."""

_log = logging.getLogger("plinko")


class OpenRooms:
    """Rooms in memory by id, the longest unused first."""

    def __init__(self, context: RoomContext) -> None:
        self.in_memory: OrderedDict[str, LiveRoom] = OrderedDict()
        self._context = context
        self._persistence = context.persistence

    def get(self, room_id: str) -> LiveRoom | None:
        """The room with this id if it is in memory; this counts as use."""
        live = self.in_memory.get(room_id)
        if live is not None:
            self.in_memory.move_to_end(room_id)
            self._persistence.touch(live.room)
        return live

    async def make(self, room_id: str, basis: Basis, mode: str) -> Room:
        """A room at tick 0, made on a thread: 500 balls, or a large board, take some 5 ms."""
        limits = self._persistence.limits
        make = functools.partial(make_room, tick_rate=TICK_RATE, limits=limits)
        return await asyncio.to_thread(make, room_id, basis, mode)

    def add(self, room: Room) -> LiveRoom:
        """Take a room into memory, and let it tick if anything moves.

        If there are too many, unused ones leave.
        """
        live: LiveRoom
        if isinstance(room, IndependentRoom):
            live = LiveTable(room, self._context)
        else:
            assert isinstance(room, TouchingRoom)
            live = LiveArena(room, self._context)
        self.in_memory[live.id] = live
        self._persistence.touch(live.room)
        self.park_unused(_FRESH_SECONDS, len(self.in_memory) - _IN_MEMORY)
        _log.info("room opened", extra={"room": room.id, "board": room.origin.digest})
        return live

    def remove(self, live: LiveRoom, error: AppError) -> None:
        """Remove a room: it stops ticking, and callers that wait get `error`."""
        del self.in_memory[live.id]
        live.leave(error)

    def give_up(self, live: LiveRoom, error: LeaseLostError) -> None:
        """Remove a room that now belongs to another server."""
        live.landings.leave()
        self.remove(live, error)
        self._persistence.runs.forget(live.room)

    def send_away(self, room_id: str, error: LeaseLostError) -> None:
        """Cut off a room's clients at once; they reconnect to the room's new server."""
        self._context.audiences.hub.cut(room_id, error)

    def park_unused(self, seconds: float, most: int) -> None:
        """Let at most `most` rooms leave memory that have been unused for so long."""
        if most <= 0:
            return
        before, runs = self._persistence.now() - seconds, self._persistence.runs
        unused = (live for live in self.in_memory.values() if runs.of(live.room).used < before)
        for live in [live for live in unused if not self.is_used(live)][:most]:
            why = f"room {live.id!r} left memory because nobody used it"
            self.remove(live, ClosedRoomError(why))
            self._persistence.park(live.room)

    def is_used(self, live: LiveRoom) -> bool:
        """Whether a room must stay in memory."""
        return live.ticks or live.busy or live.queue.running or live.id == MAIN or live.watched
