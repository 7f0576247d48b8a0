"""Which servers are alive, and which of them may have a room. Decided here, without I/O.

Times are seconds of a monotonic clock, and come in as arguments.
"""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import msgspec

from app.errors import LeaseLostError
from app.rooms.records import LeaseRow

LEASE: Final = 2.0
"""s for which a server counts as alive after it last said so. Shorter, and a server that stutters
loses its rooms; longer, and the balls of one that has ended hang in the air for longer."""

BEAT: Final = 0.4
"""s between two times that a server says so: four may be lost."""

LATE: Final = 2 * BEAT
"""s that a server without a connection to PostgreSQL counts as alive. Where its process has ended
the system closes its connections at once; the rest of the lease is for one that stands still, or is
cut off, of which nothing else can be known."""


class Member(msgspec.Struct, frozen=True):
    """A server as the others know it.

    `holder` is its name in the ledger, which is new at each start; `name` is what people call it;
    `leaving` once it hands its rooms over.
    """

    holder: str
    name: str
    address: str
    leaving: bool = False


@dataclass(frozen=True, slots=True)
class Seen:
    """A server in the table of members: `age` in s since it last said that it is alive."""

    member: Member
    age: float
    connected: bool

    @property
    def alive(self) -> bool:
        """Whether its lease has not run out."""
        return self.age < (LEASE if self.connected else LATE)


class View:
    """What a server knows of the others.

    That somebody is gone is only believed once the table has been seen for a whole lease over one
    connection and without a gap: after a restart of PostgreSQL, or where this server itself was
    late, those who live need time to say so. It is the database's clock that tells.
    """

    def __init__(self) -> None:
        self.members: dict[str, Member] = {}
        self.up = False
        self._watched = 0.0  # s for which the table has been seen

    @property
    def sure(self) -> bool:
        """Whether a server that is not among the members is gone."""
        return self._watched >= LEASE

    def look(self, me: Member, found: Iterable[Seen]) -> float:
        """Take in who was found at a beat, the others as they are, `me` as it was at its last one.

        Returns how many s ago that was where this server was so late that others take it for gone;
        else 0.
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
        """The table could not be read: all stays as it was known."""
        self.up = False

    def is_gone(self, holder: str) -> bool:
        """Whether this server has ended, or its lease has run out."""
        return holder not in self.members and self.sure

    def claim(self, room_id: str, row: LeaseRow | None, me: Member) -> int:
        """The number of the lease that `me`'s is to follow; raises LeaseLostError.

        The error names the server to ask instead, if that is known. A server that leaves takes
        nothing more: a client that asks it for a free room need not wait until it is gone.
        """
        holder = "" if row is None else row.holder
        if holder in ("", me.holder) or self.is_gone(holder):
            heirs = order(room_id, self.others(me.holder)) if me.leaving else []
            if not heirs:
                return 0 if row is None else row.number
            holder = heirs[0].holder
        raise LeaseLostError(f"room {room_id!r} is at another server", field="room", holder=holder)

    def named(self, name: str) -> Member | None:
        """The server that people call so, or by its name in the ledger; never one that leaves."""
        for member in self.members.values():
            if name in (member.name, member.holder) and not member.leaving:
                return member
        return None

    def others(self, holder: str) -> list[Member]:
        """Servers that can be given rooms, but for this one."""
        return [
            each for each in self.members.values() if each.holder != holder and not each.leaving
        ]


def order(room_id: str, members: Iterable[Member]) -> list[Member]:
    """Servers in the order in which they are to have a room: by rendezvous hashing.

    Each room has an order of its own, so that the rooms of one that is gone spread over all.
    Source: Thaler and Ravishankar, IEEE/ACM Trans. Networking 6, 1 (1998).
    """

    def weight(member: Member) -> bytes:
        return hashlib.blake2b(f"{member.holder} {room_id}".encode(), digest_size=8).digest()

    return sorted(members, key=weight)


def orphans(rows: Iterable[LeaseRow], awake: Iterable[str], view: View) -> set[str]:
    """The rooms whose server is gone.

    rows: who has which room; awake: rooms in which something moves, whoever has them.
    """
    if not view.sure:
        return set()
    held = {row.room: row.holder for row in rows}
    return {room for room, holder in held.items() if view.is_gone(holder)} | {*awake} - held.keys()
