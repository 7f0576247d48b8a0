"""Decides which servers are alive, and which of them may have a room. No I/O.

Ages are in seconds and come in as arguments.
"""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import msgspec

from plinko.app.errors import LeaseLostError
from plinko.app.rooms.records import LeaseRow

LEASE: Final = 2.0
"""Seconds after its last heartbeat for which a server counts as alive. If this is too short, a
server that stutters loses its rooms; the longer it is, the longer the balls of a failed server
stand still."""

HEARTBEAT: Final = 0.4
"""Seconds between two heartbeats of a server: four in a row may be lost."""

LATE: Final = 2 * HEARTBEAT
"""Seconds after its last heartbeat for which a server without a connection to PostgreSQL counts as
alive. When a process ends, its system closes its connections at once, so its rooms need not wait
for LEASE. A server that is frozen or cut off keeps its connection, and only LEASE detects it."""


class Member(msgspec.Struct, frozen=True):
    """A server as the others know it.

    `holder` is its name in the ledger, which is new at each start; `name` is its name for people;
    `leaving` is true while it hands its rooms over.
    """

    holder: str
    name: str
    address: str
    leaving: bool = False


@dataclass(frozen=True, slots=True)
class Seen:
    """A server in the heartbeat table: `age` is the time since its last heartbeat in s."""

    member: Member
    age: float
    connected: bool

    @property
    def alive(self) -> bool:
        """Whether the last heartbeat is recent enough."""
        return self.age < (LEASE if self.connected else LATE)


class View:
    """The servers that this server considers alive.

    It considers a server failed only after it has read the table without a gap for a whole LEASE:
    after a restart of PostgreSQL, or when this server itself was late, live servers need that time
    to write a heartbeat. The database's clock measures it.
    """

    def __init__(self) -> None:
        self.members: dict[str, Member] = {}
        self.up = False
        self._watched = 0.0  # s for which the table has been read without a gap

    @property
    def sure(self) -> bool:
        """Whether a server that is missing from the members has failed."""
        return self._watched >= LEASE

    def look(self, me: Member, found: Iterable[Seen]) -> float:
        """Take in the servers found by a heartbeat, with `me` as of its previous heartbeat.

        Returns 0, or the seconds since that previous heartbeat if the others may have considered
        this server failed.
        """
        seen = {each.member.holder: each for each in found}
        since = seen[me.holder].age if me.holder in seen else LEASE
        went_on = self.up and since < LEASE
        self._watched = self._watched + since if went_on else 0.0
        alive = {holder: each.member for holder, each in seen.items() if each.alive}
        self.members = (alive if self.sure else self.members | alive) | {me.holder: me}
        late = self.up and not went_on
        self.up = True
        return since if late else 0.0

    def failed(self) -> None:
        """Note that the table could not be read. The members stay."""
        self.up = False

    def is_gone(self, holder: str) -> bool:
        """Whether this server has ended, or its lease has run out."""
        return holder not in self.members and self.sure

    def claim(self, room_id: str, row: LeaseRow | None, me: Member) -> int:
        """The number of the lease that the lease of `me` replaces; raises LeaseLostError.

        The error names the server that has the room. A server that leaves takes no more rooms: for
        a free room, the error names the server that should take it.
        """
        holder = "" if row is None else row.holder
        if holder in ("", me.holder) or self.is_gone(holder):
            heirs = order(room_id, self.others(me.holder)) if me.leaving else []
            if not heirs:
                return 0 if row is None else row.number
            holder = heirs[0].holder
        raise LeaseLostError(f"room {room_id!r} is at another server", field="room", holder=holder)

    @property
    def takers(self) -> list[Member]:
        """The servers that can take rooms: all that do not leave."""
        return [each for each in self.members.values() if not each.leaving]

    def named(self, name: str) -> Member | None:
        """The server with this name or holder that can take rooms."""
        return next((each for each in self.takers if name in (each.name, each.holder)), None)

    def others(self, holder: str) -> list[Member]:
        """The servers other than `holder` that can take rooms."""
        return [each for each in self.takers if each.holder != holder]


def order(room_id: str, members: Iterable[Member]) -> list[Member]:
    """The servers in the order in which they should take a room, by rendezvous hashing.

    Each room has a different order, so the rooms of a failed server spread over all others.
    Source: Thaler and Ravishankar, IEEE/ACM Trans. Networking 6, 1 (1998).
    """

    def weight(member: Member) -> bytes:
        return hashlib.blake2b(f"{member.holder} {room_id}".encode(), digest_size=8).digest()

    return sorted(members, key=weight)


def orphans(rows: Iterable[LeaseRow], awake: Iterable[str], view: View) -> set[str]:
    """The rooms whose server has failed, and awake rooms that have no server.

    rows: each room's lease; awake: all rooms in which something moves.
    """
    if not view.sure:
        return set()
    held = {row.room: row.holder for row in rows}
    return {room for room, holder in held.items() if view.is_gone(holder)} | {*awake} - held.keys()
