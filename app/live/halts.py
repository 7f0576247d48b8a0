"""Which tables an operator has halted: they take nothing new, and what is in flight lands and pays.

A halt is in the ledger before it is answered, and outlives the server.
"""

import asyncio
import logging
import time
from collections.abc import Callable

from app.errors import DamagedRoomError, HaltedError, LedgerError
from app.persistence.ledger.null_ledger import NullLedger
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import halt_store
from app.rooms.records import EVERY_ROOM, Halt, Release

_log = logging.getLogger("plinko")


class Halts:
    """For the event loop's thread. `tell` has who watches rooms told; `now` is Unix time, in s."""

    def __init__(
        self,
        ledger: Ledger | NullLedger,
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
        """What is halted, by id, EVERY_ROOM for all, each since when: Unix time, in s."""
        return dict(self._since)

    def holds(self, room_id: str) -> bool:
        """Whether this room takes nothing now."""
        return room_id in self._since or EVERY_ROOM in self._since

    def check(self, room_id: str) -> None:
        """Raise HaltedError where nothing is taken."""
        if self.holds(room_id):
            raise HaltedError(
                f"room {room_id!r} is halted by who runs this server: it takes no drops now; those "
                "in flight land and are paid",
                field="room",
            )

    async def load(self) -> None:
        """What the last server had halted; raises LedgerError when the ledger cannot be read."""
        if not self._ledger.keeps:
            return
        try:
            self._since = await self._ledger.read(halt_store.halts)
        except DamagedRoomError as error:
            _log.error("which tables are halted cannot be read, so that none is: %s", error)

    async def follow(self) -> None:
        """What another server has halted or let go on meanwhile; raises LedgerError."""
        async with self._turn:
            found = await self._ledger.read(halt_store.halts)
            if found != self._since:
                self._since = found
                self._tell_all()

    async def halt(self, room_id: str) -> None:
        """Take nothing more in a room; raises LedgerError, and then it goes on."""
        await self._ledger.decided(self._halt(room_id))

    async def release(self, room_id: str) -> None:
        """Go on in a room; raises LedgerError, and then it stays halted."""
        await self._ledger.decided(self._release(room_id))

    async def _halt(self, room_id: str) -> None:
        async with self._turn:
            if room_id in self._since:
                return
            since = self._since[room_id] = self._now()  # at once: a ledger may take its time
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
