"""Every room of the server: opens, finds and ticks them, and sends what comes out of them."""

import asyncio
import logging
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

import msgspec

from app import protocol
from app.boards import Boards
from app.errors import AppError, RoomLimitError, UnknownRoomError
from app.frames import Frame
from app.hub import Client, Hub
from app.loop import Schedule, Ticker, Watcher
from app.protocol import shorten
from app.room import DropCommand, Room
from app.settings import Settings
from engine import Board, preset_names

MAIN = "main"  # the room that is always there

_log = logging.getLogger("plinko")


class Rooms:
    """The rooms by id. All of it runs on the event loop's thread; nothing in it waits for a client.

    `draw` gives the seed of a drop that names none, `new_id` the id of a room that is made.
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
    ) -> None:
        self.settings = settings
        self.hub = hub
        self.clock = clock
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
        self._rooms: OrderedDict[str, Room] = OrderedDict()  # the longest unused first
        self._awake: dict[str, Room] = {}
        self._waiting: dict[tuple[str, int], list[asyncio.Future[protocol.Landed]]] = {}
        self._limits = protocol.Limits(settings.max_balls, settings.drop_rate, settings.max_message)
        self._main_board = main_board
        self._add(MAIN, main_board)

    def all(self) -> list[Room]:
        """Every open room, the longest unused first."""
        return list(self._rooms.values())

    @property
    def awake(self) -> list[Room]:
        """The rooms in which something moves."""
        return list(self._awake.values())

    def find(self, room_id: str) -> Room:
        """The room of this id; a preset's name opens its public table. Raises UnknownRoomError."""
        room = self._rooms.get(room_id)
        if room is not None:
            self._rooms.move_to_end(room_id)
            return room
        if room_id == MAIN:
            return self._add(MAIN, self._main_board)
        if room_id in preset_names():
            return self._add(room_id, self._boards.find(room_id))
        raise UnknownRoomError(
            f"room {shorten(room_id)} is neither open nor the name of a preset board", field="room"
        )

    def create(self, board: Board) -> Room:
        """Open a room of its own over `board`; raises RoomLimitError when all rooms are in use."""
        return self._add(self._new_id(), board)

    def enter(self, room: Room, client: Client) -> None:
        """Let a client watch: the full state first, then all that happens. Raises RoomFullError."""
        self.hub.join(room.id, client)
        hello = room.hello(self.clock(), self._limits, client.stream)
        client.post(Frame.event(protocol.encode_event(hello)))
        if client.stream == protocol.SEGMENTS:
            room.watch_segments(True)
            client.show(Frame.picture(room.all_segments()))

    async def drop(
        self,
        room: Room,
        seed: int | None,
        x: float | None,
        *,
        client: int | None = None,
        ref: Any = None,
    ) -> protocol.Accepted:
        """Take a drop and tell the room; `ref` goes to `client` alone.

        Raises BallLimitError and the engine's errors. Asynchronous because what makes a drop
        durable before it is told belongs here, and nowhere else.
        """
        accepted = room.drop(DropCommand(self._draw() if seed is None else seed, x))
        self.accepted += 1
        own = msgspec.structs.replace(accepted, ref=ref)
        if client is not None:
            self.hub.tell(room.id, client, protocol.encode_event(own))
        if self.hub.count(room.id) > (client is not None):
            self.hub.announce(room.id, protocol.encode_event(accepted), skip=client)
        self._awake[room.id] = room
        self.ticker.wake()
        return own

    async def landing(self, room: Room, ball: int, seconds: float) -> protocol.Landed | None:
        """Wait until the ball in flight lands; None when that takes longer than `seconds`."""
        future: asyncio.Future[protocol.Landed] = asyncio.get_running_loop().create_future()
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

    def _add(self, room_id: str, board: Board) -> Room:
        if len(self._rooms) >= self.settings.max_rooms:
            self._evict()
        room = Room(
            room_id,
            board,
            tick_rate=self.settings.tick_rate,
            max_balls=self.settings.max_balls,
        )
        self._rooms[room_id] = room
        _log.info("room opened", extra={"room": room_id, "board": board.digest})
        return room

    def _evict(self) -> None:
        """Close the longest unused room in which nothing moves and nobody is."""
        for room_id in self._rooms:
            if room_id != MAIN and room_id not in self._awake and not self.hub.count(room_id):
                del self._rooms[room_id]
                _log.info("room closed", extra={"room": room_id, "why": "room for another"})
                return
        raise RoomLimitError(f"all {self.settings.max_rooms} rooms are in use")

    def _tick(self, due: int) -> bool:
        """Run `due` ticks of every room that is awake; True while one still is."""
        for room in self.awake:
            try:
                self._advance(room, due)
            except Exception:  # noqa: BLE001 - one room's fault must not stop the others' clock
                where = {"room": room.id, "tick": room.world.tick}
                _log.exception("room failed and is closed", extra=where)
                self._close(room)
        return bool(self._awake)

    def _advance(self, room: Room, due: int) -> None:
        watched = self.hub.count(room.id) > 0
        events: list[protocol.Event] = []
        for _ in range(due):
            events += room.step(watched=watched)
            if not room.awake:
                del self._awake[room.id]
                break
        room.tick_time = self.clock()
        if self.hub.count(room.id, protocol.SNAPSHOTS):
            told = protocol.encode_events(events) if events else None
            self.hub.publish(room.id, protocol.SNAPSHOTS, told, room.frame())
        self._advance_segments(room, events)
        for event in events:
            if isinstance(event, protocol.Landed):
                self._landed(room.id, event)

    def _advance_segments(self, room: Room, events: list[protocol.Event]) -> None:
        """Send what clients that draw the paths themselves need: no contacts, and new pieces."""
        watched = self.hub.count(room.id, protocol.SEGMENTS) > 0
        room.watch_segments(watched)
        if not watched:
            return
        pieces = room.segments()
        told = [event for event in events if not isinstance(event, protocol.Contact)]
        if told or pieces is not None:
            text = protocol.encode_events(told) if told else None
            self.hub.publish(room.id, protocol.SEGMENTS, text, pieces)

    def _landed(self, room_id: str, landed: protocol.Landed) -> None:
        self.landed += 1
        for future in self._waiting.pop((room_id, landed.ball), ()):
            if not future.done():
                future.set_result(landed)

    def _close(self, room: Room) -> None:
        error = AppError(f"room {room.id!r} failed and was closed")
        self._awake.pop(room.id, None)
        self._rooms.pop(room.id, None)
        self.hub.close(room.id, error)
        for key in [key for key in self._waiting if key[0] == room.id]:
            for future in self._waiting.pop(key):
                if not future.done():
                    future.set_exception(error)
