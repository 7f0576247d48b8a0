"""The open rooms, in memory or parked in the ledger, and which go when there are too many.

A room that sleeps and that nobody needs now can be had again without loss: memory keeps what a
list shows of it, the ledger the rest.
"""

import logging
from collections import OrderedDict
from collections.abc import Callable

from app.errors import ClosedRoomError, RoomLimitError
from app.live.live_room import LiveRoom
from app.live.public_tables import MAIN
from app.persistence.service import PersistenceService
from app.rooms.records import Parked, RoomRow
from app.settings import Settings

UNUSED_SECONDS = 86_400.0  # after which an unused room of a player's own is closed
REST_SECONDS = 3600.0
"""for which an unused room of a player's own makes way for no other: a break in a lesson."""

_IN_MEMORY = 256  # rooms; beyond that, those that nobody needs now are parked

_log = logging.getLogger("plinko")


class OpenRooms:
    """Rooms by id, the longest unused first."""

    def __init__(self, settings: Settings, persistence: PersistenceService) -> None:
        self.in_memory: OrderedDict[str, LiveRoom] = OrderedDict()
        self.parked: OrderedDict[str, Parked] = OrderedDict()  # those with owners
        self.parked_public: dict[str, RoomRow] = {}
        self._elsewhere = 0  # players' rooms that are not here
        self._max_rooms = settings.max_rooms
        self._persistence = persistence

    def __contains__(self, room_id: str) -> bool:
        """Whether there is a room of this id, in memory or parked."""
        return room_id in self.in_memory or room_id in self.parked

    def get(self, room_id: str) -> LiveRoom | None:
        """The room of this id if it is in memory; it counts as used."""
        live = self.in_memory.get(room_id)
        if live is not None:
            self.in_memory.move_to_end(room_id)
            self._persistence.touch(live.room)
        return live

    def add(self, live: LiveRoom) -> None:
        """Take a room into memory; park another if that makes too many."""
        self.in_memory[live.id] = live
        self._persistence.touch(live.room)
        if self._persistence.ledger.keeps and len(self.in_memory) > _IN_MEMORY:
            unneeded = self._unneeded(lambda other: other is not live)
            if unneeded is not None:
                self._park(unneeded)

    def make_place(self) -> None:
        """Close the longest unused room if players have too many; raises RoomLimitError.

        A room that was used lately stays, however many would take its place.
        """
        self.close_idle()
        if self.free > 0:
            return
        before = self._persistence.now() - REST_SECONDS
        if self.parked and next(iter(self.parked.values())).used < before:
            self._end(self.parked.popitem(last=False)[1], "room for another")
            return
        live = self._unneeded(lambda live: self._idle(live, before))
        if live is None:
            raise RoomLimitError(f"all {self._max_rooms} rooms are in use")
        self._retire(live, "room for another")

    @property
    def free(self) -> int:
        """How many more rooms players may open before one must make way."""
        return max(0, self._max_rooms - self.owned - len(self.parked) - self._elsewhere)

    @property
    def owned(self) -> int:
        return sum(live.owned for live in self.in_memory.values())

    def count(self, everywhere: int) -> None:
        """So many rooms are players' own, at all servers that share the ledger."""
        self._elsewhere = max(0, everywhere - self.owned)

    def close_idle(self) -> None:
        """Close the rooms with owners that nobody has used for too long."""
        before = self._persistence.now() - UNUSED_SECONDS
        while self.parked and next(iter(self.parked.values())).used < before:
            self._end(self.parked.popitem(last=False)[1], "unused")
        while (live := self._unneeded(lambda live: self._idle(live, before))) is not None:
            self._retire(live, "unused")

    def _idle(self, live: LiveRoom, before: float) -> bool:
        record = self._persistence.runs.of(live.room)
        return record.owned and record.used < before

    def _unneeded(self, also: Callable[[LiveRoom], bool]) -> LiveRoom | None:
        """The longest unused room that can be had again without loss, of those that fit."""
        for live in self.in_memory.values():
            # Every request asks this, of all rooms: what tells most of them apart comes first.
            if also(live) and self._persistence.parkable(live.room) and not self._is_used(live):
                return live
        return None

    def _is_used(self, live: LiveRoom) -> bool:
        return (
            live.ticks
            or bool(live.room.planned)
            or live.queue.running
            or live.id == MAIN
            or live.watched
        )

    def _park(self, live: LiveRoom, closing: str = "") -> None:
        """Let the ledger have a sleeping room; one with an owner is closed where there is a why.

        Where several servers share the ledger nothing is parked here: the room is any server's.
        """
        room, owned = live.room, live.owned
        leases = self._persistence.leases
        del self.in_memory[room.id]
        live.leave(ClosedRoomError(f"room {room.id!r} was put away, as nobody used it"))
        row = self._persistence.park(room)
        if row is not None and owned:
            parked = Parked.of(row, room.origin.name)
            if closing:
                self._end(parked, closing)
            elif leases is None:
                self.parked[room.id] = parked
        elif row is not None and leases is None:
            self.parked_public[room.id] = row
        if leases is not None:
            leases.let_go(room.id)

    def _retire(self, live: LiveRoom, why: str) -> None:
        """Close a room with an owner; park one without, as it opens again when asked for."""
        self._park(live, why)

    def _end(self, room: Parked, why: str) -> None:
        self._persistence.close(room)
        _log.info("room closed", extra={"room": room.id, "why": why})
