"""Says that this server is alive, sees which others are, and ends what depends on one that is not.

Beats go by themselves: a ledger that takes its time must not cost this server its rooms.
"""

import asyncio
import contextlib
import logging
import time
from collections.abc import AsyncIterator, Callable

from app.cluster.beats import FAILURES, Beats
from app.cluster.membership import BEAT, Member, View
from app.concurrency.signal import Signal
from app.persistence.lease_book import LeaseBook
from app.rooms.records import LeaseRow

_log = logging.getLogger("plinko")


class Alive:
    """For the event loop's thread. `name` is what people call this server.

    `looked` is sent each time it looked who is alive, and when that could not be seen. `leaving`
    is whether this server gives its rooms away.
    """

    def __init__(
        self,
        beats: Beats,
        book: LeaseBook,
        name: str,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.name = name
        self.view = View()
        self.leaving = False
        self.looked = Signal()
        self._beats = beats
        self._book = book
        self._clock = clock
        self._depending: dict[asyncio.Timeout, str] = {}  # on the server of this name

    @property
    def me(self) -> Member:
        """This server, as the others see it."""
        return Member(self._book.holder, self.name, self._book.address, self.leaving)

    @property
    def joined(self) -> bool:
        """Whether the others know that this server is there."""
        return self._book.holder in self.view.members

    @property
    def others(self) -> list[Member]:
        """The other servers that can be given rooms."""
        return self.view.others(self._book.holder)

    def claim(self, room_id: str, row: LeaseRow | None) -> int:
        """The number of the lease that this server's is to follow; raises LeaseLostError."""
        return self.view.claim(room_id, row, self.me)

    async def run(self) -> None:
        """Beat until cancelled, whatever becomes of it; at once where another server leaves."""
        while True:
            due = self._clock() + BEAT
            await self.beat()
            with contextlib.suppress(*FAILURES):
                await self._beats.until_told(max(0.0, due - self._clock()))
            if not self.view.up:
                await asyncio.sleep(max(0.0, due - self._clock()))

    async def beat(self) -> None:
        """Say that this server is alive, and see who else is."""
        try:
            look = await self._beats.beat(self.me)
        except FAILURES as error:
            if self.view.up:
                _log.warning("servers do not see each other: rooms stay where they are: %s", error)
            self.view.failed()
        else:
            self.view.look(self._clock(), look)
            for limit, holder in list(self._depending.items()):
                if self.view.is_gone(holder):
                    del self._depending[limit]
                    limit.reschedule(0.0)
        self.looked.send()

    @contextlib.asynccontextmanager
    async def while_there(self, member: Member) -> AsyncIterator[None]:
        """Raise TimeoutError in the block once another server is gone."""
        async with asyncio.timeout(None) as limit:
            self._depending[limit] = member.holder
            try:
                yield
            finally:
                self._depending.pop(limit, None)

    async def leave(self) -> None:
        """From now on this server gives its rooms away, and the others know."""
        self.leaving = True
        await self.beat()

    async def gone(self) -> None:
        """This server has ended; nobody is to ask it any more."""
        with contextlib.suppress(*FAILURES):
            await self._beats.leave(self.me)
        self._beats.close()
