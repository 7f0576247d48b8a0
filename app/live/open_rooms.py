"""The open rooms, in memory or parked in the ledger; decides which go if there are too many.

A sleeping room that nobody uses can be parked without loss: memory keeps what a list of rooms
shows, the ledger has the rest.
"""

import logging
from collections import OrderedDict
from collections.abc import Callable

from plinko.app.errors import ClosedRoomError, RoomLimitError
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.public_tables import MAIN
from plinko.app.persistence.service import PersistenceService
from plinko.app.rooms.records import Parked
from plinko.app.settings import Settings

UNUSED_SECONDS = 86_400.0  # without use after which a room with an owner is closed
REST_SECONDS = 3600.0
"""An unused room with an owner makes way for another only after this time: a break in a lesson."""

_IN_MEMORY = 256  # rooms; if there are more, unused ones are parked
_FRESH_SECONDS = 60.0
"""A room used within this time stays in memory: its next request may be under way."""

_log = logging.getLogger("plinko")


class OpenRooms:
    """Rooms by id, the longest unused first."""

    def __init__(self, settings: Settings, persistence: PersistenceService) -> None:
        self.in_memory: OrderedDict[str, LiveRoom] = OrderedDict()
        self.parked: OrderedDict[str, Parked] = OrderedDict()  # those with owners
        self.stored_public: set[str] = set()  # ids of those with an open run in the ledger
        self._elsewhere = 0  # rooms with owners at other servers
        self._max_rooms = settings.max_rooms
        self._persistence = persistence

    def __contains__(self, room_id: str) -> bool:
        """Whether a room with this id is in memory or parked."""
        return room_id in self.in_memory or room_id in self.parked

    def is_stored(self, room_id: str) -> bool:
        """Whether the room is in the ledger and not in memory."""
        return room_id in self.parked or room_id in self.stored_public

    def forget_stored(self, room_id: str) -> bool:
        """Note that a room comes into memory or is gone; returns whether it was stored."""
        was = self.is_stored(room_id)
        self.parked.pop(room_id, None)
        self.stored_public.discard(room_id)
        return was

    def get(self, room_id: str) -> LiveRoom | None:
        """The room with this id if it is in memory; this counts as use."""
        live = self.in_memory.get(room_id)
        if live is not None:
            self.in_memory.move_to_end(room_id)
            self._persistence.touch(live.room)
        return live

    def add(self, live: LiveRoom) -> None:
        """Take a room into memory, and park unused ones if there are too many."""
        self.in_memory[live.id] = live
        self._persistence.touch(live.room)
        before = self._persistence.now() - _FRESH_SECONDS
        while self._persistence.ledger.keeps and len(self.in_memory) > _IN_MEMORY:
            unused = self._unneeded(lambda live: self._last_use(live) < before)
            if unused is None:
                break
            self._park(unused)

    def make_place(self) -> None:
        """Close the longest unused room with an owner if there are too many.

        Raises RoomLimitError if all of them were used recently.
        """
        self.close_idle()
        if self.free > 0:
            return
        before = self._persistence.now() - REST_SECONDS
        parked = self._unused_parked(before)
        if parked is not None:
            self._end(self.parked.pop(parked.id), "room for another")
            return
        live = self._unneeded(lambda live: self._idle(live, before))
        if live is None:
            raise RoomLimitError(f"all {self._max_rooms} rooms are in use; try again later")
        self._retire(live, "room for another")

    @property
    def free(self) -> int:
        """How many more rooms players can open before one must make way."""
        return max(0, self._max_rooms - self.owned - len(self.parked) - self._elsewhere)

    @property
    def owned(self) -> int:
        return sum(live.owned for live in self.in_memory.values())

    def count(self, everywhere: int) -> None:
        """Set the number of rooms with owners at all servers that share the ledger."""
        self._elsewhere = max(0, everywhere - self.owned)

    def close_idle(self) -> None:
        """Close the rooms with owners that have been unused for too long."""
        before = self._persistence.now() - UNUSED_SECONDS
        while (parked := self._unused_parked(before)) is not None:
            self._end(self.parked.pop(parked.id), "unused")
        while (live := self._unneeded(lambda live: self._idle(live, before))) is not None:
            self._retire(live, "unused")

    def _unused_parked(self, before: float) -> Parked | None:
        """The longest unused room that is parked; not one whose balls have yet to get results."""
        for room in self.parked.values():
            if room.used >= before:
                return None
            if not room.awake:
                return room
        return None

    def _idle(self, live: LiveRoom, before: float) -> bool:
        return live.owned and self._last_use(live) < before

    def _last_use(self, live: LiveRoom) -> float:
        return self._persistence.runs.of(live.room).used

    def _unneeded(self, also: Callable[[LiveRoom], bool]) -> LiveRoom | None:
        """The longest unused room that can be parked and for which `also` holds."""
        for live in self.in_memory.values():
            # Every request checks all rooms: the condition that excludes most of them comes first.
            if also(live) and self._persistence.parkable(live.room) and not self._is_used(live):
                return live
        return None

    def _is_used(self, live: LiveRoom) -> bool:
        return live.ticks or live.busy or live.queue.running or live.id == MAIN or live.watched

    def _park(self, live: LiveRoom, closing: str = "") -> None:
        """Remove a sleeping room from memory; with a reason `closing`, close it if it has an owner.

        If several servers share the ledger, this server does not list it as parked: any of them may
        take it.
        """
        room, owned = live.room, live.owned
        leases = self._persistence.leases
        del self.in_memory[room.id]
        live.leave(ClosedRoomError(f"room {room.id!r} left memory because nobody used it"))
        row = self._persistence.park(room)
        if row is not None and owned:
            parked = Parked.of(row, room.origin.name)
            if closing:
                self._end(parked, closing)
            elif leases is None:
                self.parked[room.id] = parked
        elif row is not None and leases is None:
            self.stored_public.add(room.id)
        if leases is not None:
            leases.let_go(room.id)

    def _retire(self, live: LiveRoom, why: str) -> None:
        """Close a room with an owner; park a public one, which reopens on request."""
        self._park(live, why)

    def _end(self, room: Parked, why: str) -> None:
        self._persistence.close(room)
        _log.info("room closed", extra={"room": room.id, "why": why})
