"""The rooms in memory; decides which leave.

A sleeping room that nobody uses can leave memory without loss, because the ledger has all of it.
"""

from collections import OrderedDict

from plinko.app.errors import ClosedRoomError
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.public_tables import MAIN
from plinko.app.persistence.service import PersistenceService

_IN_MEMORY = 256  # rooms; if there are more, unused ones leave
_FRESH_SECONDS = 60.0
"""A room used within this time stays in memory: its next request may be under way."""


class OpenRooms:
    """Rooms in memory by id, the longest unused first."""

    def __init__(self, persistence: PersistenceService) -> None:
        self.in_memory: OrderedDict[str, LiveRoom] = OrderedDict()
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
        self.park_unused(_FRESH_SECONDS, len(self.in_memory) - _IN_MEMORY)

    def park_unused(self, seconds: float, most: int) -> None:
        """Let at most `most` rooms leave memory that have been unused for so long."""
        if most <= 0:
            return
        before, runs = self._persistence.now() - seconds, self._persistence.runs
        unused = (live for live in self.in_memory.values() if runs.of(live.room).used < before)
        for live in [live for live in unused if not self.is_used(live)][:most]:
            del self.in_memory[live.id]
            live.leave(ClosedRoomError(f"room {live.id!r} left memory because nobody used it"))
            self._persistence.park(live.room)

    def is_used(self, live: LiveRoom) -> bool:
        """Whether a room must stay in memory."""
        return live.ticks or live.busy or live.queue.running or live.id == MAIN or live.watched
