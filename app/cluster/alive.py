"""Says that this server is alive, sees which others are, and ends what depends on one that is not.

Beats go by themselves: a ledger that takes its time must not cost this server its rooms.
"""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Iterable
from typing import Final

from app.cluster.beats import FAILURES, Beats
from app.cluster.membership import BEAT, LEASE, Member, Seen, View
from app.concurrency.signal import Signal
from app.persistence.lease_book import LeaseBook
from app.rooms.records import LeaseRow

_PATIENCE: Final = 5.0
"""s that a start and an end wait for PostgreSQL; a server that has started is not ready then."""

_log = logging.getLogger("plinko")


class Alive:
    """For the event loop's thread. `name` is what people call this server.

    `looked` is sent each time it looked who is alive, and when that could not be seen. `leaving`
    is whether this server gives its rooms away. `database` is PostgreSQL's address.
    """

    def __init__(self, database: str, book: LeaseBook, name: str) -> None:
        self.name = name
        self.view = View()
        self.leaving = False
        self.looked = Signal()
        self._database = database
        self._book = book
        self._depending: dict[asyncio.Timeout, str] = {}  # on the server of this name

    @property
    def me(self) -> Member:
        """This server, as the others see it."""
        return Member(self._book.holder, self.name, self._book.address, self.leaving)

    def claim(self, room_id: str, row: LeaseRow | None) -> int:
        """The number of the lease that this server's is to follow; raises LeaseLostError."""
        return self.view.claim(room_id, row, self.me)

    async def run(self) -> None:
        """Beat until cancelled, whatever becomes of PostgreSQL; at once where a server leaves."""
        clock = asyncio.get_running_loop().time
        while True:
            began = clock()
            try:
                async with Beats.connected(self._database) as beats:
                    while True:
                        me = self.me
                        self.look(me, await beats.beat(me))
                        await beats.until_told(BEAT)
            except FAILURES as error:
                self.failed(error)
            # A connection that lasted is made again at once: without one the lease is shorter.
            await asyncio.sleep(began + BEAT - clock())

    def look(self, me: Member, found: Iterable[Seen]) -> None:
        """Take in who was found at the beat of `me`."""
        if late := self.view.look(me, found):
            _log.warning(
                "this server was late: it said %.1f s ago that it is alive, and after %g s others "
                "may take its rooms",
                late,
                LEASE,
            )
        for limit, holder in list(self._depending.items()):
            if self.view.is_gone(holder):
                del self._depending[limit]
                limit.reschedule(0.0)
        self.looked.send()

    def failed(self, error: Exception) -> None:
        """Note that PostgreSQL does not say who is alive; all stays as it was known."""
        if self.view.up:
            _log.warning("servers do not see each other: rooms stay where they are: %s", error)
        self.view.failed()
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

    async def until_known(self) -> None:
        """Return once the others know how this server is, or it is clear that this takes long."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_PATIENCE):
                while self.me != self.view.members.get(self.me.holder):
                    await self.looked.wait()
