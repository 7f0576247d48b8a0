"""The rooms that the operator has halted: they take no drops; balls in flight land and pay.

A halt is committed to the ledger before the request is answered, so it survives a restart.
"""

import asyncio
import logging
import time
from collections.abc import Callable

from plinko.app.errors import DamagedRoomError, HaltedError, LedgerError
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import halt_store
from plinko.app.rooms.records import EVERY_ROOM, Halt, Release

_log = logging.getLogger("plinko")


class Halts:
    """For the event loop's thread. `tell` informs the clients; `now` returns Unix time in s."""

    def __init__(
        self,
        ledger: Ledger,
        tell: Callable[[], None],
        now: Callable[[], float] = time.time,
    ) -> None:
        self._ledger = ledger
        self._tell_all = tell
        self._now = now
        self._since: dict[str, float] = {}
        self._turn = asyncio.Lock()

    @property
    def since(self) -> dict[str, float]:
        """The start of each halt, in Unix time in s, by room id; EVERY_ROOM stands for all."""
        return dict(self._since)

    def holds(self, room_id: str) -> bool:
        """Whether this room is halted, by itself or with all rooms."""
        return room_id in self._since or EVERY_ROOM in self._since

    def check(self, room_id: str) -> None:
        """Raise HaltedError if this room is halted."""
        if self.holds(room_id):
            raise HaltedError(
                f"room {room_id!r} is halted by the operator of this server: it takes no drops "
                "now; balls in flight land and pay",
                field="room",
            )

    async def load(self) -> None:
        """Read the halts at the server's start; raises LedgerError if the ledger is unreadable."""
        try:
            self._since = await self._ledger.read(halt_store.halts)
        except DamagedRoomError as error:
            _log.error("the record of halts is damaged, so no room is halted: %s", error)

    async def follow(self) -> None:
        """Take over the halts and releases of other servers; raises LedgerError."""
        async with self._turn:
            found = await self._ledger.read(halt_store.halts)
            if found != self._since:
                self._since = found
                self._tell_all()

    async def halt(self, room_id: str) -> None:
        """Halt a room. Raises LedgerError; the room then goes on."""
        await self._ledger.decided(self._halt(room_id))

    async def release(self, room_id: str) -> None:
        """End the halt of a room. Raises LedgerError; the room then stays halted."""
        await self._ledger.decided(self._release(room_id))

    async def _halt(self, room_id: str) -> None:
        async with self._turn:
            if room_id in self._since:
                return
            since = self._since[room_id] = self._now()  # effective while the ledger commits it
            try:
                await self._ledger.commit(Halt(room_id, since))
            except LedgerError:
                del self._since[room_id]
                raise
            self._tell("halted", room_id)

    async def _release(self, room_id: str) -> None:
        async with self._turn:
            if room_id not in self._since:
                return
            await self._ledger.commit(Release(room_id))
            del self._since[room_id]
            self._tell("released", room_id)

    def _tell(self, what: str, room_id: str) -> None:
        _log.warning(what, extra={"room": "all" if room_id == EVERY_ROOM else room_id})
        self._tell_all()
