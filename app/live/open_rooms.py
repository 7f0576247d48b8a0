"""The open rooms, in memory or parked in the ledger, and which go when there are too many.

A room that sleeps and that nobody needs now can be had again without loss: memory keeps what a
list shows of it, the ledger the rest.
"""

import functools
import logging
from collections import OrderedDict
from collections.abc import Callable

from app.errors import RoomLimitError
from app.persistence.service import PersistenceService
from app.rooms.records import Parked, RoomRow
from app.rooms.room import Room
from app.settings import Settings

_IN_MEMORY = 256  # rooms; beyond that, those that nobody needs now are parked

_log = logging.getLogger("plinko")


class OpenRooms:
    """Rooms by id, the longest unused first.

    `runs` says whether a room ticks, `needed` whether somebody needs one that does not now;
    `forget` hears of one that leaves the memory.
    """

    def __init__(
        self,
        settings: Settings,
        persistence: PersistenceService,
        *,
        runs: Callable[[Room], bool],
        needed: Callable[[Room], bool],
        forget: Callable[[str], None],
    ) -> None:
        self.in_memory: OrderedDict[str, Room] = OrderedDict()
        self.parked: OrderedDict[str, Parked] = OrderedDict()  # those with owners
        self.parked_public: dict[str, RoomRow] = {}
        # Where several servers share the ledger nothing is parked: whoever leaves the memory is
        # any server's, and `left` hears of it. `elsewhere` counts players' rooms that are not here.
        self.left: Callable[[str], None] | None = None
        self.elsewhere = 0
        self._max_rooms = settings.max_rooms
        self._idle_seconds = settings.room_idle
        self._rest_seconds = settings.room_rest
        self._persistence = persistence
        self._runs = runs
        self._needed = needed
        self._forget = forget

    def __contains__(self, room_id: str) -> bool:
        """Whether there is a room of this id, in memory or parked."""
        return room_id in self.in_memory or room_id in self.parked

    def get(self, room_id: str) -> Room | None:
        """The room of this id if it is in memory; it counts as used."""
        room = self.in_memory.get(room_id)
        if room is not None:
            self.in_memory.move_to_end(room_id)
            self._persistence.touch(room)
        return room

    def add(self, room: Room) -> None:
        """Take a room into memory; park another if that makes too many."""
        self.in_memory[room.id] = room
        self._persistence.touch(room)
        if self._persistence.ledger.keeps and len(self.in_memory) > _IN_MEMORY:
            unneeded = self._unneeded(lambda other: other is not room)
            if unneeded is not None:
                self._park(unneeded)

    def make_place(self) -> None:
        """Close the longest unused room if players have too many; raises RoomLimitError.

        A room that was used lately stays, however many would take its place.
        """
        self.close_idle()
        if self.free > 0:
            return
        before = self._persistence.now() - self._rest_seconds
        if self.parked and next(iter(self.parked.values())).used < before:
            self._end(self.parked.popitem(last=False)[1], "room for another")
            return
        room = self._unneeded(functools.partial(self._idle, before))
        if room is None:
            raise RoomLimitError(f"all {self._max_rooms} rooms are in use")
        self._retire(room, "room for another")

    @property
    def free(self) -> int:
        """How many more rooms players may open before one must make way."""
        return max(0, self._max_rooms - self.owned - len(self.parked) - self.elsewhere)

    @property
    def owned(self) -> int:
        """How many rooms in memory are players' own."""
        return sum(map(self._owned, self.in_memory.values()))

    def close_idle(self) -> None:
        """Close the rooms with owners that nobody has used for too long."""
        before = self._persistence.now() - self._idle_seconds
        while self.parked and next(iter(self.parked.values())).used < before:
            self._end(self.parked.popitem(last=False)[1], "unused")
        while (room := self._unneeded(functools.partial(self._idle, before))) is not None:
            self._retire(room, "unused")

    def _idle(self, before: float, room: Room) -> bool:
        record = self._persistence.runs.of(room)
        return record.owned and record.used < before

    def _owned(self, room: Room) -> bool:
        return self._persistence.runs.of(room).owned

    def _unneeded(self, also: Callable[[Room], bool]) -> Room | None:
        """The longest unused room that can be had again without loss, of those that fit."""
        for room in self.in_memory.values():
            # Every request asks this, of all rooms: what tells most of them apart comes first.
            if also(room) and self._persistence.parkable(room) and not self._is_used(room):
                return room
        return None

    def _is_used(self, room: Room) -> bool:
        return self._runs(room) or bool(room.planned) or self._needed(room)

    def _park(self, room: Room, closing: str = "") -> None:
        """Let the ledger have a sleeping room; one with an owner is closed where there is a why."""
        del self.in_memory[room.id]
        self._forget(room.id)
        owned = self._owned(room)
        row = self._persistence.park(room)
        if row is not None and owned:
            parked = Parked.of(row, room.origin.name)
            if closing:
                self._end(parked, closing)
            elif self.left is None:
                self.parked[room.id] = parked
        elif row is not None and self.left is None:
            self.parked_public[room.id] = row
        if self.left is not None:
            self.left(room.id)

    def _retire(self, room: Room, why: str) -> None:
        """Close a room with an owner; park one without, as it opens again when asked for."""
        self._park(room, why)

    def _end(self, room: Parked, why: str) -> None:
        self._persistence.close(room)
        _log.info("room closed", extra={"room": room.id, "why": why})
