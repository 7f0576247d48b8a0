"""Which server has a room: found in the ledger, and taken here where its server is gone."""

import asyncio
import contextlib
import functools
import logging
import time
from collections.abc import Callable
from typing import Any, Final

from app.cluster.alive import Alive
from app.cluster.hand_over import HandOver
from app.cluster.line import Line
from app.cluster.membership import BEAT, Member, Orphans, order
from app.concurrency.single_flight import SingleFlight
from app.errors import AppError, HoldLostError, LedgerError, shorten
from app.live.holding import Holding
from app.live.public_tables import MAIN
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import fair_store, hold_store, store
from app.rooms.records import HoldRow

_PATIENCE: Final = 8.0
"""s that a request waits for a room whose server is gone, before it is told to come back."""

_PAUSE: Final = 0.03
"""s between two looks at who has a room that is on its way."""

_SWEEP: Final = 2.0
"""s between two looks for rooms that nobody has though something moves in them."""

_log = logging.getLogger("plinko")


class Node:
    """For the event loop's thread. `run` while anything is asked of it.

    `has` says whether a room is in memory.
    """

    def __init__(
        self,
        alive: Alive,
        hand_over: HandOver,
        holding: Holding,
        ledger: Ledger,
        line: Line,
        *,
        has: Callable[[str], bool],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.alive = alive
        self.hand_over = hand_over
        self.line = line
        self.taken_over = 0  # rooms
        self.handed_on = 0  # requests
        self._in_memory = has
        self._holding = holding
        self._holds = holding.holds
        self._ledger = ledger
        self._clock = clock
        self._orphans = Orphans()
        self._taking: set[str] = set()
        self._swept = -_SWEEP
        self._alive_then: set[str] = set()  # at the last look
        self._looks = SingleFlight[HoldRow | None]()  # at who has a room
        self._tasks: set[asyncio.Task[Any]] = set()
        holding.claim = self._claim

    def has(self, room_id: str) -> bool:
        """Whether a room is in this server's memory, to stay."""
        return self._in_memory(room_id) and not self._holding.is_leaving(room_id)

    # Rooms whose server is gone.

    async def run(self) -> None:
        """Look after rooms until cancelled: at each beat, and at once where somebody is gone."""
        while True:
            try:
                await self._look()
            except LedgerError as error:
                _log.info("who has which room cannot be seen: %s", error)
            except Exception:  # noqa: BLE001 - the others look after its rooms meanwhile
                _log.exception("the cluster cannot be looked after")
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self.alive.missed.wait(), BEAT)

    async def _look(self) -> None:
        """Give up what is another's by now, and take over what nobody has."""
        if self.alive.doubtful:
            await self._check_holds()
            self.alive.checked()
        before, self._alive_then = self._alive_then, set(self.alive.view.members)
        now = self._clock()
        missing = before - self._alive_then
        if missing or self._orphans.waiting or now - self._swept >= _SWEEP:
            self._swept = now
            await self._sweep(now)

    async def _check_holds(self) -> None:
        """After a silence, others may have taken rooms; nothing more is told of these."""
        read = functools.partial(hold_store.held_by, holder=self._holds.holder)
        before = self._holds.rooms
        held = {row.room for row in await self._ledger.read(read)}
        for room_id in before:
            if room_id not in held and self._holds.of(room_id) is not None:
                self._holding.put_away(room_id)

    async def _sweep(self, now: float) -> None:
        if self.alive.leaving or not self.alive.view.sure:
            return
        # In this order: a room is held before it is in the ledger.
        awake = [MAIN, *(room.id for room in await self._ledger.read(store.awake_rooms))]
        rows = await self._holds.listing()
        for room_id in self._orphans.due(rows, awake, self.alive.view, self._holds.holder, now):
            task = asyncio.create_task(self._take_over(room_id))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _take_over(self, room_id: str) -> None:
        if room_id in self._taking or self.has(room_id):
            return
        self._taking.add(room_id)
        try:
            if await self._fetched(room_id) and self.has(room_id):
                self.taken_over += 1
                _log.warning("room taken over", extra={"room": room_id})
        except AppError as error:
            _log.info("put off: %s", error)
        finally:
            self._taking.discard(room_id)

    async def gone(self) -> None:
        """This server has ended."""
        await self.line.close()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    # Finding rooms.

    async def locate(self, room_id: str, *, only_here: bool = False) -> Member | None:
        """Who has a room: another server, or None for this one, which then has it in memory.

        It is taken if nobody has it; None also where there is no such room. Waits while it is on
        its way from one to another; raises HoldLostError when that takes long, LedgerError when
        who has it cannot be seen. With `only_here` another server is a HoldLostError too.
        """
        end = self._clock() + _PATIENCE
        while not self.has(room_id):
            await self._holding.until_left(room_id)
            look = functools.partial(self._holds.holder_of, room_id)
            row = await self._looks.do(room_id, look)
            other = self._other(room_id, row)
            if other is not None and not only_here:
                return other
            if other is not None or self._clock() > end:
                break
            if not self._is_free(row):
                await self.alive.until_looked()
            elif await self._fetched(room_id):
                return None
            else:
                await asyncio.sleep(_PAUSE)
        else:
            return None
        raise HoldLostError(f"room {shorten(room_id)} is on its way between servers", field="room")

    def _other(self, room_id: str, row: HoldRow | None) -> Member | None:
        """The server to ask for a room, if it is another one that is alive."""
        if row is not None and row.holder not in ("", self._holds.holder):
            return self.alive.view.members.get(row.holder)
        if (member := self.hand_over.sent_to(room_id)) is not None:
            return member
        # One that leaves takes nothing more: whoever comes need not wait until it is gone.
        others = order(room_id, self.alive.others) if self.alive.leaving else []
        return next(iter(others), None)

    def _is_free(self, row: HoldRow | None) -> bool:
        """Whether this server may take a room of which the ledger says this."""
        if self.alive.leaving and self.alive.others:
            return False
        mine = row is None or row.holder in ("", self._holds.holder)
        return mine or (row is not None and self.alive.view.is_gone(row.holder))

    async def _fetched(self, room_id: str) -> bool:
        """Take a room, unless another is faster; raises LedgerError where it cannot be read."""
        try:
            await self._holding.fetch(room_id)
        except HoldLostError:
            return False
        return True

    def _claim(self, room_id: str, row: HoldRow | None) -> int:
        """Before a room is taken: the number it is taken after; HoldLostError where it is had."""
        if not self._is_free(row):
            raise HoldLostError(f"room {room_id!r} is at another server", field="room")
        return 0 if row is None else row.number

    async def room_of_session(self, session_id: str) -> str | None:
        """The room of a player's session; raises LedgerError."""
        read = functools.partial(fair_store.session, session_id=session_id)
        found = await self._ledger.read(read)
        return None if found is None else found[0].room
