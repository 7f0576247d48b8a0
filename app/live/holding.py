"""The rooms of a ledger that several servers share: brought here, handed over, put away.

A room is at one server at a time. It is brought here when somebody asks for it here, or when the
server that had it is gone, and is rebuilt from what that one has written. It leaves in order, with
all that is known of it written down, or at once, when another server has taken it.
"""

import asyncio
import contextlib
import functools
import logging
import math
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine
from typing import Any, Final, Protocol

from app.concurrency.single_flight import SingleFlight
from app.errors import AppError, HoldLostError, LedgerError, UnknownRoomError
from app.live.live_room import LiveRoom
from app.live.open_rooms import OpenRooms
from app.live.public_tables import PublicTables
from app.live.to_the_end import to_the_end
from app.persistence.holds import Holds
from app.persistence.recovery.rebuild_queue import rebuilding
from app.persistence.service import PersistenceService
from app.persistence.statements import hold_store, store
from app.rooms.records import Hold, HoldRow, Listed, Parked
from app.rooms.room import Ground, Room
from app.settings import Settings

_PATIENCE: Final = 10.0  # s that someone waits for a room before hearing that it takes longer
_AT_ONCE: Final = 4  # rooms that are rebuilt at a time
_SETTLING: Final = (
    2.0  # s that drops which were taken may need to enter before a room is handed over
)
_LOOK_AFTER: Final = 60.0  # s between two looks for rooms that nobody uses
_FRESH: Final = 0.25  # s for which a room counts as here after a look; none is taken that fast
_LISTED: Final = 1.0  # s for which a list of all rooms is told again
_MOST: Final = 20  # of them closed at a time
_LOOK: Final = 0.005  # s between two looks at whether they have

_log = logging.getLogger("plinko")


class Memory(Protocol):
    """What is done with rooms in memory, by `Rooms`."""

    def add(self, room: Room) -> LiveRoom:
        """Take a room into memory."""

    def drop_from_memory(self, live: LiveRoom, error: HoldLostError) -> None:
        """Have a room no more: it ticks no more, and all who wait for something get `error`."""

    def send_away(self, room_id: str, error: HoldLostError) -> None:
        """Have all who watch a room look for it elsewhere."""


def _free(room_id: str, row: HoldRow | None) -> None:
    """Any room may be brought here, whoever has it."""


async def _to_nobody() -> None:
    """Nobody in particular is to go on with a room: whoever is asked for it does."""


class Holding:
    """For the event loop's thread.

    `claim` hears before a room is brought here because somebody asks for it, and who had it; it
    raises what stands in the way, or gives the number of the hold that this server's is to follow.
    `gone` are called with the id of a room that has left.
    """

    def __init__(
        self,
        settings: Settings,
        holds: Holds,
        persistence: PersistenceService,
        rooms: OpenRooms,
        public: PublicTables,
        memory: Memory,
        make: Callable[[str, Ground, str], Awaitable[Room]],
    ) -> None:
        self.holds = holds
        self.claim: Callable[[str, HoldRow | None], int | None] = _free
        self.gone: list[Callable[[str], None]] = []
        self._settings = settings
        self._persistence = persistence
        self._rooms = rooms
        self._public = public
        self._memory = memory
        self._make = make
        self._coming: dict[str, asyncio.Task[LiveRoom | None]] = {}
        self._leaving: dict[str, asyncio.Future[None]] = {}
        self._looks = SingleFlight[tuple[bool, int | None]]()  # for rooms that are not here
        self._confirming = SingleFlight[None]()  # that rooms are here still
        self._next_look = 0.0
        self._confirmed: dict[str, float] = {}  # when each room was known to be here, s
        self._listed: list[Listed] = []
        self._listed_at = -math.inf
        self._releasing: set[asyncio.Task[None]] = set()
        self._places = asyncio.Semaphore(_AT_ONCE)
        holds.lost = self.put_away
        rooms.left = self.let_go

    # Rooms come.

    async def fetch(self, room_id: str) -> None:
        """Have a room in memory, if there is one of this id; raises what `claim` raises.

        Also LedgerError, DamagedRoomError, RebuildingError when it takes too long to wait.
        """
        await self.until_left(room_id)
        if room_id in self._rooms.in_memory:
            await self._confirm(room_id)
        if room_id in self._rooms.in_memory:
            return
        self._persistence.recovery.check(room_id)
        exists, after = True, None
        if room_id not in self._coming:
            look = functools.partial(self._look_for, room_id)
            exists, after = await self._looks.do(room_id, look)
        if exists:
            await self.take_over(room_id, after)

    async def _look_for(self, room_id: str) -> tuple[bool, int | None]:
        """Whether there is a room, and what `claim` says of it."""
        read = functools.partial(hold_store.standing, room=room_id)
        exists, row = await self._persistence.ledger.read(read)
        exists = exists or room_id in self._public
        return exists, self.claim(room_id, row) if exists else None

    async def _confirm(self, room_id: str) -> None:
        """Put a room away that another server has taken: nobody comes to it here any more.

        A server that was frozen would show who has been there what is over. While the ledger cannot
        be read nothing is known to be wrong.
        """
        now = asyncio.get_running_loop().time()
        if now - self._confirmed.get(room_id, -math.inf) < _FRESH:
            return
        hold = self.holds.of(room_id)
        try:
            await self._confirming.do(room_id, functools.partial(self.holds.confirm, room_id))
        except HoldLostError:
            if self.holds.of(room_id) == hold:  # else it left meanwhile, and may be back
                self.put_away(room_id)
        except LedgerError as error:
            _log.info("it is not seen who has a room: %s", error, extra={"room": room_id})
        else:
            self._confirmed[room_id] = now

    async def begin(self, room_id: str) -> None:
        """Have a room that nobody had: its id is new; raises what `claim` raises, LedgerError."""
        row = await self.holds.holder_of(room_id)
        await self.holds.take(room_id, self.claim(room_id, row))

    def away(self, room_id: str) -> HoldLostError:
        """What there is to say of a public room that is not in memory."""
        return HoldLostError(f"room {room_id!r} is not at this server", field="room")

    async def take_over(self, room_id: str, after: int | None = None) -> LiveRoom | None:
        """Have a room here from now on, whoever had it; None where there is no such room.

        `after` as for `Holds.take`. Raises HoldLostError, LedgerError, DamagedRoomError, and
        RebuildingError when it takes too long to wait.
        """
        live = self._rooms.in_memory.get(room_id)
        if live is not None:
            return live
        if room_id not in self._coming:
            self._begin(room_id, self._bring(room_id, after))
        try:
            async with asyncio.timeout(_PATIENCE):
                return await asyncio.shield(self._coming[room_id])
        except TimeoutError:
            raise rebuilding(room_id) from None

    def _begin(self, room_id: str, work: Coroutine[Any, Any, LiveRoom | None]) -> None:
        """Do something with a room that is not in memory; whoever asks for it waits meanwhile."""
        task = self._coming[room_id] = asyncio.create_task(work, name=room_id)
        task.add_done_callback(functools.partial(self._came, room_id))

    async def _bring(self, room_id: str, after: int | None) -> LiveRoom | None:
        await self.holds.take(room_id, after)
        try:
            async with self._places:
                room = await self._load(room_id)
        except BaseException:
            self._lose(room_id)
            raise
        if self.holds.of(room_id) is None:
            raise HoldLostError(f"room {room_id!r} was taken by another server", field="room")
        if room is None:
            self.let_go(room_id)
            return None
        return self._memory.add(room)

    async def _load(self, room_id: str) -> Room | None:
        ground = self._public.ground(room_id)
        room = await self._persistence.recovery.load(room_id, ground_now=ground)
        if room is None and ground is not None:
            room = await self._make(room_id, *self._public.find(room_id))
        return room

    def _came(self, room_id: str, task: "asyncio.Task[LiveRoom | None]") -> None:
        del self._coming[room_id]
        if not task.cancelled() and task.exception() is not None:
            _log.info("room stays away: %s", task.exception(), extra={"room": room_id})

    @contextlib.asynccontextmanager
    async def having(self, room_id: str) -> AsyncIterator[None]:
        """Have a room here for a while, even one that is closed; raises what `fetch` raises."""
        await self.fetch(room_id)
        if room_id in self._rooms.in_memory:
            yield
            return
        await self.begin(room_id)
        try:
            yield
        finally:
            if room_id not in self._rooms.in_memory:
                self.let_go(room_id)

    # Rooms wherever they are.

    async def directory(self) -> list[Listed]:
        """Every open room at any server, as the ledger last heard of it; raises LedgerError."""
        now = self._persistence.now()
        if not self._listed_at <= now < self._listed_at + _LISTED:
            self._listed = await self._persistence.ledger.read(store.directory)
            self._listed_at = now
        return self._listed

    # Rooms of players that nobody uses.

    async def made_by(self, creator: str) -> int:
        """How many open rooms bear this mark of who made them; raises LedgerError."""
        await self._count()
        read = functools.partial(store.count_owned, creator=creator)
        return await self._persistence.ledger.read(read)

    async def make_place(self) -> None:
        """Count players' rooms at all servers before another is made; raises LedgerError.

        With as many as there may be the longest unused one is closed, as `OpenRooms` would.
        """
        await self._count()
        if self._rooms.free == 0:
            await self._close_unused(self._settings.room_rest, "room for another", 1)
            await self._count()

    async def look_after(self) -> None:
        """Now and then, close the rooms that nobody has used for too long; raises LedgerError."""
        now = self._persistence.now()
        if now >= self._next_look:
            self._next_look = now + _LOOK_AFTER
            await self._close_unused(self._settings.room_idle, "unused", _MOST)

    async def _count(self) -> None:
        everywhere = await self._persistence.ledger.read(store.count_owned)
        self._rooms.elsewhere = max(0, everywhere - self._rooms.owned)

    async def _close_unused(self, seconds: float, why: str, most: int) -> None:
        before = self._persistence.now() - seconds
        read = functools.partial(store.unused_rooms, before=before, limit=most)
        for room in await self._persistence.ledger.read(read):
            if room.id in self._rooms.in_memory or room.id in self._coming:
                continue
            self._begin(room.id, self._close(room, before, why))
            with contextlib.suppress(AppError):  # another server has it, and so it is in use
                await asyncio.shield(self._coming[room.id])

    async def _close(self, room: Parked, before: float, why: str) -> None:
        await self.begin(room.id)
        try:
            read = functools.partial(store.open_session, number=room.number)
            row = await self._persistence.ledger.read(read)
            if row is not None and not row.awake and row.used < before:
                self._persistence.close(room)
                _log.info("room closed", extra={"room": room.id, "why": why})
        finally:
            self.let_go(room.id)

    # Rooms leave.

    def check(self, room_id: str) -> None:
        """Raise HoldLostError for a room that takes nothing more here."""
        if room_id in self._leaving:
            raise self._going(room_id)

    def _going(self, room_id: str) -> HoldLostError:
        return HoldLostError(f"room {room_id!r} is going to another server", field="room")

    def is_leaving(self, room_id: str) -> bool:
        """Whether a room is on its way to another server."""
        return room_id in self._leaving

    async def until_left(self, room_id: str) -> None:
        """Return once a room that is on its way to another server is there; at once for others."""
        if room_id in self._leaving:
            await asyncio.wait([self._leaving[room_id]])

    async def hand_over(
        self, room_id: str, receive: Callable[[], Awaitable[None]] = _to_nobody
    ) -> None:
        """Let a room go on at another server, from the very tick at which it is here.

        What was taken enters first. Then `receive` has the other server take the room, and only
        when it returns are those who watch sent there: they need not wait for it again and again.
        Raises UnknownRoomError, and LedgerError where it could not be told all; the room is gone
        from here then as well.
        """
        if room_id not in self._rooms.in_memory:
            raise UnknownRoomError(f"room {room_id!r} is not at this server", field="room")
        await to_the_end(self._hand_over(room_id, receive))

    async def hand_all_over(self) -> None:
        """Let all rooms go; those of which the ledger cannot be told now are gone from here too."""
        rooms = [to_the_end(self._hand_over(room_id)) for room_id in self._rooms.in_memory]
        await asyncio.gather(*rooms, return_exceptions=True)

    async def _hand_over(
        self, room_id: str, receive: Callable[[], Awaitable[None]] = _to_nobody
    ) -> None:
        if room_id in self._leaving:
            await self.until_left(room_id)
            return
        away = HoldLostError(f"room {room_id!r} goes on at another server", field="room")
        gone = self._leaving[room_id] = asyncio.get_running_loop().create_future()
        try:
            live = self._rooms.in_memory.get(room_id)
            if live is None:
                return
            with live.taking_nothing(self._going(room_id)):
                await self._settle(live)
            if live.gone is not None:
                return
            self._persistence.leave([live.room] if live.room.awake else [])
            hold = self.holds.drop(room_id)
            self._memory.drop_from_memory(live, away)
            if hold is not None:
                await self.holds.release(hold)
            await receive()
        finally:
            del self._leaving[room_id]
            if room_id not in self._rooms.in_memory:
                self._memory.send_away(room_id, away)
            self._tell_gone(room_id)
            gone.set_result(None)

    async def _settle(self, live: LiveRoom) -> None:
        """Wait until what was taken has entered; what has not is in the ledger all the same."""
        clock = asyncio.get_running_loop().time
        end = clock() + _SETTLING
        while clock() < end and live.gone is None and live.room.planned:
            await asyncio.sleep(_LOOK)

    def let_go(self, room_id: str) -> None:
        """A room has left the memory, and all of it is written: any server may have it."""
        hold = self.holds.drop(room_id)
        if hold is not None:
            task = asyncio.create_task(self._release(hold), name=room_id)
            self._releasing.add(task)
            task.add_done_callback(self._releasing.discard)
        self._tell_gone(room_id)

    async def _release(self, hold: Hold) -> None:
        try:
            await self.holds.release(hold)
        except LedgerError as error:
            _log.info("a room is not released: %s", error, extra={"room": hold.room})

    def put_away(self, room_id: str) -> None:
        """A room is another server's: nothing more is told of it, nor written."""
        self.holds.drop(room_id)
        live = self._rooms.in_memory.get(room_id)
        if live is not None:
            away = HoldLostError(f"room {room_id!r} is at another server now", field="room")
            self._memory.send_away(room_id, away)
            self._memory.drop_from_memory(live, away)
        self._tell_gone(room_id)

    def _lose(self, room_id: str) -> None:
        self.holds.drop(room_id)
        self._tell_gone(room_id)

    def _tell_gone(self, room_id: str) -> None:
        self._confirmed.pop(room_id, None)
        for tell in self.gone:
            tell(room_id)
