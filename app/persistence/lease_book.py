"""The leases that this server has of rooms, and under which of them each write is made. No I/O.

A room is one server's at a time. Taking it gives a number that only grows; each write of the room
is stamped with that number when it is handed to the ledger, and the ledger makes it only while it
has the same number. A server that was frozen while another took its room can thus write nothing of
it any more, however late it wakes up.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from app.rooms.records import FairEnd, FairOpening, FairSessionRow, Lease, RoomRow, Write

Part = tuple[Lease | None, Sequence[Write]]
"""Writes that are made under a lease of their room; None: they are of no room."""

_NOBODY: Final = Lease("", 0)
"""The lease of a room that this server does not have: the ledger never has it."""


class Unshared:
    """Stands for a `LeaseBook` where one server has the ledger alone: all rooms are its own."""

    def stamp(self, writes: Sequence[Write]) -> list[Part]:
        """All writes, under no lease."""
        return [(None, writes)]

    def lost(self, leases: Sequence[Lease]) -> None:
        """Never called: nothing is written under a lease."""


@dataclass(slots=True, eq=False)
class Entry:
    """A lease that this server has.

    `lost` is called with the room's id when the ledger refuses a write under it. `runs` are the
    numbers of the room's runs. `confirmed` is when it was last seen to be this server's still, in
    s of the loop's clock.
    """

    lease: Lease
    lost: Callable[[str], None]
    runs: set[int] = field(default_factory=set)
    confirmed: float = -math.inf


class LeaseBook:
    """For the event loop's thread.

    `holder` is this server's name in the ledger, which no other server has; `address` is where the
    other servers reach it.
    """

    def __init__(self, holder: str, address: str = "") -> None:
        self.holder = holder
        self.address = address
        self._entries: dict[str, Entry] = {}
        self._room_of: dict[int, str] = {}  # by the number of a run

    @property
    def rooms(self) -> list[str]:
        """The ids of the rooms that this server has."""
        return list(self._entries)

    def of(self, room_id: str) -> Lease | None:
        """The lease of a room; None where it is not this server's."""
        entry = self.entry(room_id)
        return None if entry is None else entry.lease

    def entry(self, room_id: str) -> Entry | None:
        """What is known of a room's lease; None where it is not this server's."""
        return self._entries.get(room_id)

    def add(self, lease: Lease, lost: Callable[[str], None]) -> None:
        """The room is this server's from now on."""
        self.drop(lease.room)
        self._entries[lease.room] = Entry(lease, lost)

    def drop(self, room_id: str) -> Lease | None:
        """The room is not this server's any more; returns the lease that there was."""
        entry = self._entries.pop(room_id, None)
        if entry is None:
            return None
        for run in entry.runs:
            self._room_of.pop(run, None)
        return entry.lease

    def note(self, run: int, room_id: str) -> None:
        """What is written of the run of this number is of this room."""
        entry = self.entry(room_id)
        if entry is not None:
            entry.runs.add(run)
            self._room_of[run] = room_id

    # For the ledger.

    def stamp(self, writes: Sequence[Write]) -> list[Part]:
        """The writes by the lease that they are made under; first those of no room, under None."""
        parts: dict[Lease | None, list[Write]] = {None: []}
        for write in writes:
            parts.setdefault(self._lease_of(write), []).append(write)
        if not parts[None]:
            del parts[None]
        return list(parts.items())

    def lost(self, leases: Sequence[Lease]) -> None:
        """The ledger has refused what was written under these."""
        for lease in leases:
            entry = self.entry(lease.room)
            if entry is not None and entry.lease == lease:
                self.drop(lease.room)
                entry.lost(lease.room)

    def _lease_of(self, write: Write) -> Lease | None:
        room_id = self._room_id(write)
        return None if room_id is None else self.of(room_id) or _NOBODY

    def _room_id(self, write: Write) -> str | None:
        """The room that a write is of; None where it is of none, or of all."""
        if isinstance(write, RoomRow):
            return write.id
        room: int | str | None = getattr(write, "room", None)
        if isinstance(room, int):
            return self._room_of.get(room, "")
        return room if isinstance(write, FairSessionRow | FairOpening | FairEnd) else None
