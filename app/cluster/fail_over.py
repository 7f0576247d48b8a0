"""Takes over the rooms of failed servers, and gives up rooms that another server has taken."""

import asyncio
import logging
import time
from collections.abc import Callable, Collection, Sequence
from typing import Final

from plinko.app.cluster.alive import Alive
from plinko.app.cluster.membership import order, orphans
from plinko.app.errors import LedgerError
from plinko.app.live.public_tables import MAIN
from plinko.app.live.stored_rooms import StoredRooms
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import lease_store, store
from plinko.app.rooms.records import Lease, LeaseRow

_SWEEP: Final = 2.0
"""Seconds between two searches for rooms in which something moves but that no server has."""

_log = logging.getLogger("plinko")


class FailOver:
    """For the event loop's thread. `count` is the number of rooms taken from failed servers."""

    def __init__(
        self,
        alive: Alive,
        rooms: StoredRooms,
        ledger: Ledger,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.count = 0
        self._alive = alive
        self._rooms = rooms
        self._book = ledger.leases
        self._ledger = ledger
        self._clock = clock
        self._swept = -_SWEEP
        self._seen: set[str] = set()  # holders of the servers that were alive at the last call
        self._taking: set[str] = set()
        self._orphaned: set[str] = set()  # rooms without a live server in the last sweep
        self._lost: set[str] = set()  # those of them that a failed server had

    async def run(self) -> None:
        """After each heartbeat, take the rooms that are due, until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            while True:
                await self._alive.looked.wait()
                try:
                    for room_id in await self.look():
                        tasks.create_task(self.take(room_id))
                except LedgerError as error:
                    _log.info("cannot read which server has which room: %s", error)
                except Exception:  # noqa: BLE001 - the next heartbeat tries again
                    _log.exception("looking for rooms to take over failed")

    async def look(self) -> set[str]:
        """Check all rooms if a server has left or a sweep is due; returns the rooms to take."""
        now, seen, self._seen = self._clock(), self._seen, set(self._alive.view.members)
        if not seen - self._seen and now - self._swept < _SWEEP:
            return set()
        self._swept = now
        held = [self._book.of(room_id) for room_id in self._book.rooms]
        # Read the awake rooms before the leases. A new room gets its lease before its ledger row,
        # so each awake room that was read has a lease in the later listing.
        awake = {MAIN, *await self._ledger.read(store.awake_rooms)}
        rows = await self._ledger.read(lease_store.listing)
        self._give_up([each for each in held if each is not None], rows)
        # Rooms that were handed over to this server, but that no client has asked it for yet.
        given = {each.room for each in rows if each.holder == self._book.holder} & awake
        due = self._inherited(rows, awake) | (given - {*self._book.rooms})
        return due - self._taking

    def _give_up(self, held: Sequence[Lease], rows: Sequence[LeaseRow]) -> None:
        """Close rooms whose lease this server has lost, for example because it was frozen."""
        numbers = {row.room: row.number for row in rows}
        for lease in held:
            if numbers.get(lease.room) != lease.number and self._book.of(lease.room) == lease:
                self._rooms.leaving.put_away(lease.room)

    def _inherited(self, rows: Sequence[LeaseRow], awake: Collection[str]) -> set[str]:
        """Rooms whose server has failed and that this server should take.

        After the first sweep only the first server in the room's order takes a room. If the next
        sweep finds that no server has it, any server may: the first may be unable to load it.
        """
        before, self._orphaned = self._orphaned, orphans(rows, awake, self._alive.view)
        self._lost = self._orphaned & {row.room for row in rows}
        able = self._alive.view.takers
        mine = {each for each in self._orphaned if order(each, able)[:1] == [self._alive.me]}
        return mine | (self._orphaned & before)

    async def take(self, room_id: str) -> None:
        """Try to bring a room here. A failure is only logged: the next sweep tries again."""
        lost = room_id in self._lost
        self._taking.add(room_id)
        try:
            await self._rooms.arriving.fetch(room_id)
        except Exception as error:  # noqa: BLE001 - one room's failure must not stop the others
            _log.info("room not taken over yet: %s", error)
            return
        finally:
            self._taking.discard(room_id)
        if lost and self._book.of(room_id) is not None:
            self.count += 1
            _log.warning("room taken over", extra={"room": room_id})
