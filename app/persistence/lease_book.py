"""The room leases of this server, and the lease under which each write is made. No I/O.

A room belongs to one server at a time. Each lease of it has a fencing number, higher than all
before. A write is stamped with the number when it is handed to the ledger, and the ledger refuses
it if the room's number has changed since. So a server that was frozen while another took its room
can no longer write to that room, however late it wakes up.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from plinko.app.rooms.records import (
    FairEnd,
    FairOpening,
    FairSessionRow,
    Lease,
    RoomRow,
    ShowRow,
    Write,
)

Part = tuple[Lease | None, Sequence[Write]]
"""Writes with the lease of their room; None for writes that belong to no room."""

_BY_ID: Final = FairSessionRow | FairOpening | FairEnd | ShowRow
"""Writes whose `room` is the room's id."""

_NO_LEASE: Final = Lease("", 0)
"""Stamps writes to a room that this server does not have: no room has it, so they are refused."""


@dataclass(slots=True, eq=False)
class Entry:
    """A lease that this server has.

    `lost` is called with the room's id when the ledger refuses a write under the lease. `runs` are
    the numbers of the room's runs. `confirmed` is when the ledger last confirmed the lease, in s of
    the event loop's clock.
    """

    lease: Lease
    lost: Callable[[str], None]
    runs: set[int] = field(default_factory=set)
    confirmed: float = -math.inf


class LeaseBook:
    """For the event loop's thread.

    `holder` is this server's unique name in the ledger; `address` is where other servers reach it.
    Without a name, the server has the ledger for itself: it has no leases, and no write needs one.
    """

    def __init__(self, holder: str = "", address: str = "") -> None:
        self.holder = holder
        self.address = address
        self._entries: dict[str, Entry] = {}
        self._room_of: dict[int, str] = {}  # by the run's number

    @property
    def alone(self) -> bool:
        """Whether no other server uses the ledger."""
        return not self.holder

    @property
    def rooms(self) -> list[str]:
        return list(self._entries)

    def of(self, room_id: str) -> Lease | None:
        entry = self.entry(room_id)
        return None if entry is None else entry.lease

    def entry(self, room_id: str) -> Entry | None:
        return self._entries.get(room_id)

    def add(self, lease: Lease, lost: Callable[[str], None]) -> None:
        """Enter a lease that this server has taken."""
        self.drop(lease.room)
        self._entries[lease.room] = Entry(lease, lost)

    def drop(self, room_id: str) -> Lease | None:
        """Remove and return the lease of a room, if this server has it."""
        entry = self._entries.pop(room_id, None)
        if entry is None:
            return None
        for run in entry.runs:
            self._room_of.pop(run, None)
        return entry.lease

    def note(self, run: int, room_id: str) -> None:
        entry = self.entry(room_id)
        if entry is not None:
            entry.runs.add(run)
            self._room_of[run] = room_id

    # For the ledger.

    def stamp(self, writes: Sequence[Write]) -> list[Part]:
        """Group writes by the lease of their room; those of no room come first, under None."""
        if self.alone:
            return [(None, writes)]
        parts: dict[Lease | None, list[Write]] = {None: []}
        for write in writes:
            parts.setdefault(self._lease_of(write), []).append(write)
        if not parts[None]:
            del parts[None]
        return list(parts.items())

    def lost(self, leases: Sequence[Lease]) -> None:
        """Drop leases under which the ledger has refused a write, and report each as lost."""
        for lease in leases:
            entry = self.entry(lease.room)
            if entry is not None and entry.lease == lease:
                self.drop(lease.room)
                entry.lost(lease.room)

    def _lease_of(self, write: Write) -> Lease | None:
        room_id = self._room_id(write)
        return None if room_id is None else self.of(room_id) or _NO_LEASE

    def _room_id(self, write: Write) -> str | None:
        """The room of a write; None if it concerns no single room."""
        if isinstance(write, RoomRow):
            return write.id
        room: int | str | None = getattr(write, "room", None)
        if isinstance(room, int):
            return self._room_of.get(room, "")
        return room if isinstance(write, _BY_ID) else None
