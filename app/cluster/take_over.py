"""Takes over rooms whose server is gone, and gives up those that another server has taken."""

import asyncio
import logging
import time
from collections.abc import Callable, Collection, Sequence
from typing import Final

from app.cluster.alive import Alive
from app.cluster.membership import orphans
from app.errors import AppError, LedgerError
from app.live.public_tables import MAIN
from app.live.shared_rooms import SharedRooms
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import store
from app.rooms.records import Lease, LeaseRow

_SWEEP: Final = 2.0
"""s between two searches for rooms that nobody has though something moves in them."""

_log = logging.getLogger("plinko")


class TakeOver:
    """For the event loop's thread. `count` is of rooms."""

    def __init__(
        self,
        alive: Alive,
        rooms: SharedRooms,
        ledger: Ledger,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.count = 0
        self._alive = alive
        self._rooms = rooms
        self._book = rooms.leases.book
        self._ledger = ledger
        self._clock = clock
        self._swept = -_SWEEP
        self._seen: set[str] = set()  # servers that were alive at the last look
        self._taking: dict[str, asyncio.Task[None]] = {}

    async def run(self) -> None:
        """Look after rooms until cancelled: at each beat, and at once where a server leaves."""
        while True:
            await self._alive.looked.wait()
            try:
                await self.look()
            except LedgerError as error:
                _log.info("who has which room cannot be seen: %s", error)
            except Exception:  # noqa: BLE001 - the others look after its rooms meanwhile
                _log.exception("the cluster cannot be looked after")

    async def look(self) -> None:
        """Look at all rooms, unless nothing has happened since that was done last."""
        now, seen, self._seen = self._clock(), self._seen, set(self._alive.view.members)
        if seen - self._seen or now - self._swept >= _SWEEP:
            self._swept = now
            await self._sweep()

    async def _sweep(self) -> None:
        held = [self._book.of(room_id) for room_id in self._book.rooms]
        # In this order: a room is leased before it is in the ledger.
        awake = {MAIN, *(room.id for room in await self._ledger.read(store.awake_rooms))}
        rows = await self._rooms.leases.listing()
        self._give_up([each for each in held if each is not None], rows)
        due = orphans(rows, awake, self._alive.view, self._alive.me)
        for room_id in {*due, *self._given(rows, awake)} - self._taking.keys():
            task = asyncio.create_task(self._take(room_id, orphan=room_id in due), name=room_id)
            self._taking[room_id] = task
            task.add_done_callback(lambda done: self._taking.pop(done.get_name()))

    def _give_up(self, held: Sequence[Lease], rows: Sequence[LeaseRow]) -> None:
        """Put rooms away whose lease was this server's and is not any more: it was frozen, say."""
        numbers = {row.room: row.number for row in rows}
        for lease in held:
            if numbers.get(lease.room) != lease.number and self._book.of(lease.room) == lease:
                self._rooms.leaving.put_away(lease.room)

    def _given(self, rows: Sequence[LeaseRow], awake: Collection[str]) -> list[str]:
        """Rooms that were passed on to this server, which was not asked for them since."""
        mine = [row.room for row in rows if row.holder == self._book.holder]
        return [each for each in mine if each in awake and self._book.of(each) is None]

    async def _take(self, room_id: str, *, orphan: bool) -> None:
        try:
            await self._rooms.arriving.fetch(room_id)
        except AppError as error:
            _log.info("put off: %s", error)
            return
        if orphan and self._book.of(room_id) is not None:
            self.count += 1
            _log.warning("room taken over", extra={"room": room_id})

    async def close(self) -> None:
        """This server has ended."""
        tasks = list(self._taking.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
