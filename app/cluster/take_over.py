"""Takes over rooms whose server is gone, and gives up those that another server has taken."""

import asyncio
import logging
import time
from collections.abc import Callable, Collection, Sequence
from typing import Final

from app.cluster.alive import Alive
from app.cluster.membership import order, orphans
from app.errors import LedgerError
from app.live.public_tables import MAIN
from app.live.shared_rooms import SharedRooms
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import store
from app.rooms.records import Lease, LeaseRow

_SWEEP: Final = 2.0
"""s between two searches for rooms that nobody has though something moves in them."""

_log = logging.getLogger("plinko")


class TakeOver:
    """For the event loop's thread. `count` is of rooms whose server was gone."""

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
        self._taking: set[str] = set()
        self._orphaned: set[str] = set()  # rooms that the last sweep found to be nobody's
        self._lost: set[str] = set()  # those of them that a server had which is gone

    async def run(self) -> None:
        """Look after rooms until cancelled: at each beat, and at once where a server leaves."""
        async with asyncio.TaskGroup() as tasks:
            while True:
                await self._alive.looked.wait()
                try:
                    for room_id in await self.look():
                        tasks.create_task(self.take(room_id))
                except LedgerError as error:
                    _log.info("who has which room cannot be seen: %s", error)
                except Exception:  # noqa: BLE001 - the others look after its rooms meanwhile
                    _log.exception("the cluster cannot be looked after")

    async def look(self) -> set[str]:
        """Look at all rooms, unless nothing has happened since; returns those to be taken."""
        now, seen, self._seen = self._clock(), self._seen, set(self._alive.view.members)
        if not seen - self._seen and now - self._swept < _SWEEP:
            return set()
        self._swept = now
        held = [self._book.of(room_id) for room_id in self._book.rooms]
        # In this order: a room is leased before it is in the ledger.
        awake = {MAIN, *(room.id for room in await self._ledger.read(store.awake_rooms))}
        rows = await self._rooms.leases.listing()
        self._give_up([each for each in held if each is not None], rows)
        # Rooms that were passed on to this server, which was not asked for them since, are its own.
        given = {each.room for each in rows if each.holder == self._book.holder} & awake
        due = self._inherited(rows, awake) | (given - {*self._book.rooms})
        return due - self._taking

    def _give_up(self, held: Sequence[Lease], rows: Sequence[LeaseRow]) -> None:
        """Put rooms away whose lease was this server's and is not any more: it was frozen, say."""
        numbers = {row.room: row.number for row in rows}
        for lease in held:
            if numbers.get(lease.room) != lease.number and self._book.of(lease.room) == lease:
                self._rooms.leaving.put_away(lease.room)

    def _inherited(self, rows: Sequence[LeaseRow], awake: Collection[str]) -> set[str]:
        """Rooms whose server is gone and which this server should take.

        After the first sweep only the first server in the room's order takes a room. If the next
        sweep finds that no server has it, any server may: the first may be unable to rebuild it.
        """
        before, self._orphaned = self._orphaned, orphans(rows, awake, self._alive.view)
        self._lost = self._orphaned & {row.room for row in rows}
        able = [each for each in self._alive.view.members.values() if not each.leaving]
        mine = {each for each in self._orphaned if order(each, able)[:1] == [self._alive.me]}
        return mine | (self._orphaned & before)

    async def take(self, room_id: str) -> None:
        """Have a room here from now on, if that can be."""
        lost = room_id in self._lost
        self._taking.add(room_id)
        try:
            await self._rooms.arriving.fetch(room_id)
        except Exception as error:  # noqa: BLE001 - one room keeps nothing from the others
            _log.info("put off: %s", error)
            return
        finally:
            self._taking.discard(room_id)
        if lost and self._book.of(room_id) is not None:
            self.count += 1
            _log.warning("room taken over", extra={"room": room_id})
