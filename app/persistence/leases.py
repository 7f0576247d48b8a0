"""Leases of rooms, taken, confirmed, passed on and released in the ledger that servers share."""

import asyncio
import time
from collections.abc import Callable
from typing import Final

from app.concurrency.single_flight import SingleFlight
from app.concurrency.to_the_end import log_failure
from app.errors import LeaseLostError, LedgerError
from app.persistence.lease_book import LeaseBook
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import lease_store
from app.rooms.records import Lease, LeaseRow

_TAKE_SECONDS: Final = 10.0
"""s for which the former holder's transaction may last; the database ends it."""

_TAKE_AGAIN: Final = 0.05  # s until it is tried again

_FRESH: Final = 0.25  # s for which a confirmed lease counts as good; none is lost that fast


class Leases:
    """For the event loop's thread. `now` gives Unix time in seconds."""

    def __init__(
        self, ledger: Ledger, book: LeaseBook, *, now: Callable[[], float] = time.time
    ) -> None:
        self.book = book
        self._ledger = ledger
        self._now = now
        self._confirming = SingleFlight[None]()
        self._releasing: set[asyncio.Task[None]] = set()

    async def take(self, room_id: str, after: int | None, lost: Callable[[str], None]) -> Lease:
        """Have a room from now on, whoever had it before; raises LedgerError.

        All that its former holder has written is in the ledger then, and nothing comes after it.
        With `after`, raises LeaseLostError unless that is still the number of the former lease, 0
        where there was none. `lost` is called with the room's id when another server took it.
        """
        book, now = self.book, self._now()
        for _ in range(int(_TAKE_SECONDS / _TAKE_AGAIN)):
            number = await self._ledger.read(
                lease_store.take,
                room=room_id,
                holder=book.holder,
                address=book.address,
                now=now,
                after=after,
            )
            if number is not None:
                break
            await asyncio.sleep(_TAKE_AGAIN)
        else:
            raise LedgerError(f"the transaction of room {room_id!r}'s former server does not end")
        if not number:
            raise LeaseLostError(f"another server was faster to take {room_id!r}", field="room")
        lease = Lease(room_id, number)
        book.add(lease, lost)
        return lease

    async def confirm(self, room_id: str) -> None:
        """See that a room is still this server's; raises LeaseLostError, LedgerError.

        What was read of it until then was written by its former holders and by nobody after them.
        """
        lease, row = self.book.of(room_id), await self.holder_of(room_id)
        if lease is None or row is None or lease.number != row.number:
            raise LeaseLostError(f"another server has {room_id!r} now", field="room")

    async def confirm_lately(self, room_id: str) -> None:
        """`confirm`, at most once for all who ask within a quarter of a second."""
        entry, now = self.book.entry(room_id), asyncio.get_running_loop().time()
        if entry is None or now - entry.confirmed >= _FRESH:
            await self._confirming.do(room_id, lambda: self.confirm(room_id))
            if entry is not None:
                entry.confirmed = now

    async def release(self, lease: Lease, holder: str = "", address: str = "") -> None:
        """Let a dropped room go, once all is written that was handed to the ledger before.

        It is the server's of the name `holder` then, or nobody's. Raises LedgerError; others can
        then take the room all the same.
        """
        await self._ledger.read(
            lease_store.release, lease=lease, holder=holder, address=address, now=self._now()
        )

    def let_go(self, room_id: str) -> None:
        """A room has left the memory, and all of it is written: any server may have it."""
        lease = self.book.drop(room_id)
        if lease is not None:
            task = asyncio.create_task(self.release(lease))
            self._releasing.add(task)
            task.add_done_callback(self._releasing.discard)
            task.add_done_callback(log_failure)

    async def holder_of(self, room_id: str) -> LeaseRow | None:
        """Who has a room, as the ledger knows it; raises LedgerError."""
        return await self._ledger.read(lease_store.holder_of, room=room_id)

    async def listing(self) -> list[LeaseRow]:
        """Every room that some server has; raises LedgerError."""
        return await self._ledger.read(lease_store.listing)
