"""The rooms in memory; decides which go if there are too many.

A sleeping room that nobody uses can leave memory without loss, because the ledger has all of it.
"""

import logging
from collections import OrderedDict
from collections.abc import Callable

from plinko.app.errors import ClosedRoomError, RoomLimitError
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.public_tables import MAIN
from plinko.app.persistence.service import PersistenceService
from plinko.app.settings import Settings

UNUSED_SECONDS = 86_400.0  # without use after which a room with an owner is closed
REST_SECONDS = 3600.0
"""An unused room with an owner makes way for another only after this time: a break in a lesson."""

_IN_MEMORY = 256  # rooms; if there are more, unused ones leave
_FRESH_SECONDS = 60.0
"""A room used within this time stays in memory: its next request may be under way."""

_log = logging.getLogger("plinko")


class OpenRooms:
    """Rooms in memory by id, the longest unused first."""

    def __init__(self, settings: Settings, persistence: PersistenceService) -> None:
        self.in_memory: OrderedDict[str, LiveRoom] = OrderedDict()
        self._elsewhere = 0  # rooms with owners that are only in the ledger, or at other servers
        self._max_rooms = settings.max_rooms
        self._persistence = persistence

    def get(self, room_id: str) -> LiveRoom | None:
        """The room with this id if it is in memory; this counts as use."""
        live = self.in_memory.get(room_id)
        if live is not None:
            self.in_memory.move_to_end(room_id)
            self._persistence.touch(live.room)
        return live

    def add(self, live: LiveRoom) -> None:
        """Take a room into memory, and let unused ones leave if there are too many."""
        self.in_memory[live.id] = live
        self._persistence.touch(live.room)
        before = self._persistence.now() - _FRESH_SECONDS
        while len(self.in_memory) > _IN_MEMORY:
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
        live = self._unneeded(lambda live: self._idle(live, before))
        if live is None:
            raise RoomLimitError(f"all {self._max_rooms} rooms are in use; try again later")
        self._park(live, "room for another")

    @property
    def free(self) -> int:
        """How many more rooms players can open before one must make way."""
        return max(0, self._max_rooms - self.owned - self._elsewhere)

    @property
    def owned(self) -> int:
        return sum(live.owned for live in self.in_memory.values())

    def count(self, everywhere: int) -> None:
        """Set the number of rooms with owners in the ledger."""
        self._elsewhere = max(0, everywhere - self.owned)

    def close_idle(self) -> None:
        """Close the rooms with owners that have been unused for too long."""
        before = self._persistence.now() - UNUSED_SECONDS
        while (live := self._unneeded(lambda live: self._idle(live, before))) is not None:
            self._park(live, "unused")

    def _idle(self, live: LiveRoom, before: float) -> bool:
        return live.owned and self._last_use(live) < before

    def _last_use(self, live: LiveRoom) -> float:
        return self._persistence.runs.of(live.room).used

    def _unneeded(self, also: Callable[[LiveRoom], bool]) -> LiveRoom | None:
        """The longest unused room that may leave memory and for which `also` holds."""
        for live in self.in_memory.values():
            # Every request checks all rooms: the condition that excludes most of them comes first.
            if also(live) and not self._is_used(live):
                return live
        return None

    def _is_used(self, live: LiveRoom) -> bool:
        return live.ticks or live.busy or live.queue.running or live.id == MAIN or live.watched

    def _park(self, live: LiveRoom, closing: str = "") -> None:
        """Remove a sleeping room from memory; with a reason `closing`, close it too."""
        del self.in_memory[live.id]
        live.leave(ClosedRoomError(f"room {live.id!r} left memory because nobody used it"))
        if self._persistence.park(live.room, close=bool(closing)) and closing:
            _log.info("room closed", extra={"room": live.id, "why": closing})
        self._persistence.leases.let_go(live.id)
