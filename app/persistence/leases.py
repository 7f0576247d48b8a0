"""Takes, confirms, hands over and releases room leases in a ledger that servers share."""

import asyncio
import time
from collections.abc import Callable
from typing import Final

from plinko.app.concurrency.single_flight import SingleFlight, log_failure
from plinko.app.errors import LeaseLostError, LedgerError
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import lease_store
from plinko.app.rooms.records import Lease

_TAKE_SECONDS: Final = 10.0
"""How long to wait for a transaction of the former holder. The database ends it before that."""

_TAKE_AGAIN: Final = 0.05  # s between two attempts to take a lease

_FRESH: Final = 0.25  # s for which a confirmation stays good: a lease is never lost that fast


class Leases:
    """For the event loop's thread. `now` gives Unix time in seconds.

    A server that has the ledger for itself has every room: all this does nothing there.
    """

    def __init__(self, ledger: Ledger, *, now: Callable[[], float] = time.time) -> None:
        self.book = ledger.leases
        self._ledger = ledger
        self._now = now
        self._confirming = SingleFlight[None]()
        self._releasing: set[asyncio.Task[None]] = set()

    async def take(
        self, room_id: str, after: int | None, lost: Callable[[str], None]
    ) -> Lease | None:
        """Take a room's lease from its former holder; raises LedgerError.

        The ledger then has everything that the former holder wrote, and refuses all its later
        writes. With `after`, raises LeaseLostError unless the former lease still has that number
        (0: no lease). `lost` is called with the room's id if another server takes the room.
        """
        book, now = self.book, self._now()
        if book.alone:
            return None
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
            raise LedgerError(f"the former server of room {room_id!r} does not end its transaction")
        if not number:
            raise LeaseLostError(f"another server has taken room {room_id!r} first", field="room")
        lease = Lease(room_id, number)
        book.add(lease, lost)
        return lease

    async def confirm(self, room_id: str) -> None:
        """Check that this server still has a room; raises LeaseLostError, LedgerError.

        If it has, no other server has written to the room since this server took it.
        """
        if self.book.alone:
            return
        lease = self.book.of(room_id)
        row = await self._ledger.read(lease_store.holder_of, room=room_id)
        if lease is None or row is None or lease.number != row.number:
            raise LeaseLostError(f"another server has room {room_id!r} now", field="room")

    async def confirm_lately(self, room_id: str) -> None:
        """As `confirm`, but asks the ledger at most once in a quarter of a second."""
        entry, now = self.book.entry(room_id), asyncio.get_running_loop().time()
        if entry is None or now - entry.confirmed >= _FRESH:
            await self._confirming.do(room_id, lambda: self.confirm(room_id))
            if entry is not None:
                entry.confirmed = now

    async def release(self, lease: Lease, holder: str = "", address: str = "") -> None:
        """Release the lease of a dropped room, after all writes handed to the ledger before.

        The room then belongs to the server `holder`, or to no server. Raises LedgerError; other
        servers can take the room even then.
        """
        await self._ledger.read(
            lease_store.release, lease=lease, holder=holder, address=address, now=self._now()
        )

    def let_go(self, room_id: str) -> None:
        """Release a room that has left memory and is completely written, in the background."""
        lease = self.book.drop(room_id)
        if lease is not None:
            task = asyncio.create_task(self.release(lease))
            self._releasing.add(task)
            task.add_done_callback(self._releasing.discard)
            task.add_done_callback(log_failure)
