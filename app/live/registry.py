"""The registry of a server's rooms: finds, opens, resets and closes them, and lets clients in."""

import asyncio
import contextlib
import logging
import secrets
import time
from collections.abc import Callable, Sequence

from plinko.app.errors import (
    AppError,
    ClosedRoomError,
    DamagedRoomError,
    LeaseLostError,
    LedgerError,
    ResetError,
    UnknownRoomError,
)
from plinko.app.live.arriving import Claim, any_room
from plinko.app.live.broadcast.audience import AudienceContext
from plinko.app.live.broadcast.hub import Client, Hub
from plinko.app.live.live_room import LiveRoom, RoomContext
from plinko.app.live.open_rooms import OpenRooms
from plinko.app.live.orders import Orders
from plinko.app.live.public_tables import MAIN, PublicTables
from plinko.app.live.stored_rooms import SEARCH_SECONDS, StoredRooms
from plinko.app.live.ticking.runner import Runner, Running
from plinko.app.live.ticking.ticker import Ticked
from plinko.app.persistence.service import PersistenceService
from plinko.app.persistence.statements import store
from plinko.app.protocol import messages
from plinko.app.rooms import kinds
from plinko.app.rooms.boards import Boards
from plinko.app.rooms.keys import KeyUse
from plinko.app.rooms.kinds import INDEPENDENT
from plinko.app.rooms.records import ResultRow
from plinko.app.rooms.room import Basis
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.rooms.touching.scene import Scene
from plinko.app.rooms.touching.story import Retold
from plinko.app.settings import TICK_RATE, Settings
from plinko.engine import Board
from plinko.engine.errors import EffortError

_FAILED = "its room failed"
"""Why drops whose flights were not known have no bin, in their results."""

_FOLLOW = 0.5  # s between two readings of other servers' orders from the ledger

_log = logging.getLogger("plinko")


class Rooms:
    """The rooms by id. For the event loop's thread; no method waits for a client.

    persistence: keeps what must survive the server.
    draw: returns a random seed, for a drop that has none.
    new_id: makes the id of a new room.
    filmed: whether a room is watched by others than the hub's clients.
    claim: decides whether this server may take a room from another.
    """

    def __init__(
        self,
        settings: Settings,
        boards: Boards,
        hub: Hub,
        main_board: Board,
        persistence: PersistenceService,
        *,
        clock: Callable[[], float] = time.monotonic,
        draw: Callable[[], int] = lambda: secrets.randbits(64),
        new_id: Callable[[], str] = lambda: secrets.token_hex(8),
        ticked: Sequence[Ticked] = (),
        filmed: Callable[[str], bool] = lambda _: False,
        claim: Claim = any_room,
    ) -> None:
        self.settings = settings
        self.hub = hub
        self.draw = draw
        self.persistence = persistence
        now = self.persistence.now
        self.orders = Orders(self.persistence.ledger, self._tell_orders, now)
        self.runner = Runner(settings, clock=clock, now=now, ticked=ticked, failed=self._close)
        self.ticker = self.runner.ticker
        audiences = AudienceContext.of(hub, settings, clock, self.orders)
        self._open = OpenRooms(
            RoomContext(audiences, persistence, self.orders, self.runner, new_id, filmed, draw)
        )
        self.public = PublicTables(boards, main_board, self.scene)
        self.stored = StoredRooms(
            self.persistence, self._open, self.public, claim, settings.max_rooms
        )
        self._new_id = new_id

    # Finding.

    def all(self) -> list[LiveRoom]:
        """Every open room in memory, the longest unused first."""
        return list(self._open.in_memory.values())

    def is_open(self, room_id: str) -> bool:
        """Whether a room with this id is in memory."""
        return room_id in self._open.in_memory

    def find(self, room_id: str) -> LiveRoom:
        """The room with this id, if it is in memory.

        Raises UnknownRoomError, DamagedRoomError for one that recovery has set aside, and
        LeaseLostError for one that moves to another server, or is perhaps at another.
        """
        live = self._open.get(room_id)
        if live is not None:
            return live
        self.persistence.recovery.check(room_id)
        self.stored.check(room_id)
        self.public.find(room_id)
        raise UnknownRoomError(f"room {room_id!r} is not in memory", field="room")

    def scene(self, values: object) -> Scene:
        """Parse a scene; raises InvalidValueError, SeedError."""
        most = kinds.MAX_TOUCHING
        return Scene.of(values, tick_rate=TICK_RATE, max_balls=most)

    async def seek(self, room_id: str) -> LiveRoom:
        """Find a room, in memory or in the ledger, and bring it into memory.

        Raises UnknownRoomError, LedgerError if the ledger cannot be read, RebuildingError for
        touching balls that take long to replay, and DamagedRoomError for a room that is set aside.
        """
        await self.stored.arriving.fetch(room_id)
        live = self.find(room_id)
        with contextlib.suppress(LedgerError):  # the next request for the room tries again
            await live.queue.load()
        return live

    # Opening and closing.

    async def resume(self) -> None:
        """Continue where the last server stopped; raises LedgerError if the ledger is unreadable.

        Only `main` is loaded now. Every other room is when it is first asked for, or by `go_on`.
        """
        await self.persistence.recovery.prepare()
        await self.orders.load()
        # If `main` cannot be opened now, clients that ask for it get the error.
        if self.stored.alone:
            with contextlib.suppress(DamagedRoomError):
                await self.seek(MAIN)

    async def follow(self) -> None:
        """Go on with the last server's rooms, or follow other servers; close unused rooms.

        Until cancelled.
        """
        if self.stored.alone:
            await self.go_on()
        while True:
            with contextlib.suppress(LedgerError):  # requests report it; this tries again
                if not self.stored.alone:
                    await self.orders.follow()
                await self.stored.renew()
            # A server whose rooms sleep hardly wakes up.
            await asyncio.sleep(SEARCH_SECONDS if self.stored.alone else _FOLLOW)

    async def go_on(self) -> None:
        """Load all rooms in which something moved when the last server ended, or a queue waits.

        Their balls then land without a client, and get their results. On a shared ledger the server
        that takes over a room does this.
        """
        read = self.persistence.ledger.read
        try:
            waiting = [*await read(store.awake_rooms), *await read(store.rooms_with_queues)]
        except LedgerError as error:
            _log.warning("cannot list the rooms that go on; each does when it is used: %s", error)
            return
        for room_id in dict.fromkeys(waiting):
            try:
                await self.seek(room_id)
            except AppError as error:
                _log.warning("a room cannot go on: %s", error, extra={"room": room_id})

    def leave(self) -> None:
        """At the server's stop: end all queues, and commit where each awake room stands."""
        for live in self._open.in_memory.values():
            live.queue.end()
        self.persistence.leave(self.runner.close())

    async def opened_by(self, use: KeyUse) -> LiveRoom | None:
        """The room that an earlier request has opened, if this one is a repeat.

        Raises KeyReusedError, ClosedRoomError if it was closed since, LedgerError, UndecidedError.
        """
        return await self.persistence.ledger.decided(self._opened_by(use))

    async def _opened_by(self, use: KeyUse) -> LiveRoom | None:
        found = await self.persistence.ledger.look_up(use)
        if found is None:
            return None
        try:
            return await self.seek(found.fact)
        except UnknownRoomError as error:
            what = f"room {found.fact!r}, which was opened with this key, was closed"
            raise ClosedRoomError(f"{what}; use a new key to open another", field="key") from error

    async def create(
        self,
        basis: Basis,
        mode: str = INDEPENDENT,
        creator: str | None = None,
        use: KeyUse | None = None,
        retold: Retold | None = None,
    ) -> LiveRoom:
        """Open a room with an owner, for a board, scene or draw.

        creator: identifies the owner, to count their rooms.
        use: of the request's key; if it is not new, the result is the first request's room.
        retold: the story in whose final state the room begins.
        Raises RoomLimitError when all rooms are in use, KeyReusedError, LedgerError if it cannot be
        committed.
        """
        work = self._create(basis, mode, creator, use or KeyUse(), retold)
        return await self.persistence.ledger.decided(work)

    async def delete(self, live: LiveRoom, by: str = "its creator") -> None:
        """Close a room for good, with all balls in it; `by` is for its clients.

        Raises LedgerError; the room then goes on.
        """
        await self.persistence.ledger.decided(self._delete(live, by))

    async def reset(
        self, live: LiveRoom, board: Board | None = None, use: KeyUse | None = None
    ) -> None:
        """Restart a room, with another board if one is given; all its clients start over.

        Does nothing if the `use` of the request's key is not new. Raises KeyReusedError,
        LedgerError, InvalidValueError if the room cannot have that board, and ClosedRoomError if it
        was closed meanwhile; an error leaves the room unchanged.
        """
        await self.persistence.ledger.decided(self._reset(live, board, use or KeyUse()))

    async def _create(
        self,
        basis: Basis,
        mode: str,
        creator: str | None,
        use: KeyUse,
        retold: Retold | None,
    ) -> LiveRoom:
        await self.stored.make_place()
        room = await self._open.make(self._new_id(), basis, mode)
        if retold is not None:
            assert isinstance(room, TouchingRoom)
            await asyncio.to_thread(room.restore, retold.checkpoint)
        await self.stored.arriving.begin(room.id)
        inputs = () if retold is None else retold.inputs
        await self.persistence.create(room, creator, inputs, use)
        if use.earlier is None:
            return self._open.add(room)
        self.stored.let_go(room.id)
        found = await self._opened_by(use)
        assert found is not None
        return found

    async def _delete(self, live: LiveRoom, by: str) -> None:
        async with live.ending() as results:
            await self.persistence.end(live.room, results)
        if live.gone is not None:
            return
        live.land_all()
        error = ClosedRoomError(f"room {live.id!r} was closed by {by}")
        self._open.remove(live, error)
        self.hub.close(live.id, error)
        self.stored.let_go(live.id)
        _log.info("room closed", extra={"room": live.id, "why": by})

    async def _reset(self, live: LiveRoom, board: Board | None, use: KeyUse) -> None:
        if await self.persistence.ledger.look_up(use):
            return
        old = live.room
        new = await self._open.make(live.id, old.basis_after_reset(board), old.mode)
        async with live.ending() as results:
            await self.persistence.replace(old, new, results, use)
        if use.earlier is not None:
            return
        if live.gone is not None:
            raise LeaseLostError(f"room {live.id!r} moved to another server", field="room")
        live.land_all()
        live.restart(new, ResetError(f"room {live.id!r} was reset by its creator"))

    def _close(self, failed: Running, why: Exception) -> None:
        """Close a room that has failed, with the results that its facts have, and tell its clients.

        The stakes of drops whose flights are not known are paid back.
        """
        live = self._open.in_memory[failed.id]
        reason = f": {why}" if isinstance(why, EffortError) else ""
        error = AppError(f"room {live.id!r} failed and was closed{reason}")
        results: Sequence[ResultRow] = ()
        with contextlib.suppress(Exception):  # perhaps the room failed because this does
            results = live.open_results()
            live.land_all()
        self.persistence.abandon(live.room, results, _FAILED)
        self._open.remove(live, error)
        self.hub.close(live.id, error)
        self.stored.let_go(live.id)

    def _tell_orders(self) -> None:
        for live in self.all():
            live.audience.tell_orders()

    def tell_leaving(self) -> None:
        """Tell all clients that this server is about to stop."""
        for live in self._open.in_memory.values():
            live.audience.notify(messages.Notice(text=self.orders.notice, leaving=True))

    # Clients.

    def enter(self, live: LiveRoom, client: Client) -> None:
        """Let a client watch: it gets the full state, then all events. Raises RoomFullError."""
        live.wake()  # before the hello: another server may have shown the present tick
        live.audience.enter(client)
        live.tell_waiting(client)

    def exit(self, live: LiveRoom, client: Client) -> None:
        live.audience.leave(client)
        self._open.get(live.id)  # counts as use

    def stop_waiting(self) -> None:
        """At the server's stop: answer requests that wait for a landing as if they timed out."""
        for live in self._open.in_memory.values():
            live.landings.leave()
