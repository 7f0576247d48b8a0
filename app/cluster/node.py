"""This server among the others: says that it is alive, finds who has a room, takes rooms over."""

import asyncio
import contextlib
import functools
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Any, Final

from app.cluster.leases import FAILURES, Leases
from app.cluster.line import Line
from app.cluster.membership import BEAT, LEASE, Member, Orphans, View, order
from app.cluster.passed import Passed
from app.concurrency.signal import Signal
from app.concurrency.single_flight import SingleFlight
from app.errors import AppError, HoldLostError, InvalidValueError, LedgerError, shorten
from app.live.holding import Holding
from app.live.public_tables import MAIN
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import fair_store, hold_store, store
from app.rooms.records import HoldRow
from app.web.shared import Standing

_PATIENCE: Final = 8.0
"""s that a request waits for a room whose server is gone, before it is told to come back."""

_PAUSE: Final = 0.03
"""s between two looks at who has a room that is on its way."""

_SWEEP: Final = 2.0
"""s between two looks for rooms that nobody has though something moves in them."""

_SENT: Final = 5.0
"""s for which the server that gave a room away knows whom it gave it to."""

_AT_ONCE: Final = 4
"""Rooms that nobody watches are handed over at a time: no more than a server brings back at a time.
Those that are watched go one by one: each stands still until the other server has it, and that is
the sooner, the less else that server has to do."""

_log = logging.getLogger("plinko")


class Node:
    """For the event loop's thread. `run` while anything is asked of it, `leave` at the end.

    `has` says whether a room is in memory, `watched` how many watch it.
    """

    def __init__(
        self,
        leases: Leases,
        holding: Holding,
        ledger: Ledger,
        line: Line,
        name: str,
        *,
        has: Callable[[str], bool],
        watched: Callable[[str], int],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.name = name
        self.view = View()
        self.taken_over = self.handed_over = 0  # rooms
        self.handed_on = 0  # requests
        self.line = line
        self.passed = Passed()
        self._in_memory = has
        self._watched = watched
        self._leases = leases
        self._holding = holding
        self._holds = holding.holds
        self._ledger = ledger
        self._clock = clock
        self.leaving = False
        self._orphans = Orphans()
        self._taking: set[str] = set()
        self._swept = -_SWEEP
        self._seen: set[str] = set()  # who was alive at the last look
        self._missing = False  # somebody has gone since the last sweep
        self._beaten = clock()
        self._doubtful = False  # it was silent for so long that others may have taken its rooms
        self._looked = Signal()  # at who is alive, with whatever came of it
        self._missed = Signal()  # somebody is gone
        self._knocking: set[str] = set()  # servers of which it is being seen whether they listen
        self._sent: dict[str, tuple[Member, float]] = {}
        self._looks = SingleFlight[HoldRow | None]()  # at who has a room
        self._tasks: set[asyncio.Task[Any]] = set()
        holding.claim = self._claim

    def has(self, room_id: str) -> bool:
        """Whether a room is in this server's memory, to stay."""
        return self._in_memory(room_id) and not self._holding.is_leaving(room_id)

    @property
    def me(self) -> Member:
        """This server, as the others see it."""
        return Member(self._holds.holder, self.name, self._holds.address, self.leaving)

    @property
    def joined(self) -> bool:
        """Whether the others know that this server is there."""
        return self.me.holder in self.view.members

    @property
    def others(self) -> list[Member]:
        """The other servers that can be given rooms."""
        return self.view.others(self._holds.holder)

    def at(self, address: str) -> None:
        """Where the others reach this server, known once it listens."""
        self._holds.address = self._holds.address or address

    def standing(self) -> Standing:
        """How this server stands among the others."""
        names = sorted(each.name for each in self.view.members.values())
        counts = (self.taken_over, self.handed_over, self.handed_on)
        return Standing(self.name, self.view.up, names, len(self._holds.rooms), *counts)

    # Being alive.

    async def run(self) -> None:
        """Be one of the servers until cancelled.

        Looks go by themselves: a ledger that takes its time must not cost this server its lease.
        """
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._again(self.beat))
            tasks.create_task(self._again(self._look, self._missed))

    async def _again(
        self, work: Callable[[], Awaitable[None]], early: Signal | None = None
    ) -> None:
        """Do this for ever, whatever becomes of it: at each beat, and when the signal is sent."""
        while True:
            began = self._clock()
            try:
                await work()
            except Exception:  # noqa: BLE001 - who is silent for a moment has no rooms
                _log.exception("the cluster cannot be looked after")
            rest = max(0.0, BEAT - (self._clock() - began))
            if early is None:
                await asyncio.sleep(rest)
            else:
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(early.wait(), rest)

    async def beat(self) -> None:
        """Say that this server is alive, and see who else is."""
        try:
            look = await self._leases.beat(self.me)
        except FAILURES as error:
            if self.view.up:
                _log.warning("the lease store is lost: rooms stay where they are: %s", error)
            self.view.failed()
            self._looked.send()
            return
        now = self._clock()
        self._doubtful = self._doubtful or now - self._beaten > LEASE
        self._beaten = now
        self.view.look(now, look)
        self._notice()
        for member in self.view.late(now):
            self._do(self._knock(member))

    async def _knock(self, member: Member) -> None:
        """See whether a server that is late has ended: then its rooms need not wait any longer."""
        if member.holder in self._knocking:
            return
        self._knocking.add(member.holder)
        try:
            if await self.line.is_refused_by(member):
                self.view.refused(member)
                self._notice()
        finally:
            self._knocking.discard(member.holder)

    def _notice(self) -> None:
        """Wake those who wait for what was seen now."""
        before, self._seen = self._seen, set(self.view.members)
        self._looked.send()
        if before - self._seen:
            self._missing = True
            self._missed.send()

    async def until_looked(self) -> None:
        """Return once it was seen anew who is alive, or that it cannot be seen."""
        await self._looked.wait()

    async def _look(self) -> None:
        """Give up what is another's by now, and take over what nobody has."""
        now = self._clock()
        try:
            if self._doubtful or not self.view.up:
                await self._check_holds()
                self._doubtful = False
            if self._is_due(now):
                self._swept = now
                await self._sweep(now)
        except LedgerError as error:
            _log.info("who has which room cannot be seen: %s", error)

    def _is_due(self, now: float) -> bool:
        """Whether it is time to look for rooms that nobody has: often, where somebody is gone."""
        missing, self._missing = self._missing, False
        return missing or self._orphans.waiting or now - self._swept >= _SWEEP

    async def _check_holds(self) -> None:
        """After a silence, others may have taken rooms; nothing more is told of these."""
        read = functools.partial(hold_store.held_by, holder=self._holds.holder)
        before = self._holds.rooms
        held = {row.room for row in await self._ledger.read(read)}
        for room_id in before:
            if room_id not in held and self._holds.of(room_id) is not None:
                self._holding.put_away(room_id)

    async def _sweep(self, now: float) -> None:
        if self.leaving or not self.view.sure:
            return
        # In this order: a room is held before it is in the ledger.
        awake = [MAIN, *(room.id for room in await self._ledger.read(store.awake_rooms))]
        rows = await self._holds.listing()
        for room_id in self._orphans.due(rows, awake, self.view, self.me.holder, now):
            self._do(self._take_over(room_id))

    async def _take_over(self, room_id: str) -> None:
        if room_id in self._taking or self.has(room_id):
            return
        self._taking.add(room_id)
        try:
            if await self._fetched(room_id) and self.has(room_id):
                self.taken_over += 1
                _log.warning("room taken over", extra={"room": room_id})
        finally:
            self._taking.discard(room_id)

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
                await self.until_looked()
            elif await self._fetched(room_id):
                return None
            else:
                await asyncio.sleep(_PAUSE)
        else:
            return None
        raise HoldLostError(f"room {shorten(room_id)} is on its way between servers", field="room")

    def _other(self, room_id: str, row: HoldRow | None) -> Member | None:
        """The server to ask for a room, if it is another one that is alive."""
        free = row is None or row.holder in ("", self._holds.holder)
        if free:
            member, until = self._sent.get(room_id, (None, 0.0))
            if member is not None and member.holder in self.view.members and self._clock() < until:
                return member
            # One that leaves takes nothing more: whoever comes need not wait until it is gone.
            return next(iter(order(room_id, self.others)), None) if self.leaving else None
        assert row is not None
        return self.view.members.get(row.holder)

    def _is_free(self, row: HoldRow | None) -> bool:
        """Whether this server may take a room of which the ledger says this."""
        if self.leaving and self.others:
            return False
        return (
            row is None or row.holder in ("", self._holds.holder) or self.view.is_gone(row.holder)
        )

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

    # Giving rooms away.

    async def move(self, room_id: str, to: str) -> Member:
        """Give a room that is here to the server of this name; raises InvalidValueError."""
        target = self.view.named(to)
        if target is None:
            names = ", ".join(sorted(each.name for each in self.view.members.values()))
            raise InvalidValueError(f"to={shorten(to)} is no server: there are {names}", field="to")
        if target.holder != self._holds.holder:
            await self._send(room_id, target)
        return target

    async def leave(self) -> None:
        """Give all rooms to the others, each from the very tick at which it is; then be gone."""
        self.leaving = True
        await self.beat()
        if others := self.others:
            watched = list(filter(self._watched, self._holds.rooms))
            unwatched = [room_id for room_id in self._holds.rooms if room_id not in watched]
            await self._send_all(unwatched, others, _AT_ONCE)
            await self._send_all(watched, others, 1)
        await self._holding.hand_all_over()
        await self.passed.close()

    async def _send_all(self, rooms: list[str], others: list[Member], at_once: int) -> None:
        turns = asyncio.Semaphore(at_once)

        async def send(room_id: str) -> None:
            async with turns:
                with contextlib.suppress(AppError):
                    await self._send(room_id, order(room_id, others)[0])

        await asyncio.gather(*map(send, rooms))

    async def gone(self) -> None:
        """This server has ended; nobody is to ask it any more."""
        with contextlib.suppress(*FAILURES):
            await self._leases.leave(self.me)
        await self._leases.close()
        await self.line.close()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _send(self, room_id: str, target: Member) -> None:
        now = self._clock()
        self._sent = {room: sent for room, sent in self._sent.items() if sent[1] > now}
        self._sent[room_id] = (target, now + _SENT)
        taking = functools.partial(self.line.have_taken, target, room_id)
        await self._holding.hand_over(room_id, taking)
        self.handed_over += 1
        _log.info("room handed over", extra={"room": room_id, "to": target.name})

    # The others.

    async def until_gone(self, member: Member) -> None:
        """Return when this server is gone."""
        while not self.view.is_gone(member.holder):
            await self._missed.wait()

    async def ask_all(self, path: str, part: str) -> list[Any]:
        """What each of the others lists as `part` of its answer to a GET of this path."""
        me = self._holds.holder
        others = [each for each in self.view.members.values() if each.holder != me]
        asked = (self.line.ask(each, path, part) for each in others)
        return list(await asyncio.gather(*asked))

    def _do(self, work: Any) -> None:
        task = asyncio.create_task(self._quietly(work))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _quietly(self, work: Any) -> None:
        try:
            await work
        except AppError as error:
            _log.info("put off: %s", error)
