"""Every room of the server: opens, finds and ticks them, and sends what comes out of them."""

import asyncio
import functools
import itertools
import logging
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, cast

from app.errors import (
    AppError,
    ClosedRoomError,
    InvalidValueError,
    LedgerError,
    ResetError,
    RoomLimitError,
    UnknownRoomError,
    shorten,
)
from app.live.broadcaster import Giver, Teller
from app.live.hub import Client, Hub
from app.live.ticker import Schedule, Ticker, Watcher
from app.persistence.service import Keeper
from app.persistence.unkept import Unkept
from app.protocol import messages
from app.rooms.boards import Boards
from app.rooms.independent import DropCommand, Plan
from app.rooms.kinds import (
    INTERACTING,
    MODE,
    SCENE,
    AnyRoom,
    ArenaRoom,
    BallLimits,
    Ground,
    make_room,
)
from app.rooms.records import Parked, RoomRow
from app.rooms.touching.room import ArenaCommand, InputPlan
from app.rooms.touching.scene import GALTON, SANDBOX, Scene
from app.settings import Settings
from engine import Board, preset_names

MAIN = "main"  # the room that is always there

PUBLIC_SCENES = {"sandbox": SANDBOX, "galton-pile": GALTON}
"""Rooms of scenes that are always there, open to everybody."""

TOUCHING = "interacting-"
"""Before a preset's name: the public table on which balls knock each other."""

_IN_MEMORY = 256  # rooms; beyond that, those that nobody needs now are parked

_log = logging.getLogger("plinko")


@dataclass(frozen=True, slots=True)
class _Ask(Giver):
    """Who waits to hear what becomes of a drop or a change."""

    accepted: "asyncio.Future[messages.Event | None]"


class Rooms:
    """The rooms by id. All of it runs on the event loop's thread; nothing in it waits for a client.

    What must not be lost goes through the `keeper`; without one nothing is kept. Rooms that nobody
    needs now are parked: a line in memory, the rest in the ledger. `draw` gives
    the seed of a drop that names none, `new_id` the id of a room that is made.
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
        keeper: Keeper | None = None,
    ) -> None:
        self.settings = settings
        self.ball_limits = BallLimits(settings.max_balls, settings.max_touching)
        self.keeper = keeper or Keeper(
            Unkept(), tick_rate=settings.tick_rate, limits=self.ball_limits
        )
        self.hub = hub
        self.in_use: Callable[[str], bool] = lambda _: False  # watched by others than the hub's
        self.clock = clock
        self.teller = Teller(hub, settings, clock)
        self.ticker = Ticker(
            Schedule(1.0 / settings.tick_rate, settings.max_catch_up),
            self._tick,
            clock=clock,
            watchers=watchers,
        )
        self.accepted = 0  # drops, in all rooms there ever were
        self.landed = 0
        self._boards = boards
        self._draw = draw
        self._new_id = new_id
        self._rooms: OrderedDict[str, AnyRoom] = OrderedDict()  # the longest unused first
        self._awake: dict[str, AnyRoom] = {}
        self._waiting: dict[tuple[str, int], list[asyncio.Future[messages.Landed]]] = {}
        self._main_board = main_board
        self._public: dict[str, RoomRow] = {}  # presets' rooms and main, while they are parked
        self._parked: OrderedDict[str, Parked] = OrderedDict()  # those with owners; as _rooms
        self._loading = asyncio.Lock()
        if not self.keeper.keeps:
            self.find(MAIN)

    def all(self) -> list[AnyRoom]:
        """Every open room in memory, the longest unused first."""
        self._close_idle()
        return list(self._rooms.values())

    @property
    def awake(self) -> list[AnyRoom]:
        """The rooms in which something moves."""
        return list(self._awake.values())

    def parked(self) -> list[Parked]:
        """Every open room that is not in memory, the longest unused first."""
        self._close_idle()
        return list(self._parked.values())

    def is_open(self, room_id: str) -> bool:
        """Whether there is a room of this id, in memory or parked."""
        return room_id in self._rooms or room_id in self._parked

    def find(self, room_id: str) -> AnyRoom:
        """The room of this id; a preset's name opens its public table. Raises UnknownRoomError."""
        room = self._rooms.get(room_id)
        if room is not None:
            self._rooms.move_to_end(room_id)
            self.keeper.touch(room)
            return room
        if room_id == MAIN:
            return self._open_public(MAIN, self._main_board, MODE)
        if room_id in preset_names():
            return self._open_public(room_id, self._boards.find(room_id), MODE)
        if room_id in PUBLIC_SCENES:
            return self._open_public(room_id, self.scene({"scene": PUBLIC_SCENES[room_id]}), SCENE)
        preset = room_id.removeprefix(TOUCHING)
        if preset != room_id and preset in preset_names():
            return self._open_public(room_id, self._boards.find(preset), INTERACTING)
        raise UnknownRoomError(
            f"room {shorten(room_id)} is neither open nor the name of a preset board", field="room"
        )

    def scene(self, values: object) -> Scene:
        """The scene of a JSON object; raises InvalidValueError, SeedError."""
        most = self.settings.max_touching
        return Scene.of(values, tick_rate=self.settings.tick_rate, max_balls=most)

    async def seek(self, room_id: str) -> AnyRoom:
        """`find`, in the ledger too. Raises UnknownRoomError, or LedgerError where it cannot tell.

        RoomLimitError when all rooms in memory are in use.
        """
        self._close_idle()
        if room_id in self._parked:
            async with self._loading:
                if room_id in self._parked:
                    room = await self.keeper.load(room_id)
                    # Unless it was closed meanwhile.
                    if self._parked.pop(room_id, None) is not None and room is not None:
                        self._add(room)
        return self.find(room_id)

    async def resume(self) -> None:
        """Go on where the last server ended; raises LedgerError when the ledger cannot be read."""
        for room in await self.keeper.resume():
            self._add(room)
        self._public = await self.keeper.public()
        self._parked = OrderedDict((room.id, room) for room in await self.keeper.parked())
        for room_id in self._rooms:
            self._public.pop(room_id, None)
            self._parked.pop(room_id, None)
        self.find(MAIN)
        if self._awake:
            self.ticker.wake()

    def leave(self) -> None:
        """The server stops: hand the ledger what it needs to go on from here."""
        self.keeper.leave(self._awake.values())

    async def create(self, ground: Ground, mode: str = MODE) -> AnyRoom:
        """Open a room of its own over a board or a scene.

        Raises RoomLimitError when all rooms are in use, LedgerError when it cannot be kept.
        """
        self._make_place()
        room = self._new(self._new_id(), ground, mode)
        await self.keeper.found(room)
        return self._add(room)

    def enter(self, room: AnyRoom, client: Client) -> None:
        """Let a client watch: the full state first, then all that happens. Raises RoomFullError."""
        self.hub.join(room.id, client)
        self._greet(room, client)

    def owned(self, room: AnyRoom) -> bool:
        """Whether the room has a creator, who alone may change it."""
        return self.keeper.book(room).owned

    async def delete(self, room: AnyRoom) -> None:
        """Close a room for good, with whatever falls in it; raises LedgerError, nothing done."""
        await self.keeper.end(room)
        self._leave_behind(room, ClosedRoomError(f"room {room.id!r} was closed by its creator"))
        del self._rooms[room.id]
        self.teller.forget(room.id)
        self.hub.close(room.id, ClosedRoomError(f"room {room.id!r} was closed by its creator"))
        _log.info("room closed", extra={"room": room.id, "why": "its creator"})

    async def reset(self, room: AnyRoom, board: Board | None = None) -> AnyRoom:
        """Begin a room anew, on another board if one is given; everyone there starts over.

        Raises LedgerError, nothing done.
        """
        if board is not None and room.mode == SCENE:
            raise InvalidValueError(f"room {room.id!r} is a scene without a board", field="board")
        new = self._new(room.id, board or room.board, room.mode)
        await self.keeper.replace(room, new)
        self._leave_behind(room, ResetError(f"room {room.id!r} was reset by its creator"))
        self._rooms[room.id] = new
        self.teller.begin(new, self._new_id())
        self._rouse(new)
        for client in self.hub.clients(room.id):
            self._greet(new, client)
        return new

    def _leave_behind(self, room: AnyRoom, error: AppError) -> None:
        """Tell all who wait for something in this room that it will not come."""
        self._awake.pop(room.id, None)
        for key in [key for key in self._waiting if key[0] == room.id]:
            for future in self._waiting.pop(key):
                if not future.done():
                    future.set_exception(error)
        for plan in room.planned:
            if not plan.note.accepted.done():
                plan.note.accepted.set_exception(error)

    def _greet(self, room: AnyRoom, client: Client) -> None:
        """Give a client the full state to start from."""
        if isinstance(room, ArenaRoom):
            room.owned = self.owned(room)
        self.teller.greet(room, client)

    def drop(
        self,
        room: AnyRoom,
        seed: int | None,
        x: float | None,
        *,
        stake: int = 0,
        who: str | None = None,
        client: int | None = None,
        key: str = "",
        ref: Any = None,
    ) -> "asyncio.Future[messages.Accepted]":
        """Take a drop; once it is durable and its tick has come, it enters and the room is told.

        The future then has the event, whose `ref` goes to `client` alone, or the LedgerError that
        came in between. Raises BallLimitError, LedgerError and the engine's errors.
        """
        command = DropCommand(self._draw() if seed is None else seed, x, stake, who)
        asked = self._ask(room, room.plan(command, self.keeper.lead), client, ref, key)
        return cast("asyncio.Future[messages.Accepted]", asked)

    def change(
        self,
        room: ArenaRoom,
        data: dict[str, Any],
        *,
        client: int | None = None,
        key: str = "",
        ref: Any = None,
    ) -> "asyncio.Future[messages.Event | None]":
        """Take an input of a room whose balls touch each other, as `drop` takes a drop.

        The future has the first event that came of it, if any. Raises InvalidValueError,
        BallLimitError, LedgerError.
        """
        return self._ask(room, room.plan(ArenaCommand(data), self.keeper.lead), client, ref, key)

    def _ask(
        self, room: AnyRoom, plan: Plan | InputPlan, client: int | None, ref: Any, key: str
    ) -> "asyncio.Future[messages.Event | None]":
        accepted: asyncio.Future[messages.Event | None] = asyncio.get_running_loop().create_future()
        plan.note = _Ask(client, key, ref, accepted)
        try:
            self.keeper.submit(room, plan, functools.partial(self._kept, room, plan))
        except LedgerError:
            room.refuse(plan)  # type: ignore[arg-type]
            raise
        return accepted

    def _kept(self, room: AnyRoom, plan: Plan | InputPlan, error: LedgerError | None) -> None:
        """A planned drop is in the ledger, or will not be."""
        if self._rooms.get(room.id) is not room:
            error = error or LedgerError(f"room {room.id!r} was closed before the drop was kept")
        if error is None:
            plan.durable = True
            self._admit(room)
            return
        room.refuse(plan)  # type: ignore[arg-type]
        if not plan.note.accepted.done():
            plan.note.accepted.set_exception(error)

    def _admit(self, room: AnyRoom) -> None:
        """Let in what is planned for this tick, and tell everyone."""
        numbers = itertools.count(room.seq + 1)
        for plan, events in room.enter():
            ask: _Ask = plan.note
            own = None
            for event in events:
                told = self.teller.announce(room, next(numbers), ask, event)
                self.accepted += isinstance(event, messages.Accepted)
                own = own or told
            if isinstance(plan, InputPlan) and plan.command.data["type"] == "reset":
                for client in self.hub.clients(room.id):
                    self._greet(room, client)
            if not ask.accepted.done():
                ask.accepted.set_result(own)
            self._awake[room.id] = room
            self.ticker.wake()

    def exit(self, room_id: str, client: Client) -> None:
        """A client watches no more."""
        self.hub.leave(room_id, client)
        self.teller.unwatch(room_id, client.id)
        if room_id in self._rooms:
            self.keeper.touch(self._rooms[room_id])

    async def landing(self, room: AnyRoom, ball: int, seconds: float) -> messages.Landed | None:
        """Wait until the ball in flight lands; None when that takes longer than `seconds`."""
        future: asyncio.Future[messages.Landed] = asyncio.get_running_loop().create_future()
        key = (room.id, ball)
        self._waiting.setdefault(key, []).append(future)
        try:
            return await asyncio.wait_for(future, seconds)
        except TimeoutError:
            return None
        finally:
            waiting = self._waiting.get(key, [])
            if future in waiting:
                waiting.remove(future)
            if not waiting:
                self._waiting.pop(key, None)

    def _open_public(self, room_id: str, ground: Ground, mode: str) -> AnyRoom:
        self._make_place()
        row = self._public.pop(room_id, None)
        room = None if row is None else self.keeper.adopt(row, ground)
        return self._add(room or self._new(room_id, ground, mode))

    def _new(self, room_id: str, ground: Ground, mode: str) -> AnyRoom:
        rate = self.settings.tick_rate
        return make_room(room_id, ground, mode, tick_rate=rate, limits=self.ball_limits)

    def _add(self, room: AnyRoom) -> AnyRoom:
        self._rooms[room.id] = room
        self.teller.begin(room, self._new_id())
        self._rouse(room)
        self.keeper.touch(room)
        _log.info("room opened", extra={"room": room.id, "board": room.board.digest})
        if self.keeper.keeps and len(self._rooms) > _IN_MEMORY:
            unneeded = self._unneeded(lambda other: other is not room)
            if unneeded is not None:
                self._park(unneeded)
        return room

    def _rouse(self, room: AnyRoom) -> None:
        """See to it that a room ticks in which something moves from the beginning."""
        if room.awake:
            self._awake[room.id] = room
            self.ticker.wake()

    def _unneeded(self, also: Callable[[AnyRoom], bool]) -> AnyRoom | None:
        """The longest unused room that can be had again without loss, of those that fit."""
        for room in self._rooms.values():
            used = room.id == MAIN or room.awake or self.hub.count(room.id)
            used = used or self.in_use(room.id)
            if not used and self.keeper.parkable(room) and also(room):
                return room
        return None

    def _park(self, room: AnyRoom) -> None:
        """Let the ledger have a sleeping room, and memory a line about it."""
        del self._rooms[room.id]
        self.teller.forget(room.id)
        owned = self.keeper.book(room).owned
        row = self.keeper.park(room)
        if row is not None and owned:
            self._parked[room.id] = Parked.of(row, room.board.name)
        elif row is not None:
            self._public[room.id] = row

    def _make_place(self) -> None:
        """Close the longest unused room if there are too many; raises RoomLimitError."""
        self._close_idle()
        if len(self._rooms) + len(self._parked) < self.settings.max_rooms:
            return
        if self._parked:
            self._end(self._parked.popitem(last=False)[1], "room for another")
            return
        room = self._unneeded(lambda _: True)
        if room is None:
            raise RoomLimitError(f"all {self.settings.max_rooms} rooms are in use")
        self._retire(room, "room for another")

    def _close_idle(self) -> None:
        """Close the rooms with owners that nobody has used for too long."""
        before = self.keeper.now() - self.settings.room_idle
        while self._parked and next(iter(self._parked.values())).used < before:
            self._end(self._parked.popitem(last=False)[1], "unused")
        while (room := self._unneeded(functools.partial(self._idle, before))) is not None:
            self._retire(room, "unused")

    def _idle(self, before: float, room: AnyRoom) -> bool:
        book = self.keeper.book(room)
        return book.owned and book.used < before

    def _retire(self, room: AnyRoom, why: str) -> None:
        """Close a room with an owner; park one without, as it opens again when asked for."""
        self._park(room)
        if room.id in self._parked:
            self._end(self._parked.pop(room.id), why)

    def _end(self, room: Parked, why: str) -> None:
        self.keeper.close(room)
        _log.info("room closed", extra={"room": room.id, "why": why})

    def _tick(self, due: int) -> bool:
        """Run `due` ticks of every room that is awake; True while one still is."""
        for room in self.awake:
            try:
                self._advance(room, due)
            except Exception:  # noqa: BLE001 - one room's fault must not stop the others' clock
                where = {"room": room.id, "tick": room.world.tick}
                _log.exception("room failed and is closed", extra=where)
                self._close(room)
        self.keeper.ticked(due, self._awake.values())
        return bool(self._awake)

    def _advance(self, room: AnyRoom, due: int) -> None:
        watched = self.hub.count(room.id) > 0
        events: list[messages.Event] = []
        before = room.world.tick
        for _ in range(due):
            if room.held:
                self._tell(room, events)
                events = []
                self._admit(room)
            if room.held or not room.awake or not self.keeper.may_step(room):
                break
            events += room.step(watched=watched)
        stepped = room.world.tick > before
        if stepped:
            room.tick_time = self.clock()
        self._tell(room, events, with_picture=stepped or room.touched)
        self.teller.diagnose(room, before)
        if not room.awake:
            del self._awake[room.id]
            self.keeper.slept(room)
        elif room.held:
            self._admit(room)

    def _tell(
        self, room: AnyRoom, events: list[messages.Event], *, with_picture: bool = False
    ) -> None:
        """Send events, and the picture of this moment; and settle who has landed."""
        self.teller.tell(room, events, with_picture=with_picture)
        for event in events:
            if isinstance(event, messages.Landed):
                self._landed(room, event)

    def _landed(self, room: AnyRoom, landed: messages.Landed) -> None:
        self.landed += 1
        self.keeper.landed(room, landed)
        for future in self._waiting.pop((room.id, landed.ball), ()):
            if not future.done():
                future.set_result(landed)

    def _close(self, room: AnyRoom) -> None:
        error = AppError(f"room {room.id!r} failed and was closed")
        self._rooms.pop(room.id, None)
        self.teller.forget(room.id)
        self.keeper.abandon(room)
        self._leave_behind(room, error)
        self.hub.close(room.id, error)
