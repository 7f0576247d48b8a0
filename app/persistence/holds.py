"""The rooms that this server has, where several share one ledger, and whose every write says so.

A room is one server's at a time. Taking it gives a number that only grows; each write of the room
is stamped with that number when it is handed to the ledger, and the ledger makes it only while it
has the same number. A server that was frozen while another took its room can thus write nothing of
it any more, however late it wakes up.
"""

import asyncio
import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from app.errors import HoldLostError, LedgerError
from app.persistence.ledger.writer import Ledger, Part
from app.persistence.statements import hold_store
from app.rooms.records import (
    FairEnd,
    FairOpening,
    FairSessionRow,
    Hold,
    HoldRow,
    RoomRow,
    Write,
)

_PATIENCE: Final = (
    10.0  # s for which the former holder's transaction may last; the database ends it
)
_PAUSE: Final = 0.05  # s until it is looked at again

_log = logging.getLogger("plinko")


@dataclass(slots=True)
class _Held:
    """A room that this server has, and the numbers of its sessions that it writes of."""

    hold: Hold
    sessions: set[int] = field(default_factory=set)


class Holds:
    """For the event loop's thread. `holder` is this server's name, which no other server has.

    `address` is where the other servers reach it; `now` gives Unix time in seconds. `lost` hears
    of a room that the ledger says is another's now.
    """

    def __init__(
        self,
        ledger: Ledger,
        holder: str,
        address: str = "",
        *,
        now: Callable[[], float] = time.time,
    ) -> None:
        self.holder = holder
        self.address = address
        self.lost: Callable[[str], None] = lambda room_id: None
        self._ledger = ledger
        self._now = now
        self._rooms: dict[str, _Held] = {}
        self._room_of: dict[int, str] = {}  # by the number of a session
        ledger.stamp = self.stamp
        ledger.on_lost = self._lost

    @property
    def rooms(self) -> list[str]:
        """The ids of the rooms that this server has."""
        return list(self._rooms)

    def of(self, room_id: str) -> Hold | None:
        """The hold of a room; None where it is not this server's."""
        found = self._rooms.get(room_id)
        return None if found is None else found.hold

    async def take(self, room_id: str, after: int | None = None) -> Hold:
        """Have a room from now on, whoever had it before; raises LedgerError.

        All that its former holder has written is in the ledger then, and nothing comes after it.
        With `after`, raises HoldLostError unless that is still the number of the former hold, 0
        where there was none.
        """
        now = self._now()
        for _ in range(int(_PATIENCE / _PAUSE)):
            number = await self._ledger.read(
                hold_store.take,
                room=room_id,
                holder=self.holder,
                address=self.address,
                now=now,
                after=after,
            )
            if number is not None:
                return self._taken(room_id, number)
            await asyncio.sleep(_PAUSE)
        raise LedgerError(f"the transaction of room {room_id!r}'s former server does not end")

    def _taken(self, room_id: str, number: int) -> Hold:
        if not number:
            raise HoldLostError(f"another server was faster to take {room_id!r}", field="room")
        self._forget(room_id)
        hold = Hold(room_id, number)
        self._rooms[room_id] = _Held(hold)
        return hold

    async def confirm(self, room_id: str) -> None:
        """See that a room is still this server's; raises HoldLostError, LedgerError.

        What was read of it until then was written by its former holders and by nobody after them.
        """
        hold, row = self.of(room_id), await self.holder_of(room_id)
        if hold is None or row is None or hold.number != row.number:
            raise HoldLostError(f"another server has {room_id!r} now", field="room")

    def drop(self, room_id: str) -> Hold | None:
        """Have a room no more, whatever the ledger says; returns the hold that there was."""
        hold = self.of(room_id)
        self._forget(room_id)
        return hold

    async def release(self, hold: Hold) -> None:
        """Let a dropped room go, once all is written that was handed to the ledger before.

        Raises LedgerError; others can then take the room all the same.
        """
        await self._ledger.read(hold_store.release, hold=hold)

    async def holder_of(self, room_id: str) -> HoldRow | None:
        """Who has a room, as the ledger knows it; raises LedgerError."""
        return await self._ledger.read(hold_store.holder_of, room=room_id)

    async def listing(self) -> list[HoldRow]:
        """Every room that some server has; raises LedgerError."""
        return await self._ledger.read(hold_store.listing)

    def note(self, session: int, room_id: str) -> None:
        """What is written of the session of this number is of this room."""
        held = self._rooms.get(room_id)
        if held is not None:
            held.sessions.add(session)
            self._room_of[session] = room_id

    # What the ledger asks.

    def stamp(self, writes: Sequence[Write]) -> list[Part]:
        """The writes by the hold that they are made under; first those of no room, under None."""
        parts: dict[Hold | None, list[Write]] = {None: []}
        for write in writes:
            parts.setdefault(self._hold_of(write), []).append(write)
        if not parts[None]:
            del parts[None]
        return list(parts.items())

    def _hold_of(self, write: Write) -> Hold | None:
        room_id = self._room_id(write)
        if room_id is None:
            return None
        held = self._rooms.get(room_id)
        return _NOBODY if held is None else held.hold

    def _room_id(self, write: Write) -> str | None:
        """The room that a write is of; None where it is of none, or of all."""
        if isinstance(write, RoomRow):
            return write.id
        room: int | str | None = getattr(write, "room", None)
        if isinstance(room, int):
            return self._room_of.get(room, "")
        return room if isinstance(write, FairSessionRow | FairOpening | FairEnd) else None

    def _lost(self, holds: Sequence[Hold], failure: HoldLostError) -> None:
        """The ledger has refused what was written under these."""
        for hold in holds:
            if self.of(hold.room) == hold:
                self._forget(hold.room)
                _log.warning("%s", failure, extra={"room": hold.room})
                self.lost(hold.room)

    def _forget(self, room_id: str) -> None:
        held = self._rooms.pop(room_id, None)
        for session in () if held is None else held.sessions:
            self._room_of.pop(session, None)


_NOBODY: Final = Hold("", 0)
"""The hold of a room that this server does not have: the ledger never has it."""
