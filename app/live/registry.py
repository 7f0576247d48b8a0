"""Every room of the server: opens, finds and closes them, and lets clients watch."""

import asyncio
import contextlib
import logging
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence

from app.errors import (
    AppError,
    ClosedRoomError,
    DamagedRoomError,
    LeaseLostError,
    LedgerError,
    RebuildingError,
    ResetError,
    UndecidedError,
)
from app.live.arriving import Arriving, Claim, any_room
from app.live.broadcast.audience import Means
from app.live.broadcast.hub import Client, Hub
from app.live.broadcast.presence import Presence
from app.live.halts import Halts
from app.live.leaving import Leaving
from app.live.live_room import Around, LiveRoom
from app.live.open_rooms import OpenRooms
from app.live.public_tables import MAIN, PublicTables
from app.live.shared_rooms import SharedRooms, UnsharedRooms
from app.live.ticking.runner import Runner, Running
from app.live.ticking.ticker import Watcher
from app.persistence.leases import Leases
from app.persistence.ledger.null_ledger import NullLedger
from app.persistence.recovery.rebuild_queue import RebuildQueue, Turn, rebuilding
from app.persistence.service import PersistenceService
from app.persistence.statements import queue_store, store
from app.rooms import kinds
from app.rooms.boards import Boards
from app.rooms.kinds import INDEPENDENT, SCENE, BallLimits, make_room
from app.rooms.records import Parked
from app.rooms.room import Basis, Room
from app.rooms.touching.scene import Scene
from app.rooms.touching.story import Retold
from app.settings import Settings
from engine import Board
from engine.errors import EffortError

_FAILED = "its room failed"
"""What the result of a drop says that was in flight then."""

_FOLLOW = 0.5  # s after which what another server has halted is halted here

_log = logging.getLogger("plinko")


class Rooms:
    """The rooms by id. All of it runs on the event loop's thread; nothing in it waits for a client.

    What must not be lost goes through `persistence`; without one nothing is kept. `draw` gives the
    seed of a drop that names none, `new_id` the id of a room that is made; `filmed` says whether a
    room is watched by others than the hub's clients.
    """

    def __init__(
        self,
        settings: Settings,
        boards: Boards,
        hub: Hub,
        main_board: Board,
        *,
        clock: Callable[[], float] = time.monotonic,
        draw: Callable[[], int] = lambda: secrets.randbits(64),
        new_id: Callable[[], str] = lambda: secrets.token_hex(8),
        watchers: Sequence[Watcher] = (),
        filmed: Callable[[str], bool] = lambda _: False,
        persistence: PersistenceService | None = None,
        claim: Claim = any_room,
    ) -> None:
        self.settings = settings
        self.hub = hub
        self.draw = draw
        self.limits = BallLimits(settings.max_balls, kinds.MAX_TOUCHING)
        self.persistence = persistence or PersistenceService(
            NullLedger(), tick_rate=settings.tick_rate, limits=self.limits
        )
        self.halts = Halts(self.persistence.ledger, self._tell_halts)
        self.runner = Runner(
            settings, self.persistence, clock=clock, watchers=watchers, failed=self._close
        )
        self.ticker = self.runner.ticker
        audiences = Means.of(hub, settings, clock, self.halts.holds, Presence(clock))
        self._around = Around(
            audiences, self.persistence, self.halts, self.runner, new_id, filmed, draw
        )
        self._open = OpenRooms(settings, self.persistence)
        self.rebuilding = RebuildQueue(self._rebuild)
        self.public = PublicTables(boards, main_board, self.scene)
        leases = self.persistence.leases
        self.shared = UnsharedRooms() if leases is None else self._share(leases, claim)
        self._new_id = new_id
        self._loading = asyncio.Lock()
        self._making: set[str | None] = set()  # keys of requests for rooms that are being opened
        if not self.persistence.ledger.keeps:
            self.find(MAIN)

    def _share(self, leases: Leases, claim: Claim) -> SharedRooms:
        """What this server does with rooms that others may have."""
        kept, rooms = self.persistence, self._open
        leaving = Leaving(leases, kept, rooms, self)
        arriving = Arriving(leases, claim, kept, rooms, self.public, self, self._new_aside, leaving)
        return SharedRooms(kept, rooms, self.public, leases, leaving, arriving)

    # Finding.

    def all(self) -> list[LiveRoom]:
        """Every open room in memory, the longest unused first."""
        self._open.close_idle()
        return list(self._open.in_memory.values())

    def parked(self) -> list[Parked]:
        """Every open room that is not in memory, the longest unused first."""
        self._open.close_idle()
        return list(self._open.parked.values())

    def is_open(self, room_id: str) -> bool:
        """Whether there is a room of this id, in memory, parked or on its way back."""
        return room_id in self._open or room_id in self.rebuilding

    @property
    def free(self) -> int:
        """How many more rooms players may open before one must make way."""
        return self._open.free

    def find(self, room_id: str) -> LiveRoom:
        """The room of this id; a preset's name opens its public table. Raises UnknownRoomError.

        RebuildingError for one that is on its way back, DamagedRoomError for one set aside.
        """
        live = self._open.get(room_id)
        if live is not None:
            return live
        self.persistence.recovery.check(room_id)
        if room_id in self.rebuilding:
            raise rebuilding(room_id)
        self.shared.check(room_id)
        ground, mode = self.public.find(room_id)
        row = self._open.parked_public.pop(room_id, None)
        back = None if row is None else self.persistence.recovery.restore(row, ground)
        return self.add(back or self._new(room_id, ground, mode))

    def scene(self, values: object) -> Scene:
        """The scene of a JSON object; raises InvalidValueError, SeedError."""
        most = kinds.MAX_TOUCHING
        return Scene.of(values, tick_rate=self.settings.tick_rate, max_balls=most)

    async def seek(self, room_id: str) -> LiveRoom:
        """`find`, in the ledger too. Raises UnknownRoomError, or LedgerError where it cannot tell.

        RoomLimitError when all rooms in memory are in use, DamagedRoomError for one set aside,
        RebuildingError for one that takes long to come back.
        """
        self._open.close_idle()
        await self.shared.fetch(room_id)
        await self.rebuilding.need(room_id)
        if room_id in self._open.parked:
            async with self._loading:
                if room_id in self._open.parked:
                    await self._load(room_id)
        live = self.find(room_id)
        with contextlib.suppress(LedgerError):  # then the next one who asks for the room tries it
            await live.queue.load()
        return live

    async def _load(self, room_id: str) -> None:
        """Take a parked room into memory; raises LedgerError, DamagedRoomError."""
        try:
            room = await self.persistence.recovery.load(room_id)
        except DamagedRoomError:
            self._open.parked.pop(room_id, None)
            raise
        # Unless it was closed meanwhile.
        if self._open.parked.pop(room_id, None) is not None and room is not None:
            self.add(room)

    async def _rebuild(self, room_id: str, turn: Turn) -> None:
        """Bring back a room that moved; raises LedgerError, DamagedRoomError."""
        ground = self.public.ground(room_id)
        room = await self.persistence.recovery.load(room_id, ground_now=ground, turn=turn)
        if room is not None:
            self.add(room)

    # Opening and closing.

    async def resume(self) -> None:
        """Go on where the last server ended; raises LedgerError when the ledger cannot be read.

        What moved then comes back one after another: see `rebuilding`.
        """
        left = await self.persistence.recovery.survey(self.public.ground)
        await self.halts.load()
        self._open.parked_public = left.public
        self._open.parked = OrderedDict((each.id, each) for each in left.owned)
        self.rebuilding.fill(sorted(left.moving, key=lambda each: each.id != MAIN))
        # Where it is set aside, or at another server, who asks for it is told.
        with contextlib.suppress(RebuildingError, DamagedRoomError, LeaseLostError):
            self.find(MAIN)

    async def follow(self) -> None:
        """Carry out what other servers do to all rooms, until cancelled."""
        while True:
            with contextlib.suppress(LedgerError):  # it is told of where something is to be done
                await self.halts.follow()
                await self.shared.look_after()
            await asyncio.sleep(_FOLLOW)

    async def go_on_with_queues(self) -> None:
        """Go on with what waits in rooms; for a server that has the ledger alone.

        Where servers share it, what waits goes on at the server that has the room, when somebody
        asks for the room.
        """
        try:
            waiting = await self.persistence.ledger.read(queue_store.waiting)
        except LedgerError as error:
            _log.warning("what waits goes on when somebody asks for its room: %s", error)
            return
        for room_id in waiting:
            try:
                await self.seek(room_id)
            except AppError as error:
                _log.warning("what waits does not go on: %s", error, extra={"room": room_id})

    def leave(self) -> None:
        """The server stops: hand the ledger what it needs to go on from here."""
        for live in self._open.in_memory.values():
            live.queue.end()
        self.persistence.leave(self.runner.close())

    async def made_by(self, creator: str) -> int | None:
        """How many open rooms bear this mark of who made them, at all servers of a shared ledger.

        None where this server alone knows. Raises LedgerError.
        """
        return await self.shared.made_by(creator)

    async def begun_by(self, key: str) -> LiveRoom | None:
        """The room that the request with this key has opened, if it is open still.

        Raises LedgerError, and UndecidedError while it is being opened.
        """
        if key in self._making:
            raise UndecidedError("the room is being opened", retry_after=1.0)
        if not self.persistence.ledger.keeps:
            return None
        room_id = await self.persistence.ledger.read(store.begun_by, key=key)
        return None if room_id is None else await self.seek(room_id)

    async def create(
        self,
        basis: Basis,
        mode: str = INDEPENDENT,
        creator: str | None = None,
        key: str | None = None,
    ) -> LiveRoom:
        """Open a room of its own over a board, scene or draw, by a mark of who made it, and a key.

        Raises RoomLimitError when all rooms are in use, LedgerError when it cannot be kept.
        """
        return await self.persistence.ledger.decided(self._create(basis, mode, creator, key))

    async def create_retold(
        self, retold: Retold, creator: str | None = None, key: str | None = None
    ) -> LiveRoom:
        """Open a room of its own where a story ends; raises what `create` raises."""
        work = self._create(retold.scene, SCENE, creator, key, retold)
        return await self.persistence.ledger.decided(work)

    async def delete(self, live: LiveRoom) -> None:
        """Close a room for good, with whatever falls in it; raises LedgerError, BusyError.

        Nothing is done then.
        """
        await self.persistence.ledger.decided(self._delete(live))

    async def reset(
        self, live: LiveRoom, board: Board | None = None, key: str | None = None
    ) -> None:
        """Begin a room anew, on another board if one is given; everyone there starts over.

        Raises LedgerError, BusyError, InvalidValueError where no board can be, ClosedRoomError
        where it was closed meanwhile; nothing is done then. Nor is it where it was begun with this
        `key`.
        """
        if key is not None and self.persistence.runs.of(live.room).key == key:
            return
        await self.persistence.ledger.decided(self._reset(live, board, key))

    async def _create(
        self,
        basis: Basis,
        mode: str,
        creator: str | None,
        key: str | None,
        retold: Retold | None = None,
    ) -> LiveRoom:
        await self.shared.make_place()
        self._open.make_place()
        room = await self._new_aside(self._new_id(), basis, mode)
        if retold is not None:
            await asyncio.to_thread(room.restore, retold.checkpoint)
        await self.shared.begin(room.id)
        taken = () if retold is None else retold.inputs
        counted = None if self.shared.alone else creator
        self._making.add(key)
        try:
            await self.persistence.create(room, counted, taken, key)
        finally:
            self._making.discard(key)
        return self.add(room)

    async def _delete(self, live: LiveRoom) -> None:
        async with live.ending() as settled:
            await self.persistence.end(live.room, settled)
        if live.gone is not None:
            return
        live.tell_settled(settled)
        error = ClosedRoomError(f"room {live.id!r} was closed by its creator")
        self._forget(live, error)
        self.hub.close(live.id, error)
        self.shared.let_go(live.id)
        _log.info("room closed", extra={"room": live.id, "why": "its creator"})

    async def _reset(self, live: LiveRoom, board: Board | None, key: str | None) -> None:
        old = live.room
        new = await self._new_aside(live.id, old.basis_after_reset(board), old.mode)
        async with live.ending() as settled:
            await self.persistence.replace(old, new, settled, key)
        if live.gone is not None:
            raise LeaseLostError(f"room {live.id!r} went to another server meanwhile", field="room")
        live.tell_settled(settled)
        live.begin_anew(new, ResetError(f"room {live.id!r} was reset by its creator"))

    def _close(self, failed: Running, why: Exception) -> None:
        """A room failed: what was in flight gets its stake back, and everyone is told."""
        live = self._open.in_memory[failed.id]
        reason = f": {why}" if isinstance(why, EffortError) else ""
        error = AppError(f"room {live.id!r} failed and was closed{reason}")
        live.give_up(_FAILED)
        self._forget(live, error)
        self.persistence.abandon(live.room, _FAILED)
        self.hub.close(live.id, error)
        self.shared.let_go(live.id)

    def drop_from_memory(self, live: LiveRoom, error: LeaseLostError) -> None:
        """Have a room no more that is another server's."""
        live.landings.leave()
        self._forget(live, error)
        self.persistence.runs.forget(live.room)

    def _forget(self, live: LiveRoom, error: AppError) -> None:
        del self._open.in_memory[live.id]
        live.leave(error)

    def send_away(self, room_id: str, error: LeaseLostError) -> None:
        """Have all who watch a room look for it elsewhere; nothing more is told them before."""
        self.hub.cut(room_id, error)

    def _tell_halts(self) -> None:
        for live in self.all():
            live.audience.tell_halt()

    def _new(self, room_id: str, basis: Basis, mode: str) -> Room:
        rate = self.settings.tick_rate
        return make_room(room_id, basis, mode, tick_rate=rate, limits=self.limits)

    async def _new_aside(self, room_id: str, basis: Basis, mode: str) -> Room:
        """`_new` on another thread: five hundred balls, or a large board, take some 5 ms."""
        return await asyncio.to_thread(self._new, room_id, basis, mode)

    def add(self, room: Room) -> LiveRoom:
        """Take a room into memory, and let it tick where something moves."""
        live = LiveRoom(room, self._around)
        self._open.add(live)
        _log.info("room opened", extra={"room": room.id, "board": room.origin.digest})
        return live

    # Those who watch.

    def enter(self, live: LiveRoom, client: Client) -> None:
        """Let a client watch: the full state first, then all that happens. Raises RoomFullError."""
        live.audience.enter(client)
        live.tell_waiting(client)
        live.wake()

    def exit(self, live: LiveRoom, client: Client) -> None:
        live.audience.leave(client)
        self._open.get(live.id)  # it was used until now

    def stop_waiting(self) -> None:
        """The server stops: who waits for a ball to land is told that it takes too long."""
        for live in self._open.in_memory.values():
            live.landings.leave()
