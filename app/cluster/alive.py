"""Says that this server is alive, sees which others are, and ends what depends on one that is not.

Beats go by themselves, on a thread of their own: neither a ledger that takes its time nor a loop
that has much to do may cost this server its rooms, as giving them to others makes more to do.
"""

import asyncio
import contextlib
import logging
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterable
from typing import Final

from app.cluster.beats import FAILURES, Beats
from app.cluster.membership import BEAT, LEASE, Member, Seen, View
from app.concurrency.signal import Signal
from app.persistence.lease_book import LeaseBook
from app.rooms.records import LeaseRow

_PATIENCE: Final = 5.0
"""s that a start and an end wait for PostgreSQL; a server that has started is not ready then."""

_STANDS_STILL: Final = 10.0
"""s after which a loop that has not come round counts as standing still, and others may take its
rooms: longer than a busy machine holds it up."""

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
        self._came_round = 0.0  # when the loop last took in who is alive, s of the monotonic clock
        self._depending: dict[asyncio.Timeout, str] = {}  # on the server of this name

    @property
    def me(self) -> Member:
        """This server, as the others see it."""
        return Member(self._book.holder, self.name, self._book.address, self.leaving)

    def claim(self, room_id: str, row: LeaseRow | None) -> int:
        """The number of the lease that this server's is to follow; raises LeaseLostError."""
        return self.view.claim(room_id, row, self.me)

    async def run(self) -> None:
        """Beat until cancelled, whatever becomes of PostgreSQL."""
        self._came_round = time.monotonic()
        tell, over = asyncio.get_running_loop().call_soon_threadsafe, threading.Event()
        thread = threading.Thread(target=self._beat, args=(tell, over), name="beats", daemon=True)
        thread.start()
        try:
            await asyncio.Event().wait()
        finally:
            over.set()
            await asyncio.to_thread(thread.join, LEASE)

    def _beat(self, tell: Callable[..., object], over: threading.Event) -> None:
        while not over.is_set():
            began = time.monotonic()
            try:
                with Beats.connected(self._database) as beats:
                    while not over.is_set():
                        if time.monotonic() < self._came_round + _STANDS_STILL:
                            me = self.me
                            tell(self.look, me, beats.beat(me))
                        beats.until_told()
            except FAILURES as error:
                tell(self.failed, error)
            # A connection that lasted is made again at once: without one the lease is shorter.
            over.wait(began + BEAT - time.monotonic())

    def look(self, me: Member, found: Iterable[Seen]) -> None:
        """Take in who was found at the beat of `me`."""
        self._came_round = time.monotonic()
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
        self._came_round = time.monotonic()
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
