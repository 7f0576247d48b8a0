"""The WebSocket of a room: serves one client's messages, and closes it with a reason."""

import asyncio
import contextlib
import logging
import secrets
import time
from collections.abc import Awaitable
from typing import TypeVar

import msgspec
from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from plinko.app.errors import (
    AbuseError,
    AppError,
    BannedError,
    HaltedError,
    InvalidValueError,
    LeaseLostError,
    LedgerError,
    LimitError,
    MalformedError,
    MessageFloodError,
    MissingBallError,
    ResetError,
    SessionStateError,
    UndecidedError,
    public_text,
    response_for,
)
from plinko.app.live.broadcast.audience import Player
from plinko.app.live.broadcast.hub import Client, Mailbox
from plinko.app.live.broadcast.transport import close, connection_of
from plinko.app.live.live_room import LiveRoom
from plinko.app.protocol import asyncapi, client_messages, messages
from plinko.app.protocol.touching_messages import ClaimMessage, WatchMessage
from plinko.app.protocol.visitors import (
    NO_TAG,
    Appearance,
    AppearMessage,
    parse_colour,
    parse_name,
)
from plinko.app.protocol.wire import WireMessage
from plinko.app.rooms.keys import Caller, IdempotencyKey, key_of
from plinko.app.rooms.stakes import parse_who
from plinko.app.web.drops import drop_command
from plinko.app.web.limits import (
    LINGER,
    READING_GRACE,
    UNREAD_BYTES,
    UNREAD_EVENTS,
    TokenBucket,
    spend,
)
from plinko.app.web.routes.common import Server, address_of
from plinko.app.web.routes.queries import check_queries
from plinko.app.web.routes.rooms.joined_sessions import JoinedSessions
from plinko.app.web.routes.rooms.room_changes import Changes
from plinko.app.web.services import Services
from plinko.engine.errors import PlinkoError, shorten

router = APIRouter()

# A bad message only gets an error; a client that keeps sending bad messages is disconnected.
_STRIKES = 20  # bad messages in a row
_STRIKES_FORGIVEN = 1.0  # strikes forgiven a second

# Every change of a name is sent to all visitors, so it is limited.
_APPEARANCES = 0.5  # changes a second
_APPEARANCES_AT_ONCE = 5  # and in a burst

# Errors that are no strike, because a well-behaved client gets them too: a room is full or halted,
# a limit is reached, a ball or session is gone, or the ledger fails.
_INNOCENT = (
    HaltedError, LimitError, LedgerError, MissingBallError, SessionStateError, ResetError,
)  # fmt: skip

T = TypeVar("T")

_log = logging.getLogger("plinko")


@router.websocket("/ws/rooms/{room_id}")
async def watch(socket: WebSocket, room_id: str, server: Server) -> None:
    """Watch and play in a room; docs/protocol.md has every message."""
    await socket.accept()
    error: AppError | None = None
    try:
        check_queries(socket.query_params, asyncapi.QUERY)
        client_messages.parse_protocol(socket.query_params.get("protocol"))
        stream = client_messages.parse_stream(socket.query_params.get("stream"))
        client_messages.parse_watch(socket.query_params.get("watch"))  # only relays use the value
        live = await server.rooms.seek(room_id)
        if stream == messages.PATHS:
            await live.cut_paths()
            live = await server.rooms.seek(room_id)  # it may have moved meanwhile
        error = await RoomClient(socket, server, live, stream).run()
    except AppError as refused:
        error = refused
        if not isinstance(refused, LeaseLostError):  # the client reconnects to the room's server
            with contextlib.suppress(WebSocketDisconnect):
                await socket.send_text(messages.encode_event(_event(refused)).decode())
    if error is not None:
        server.metrics.errors.labels(response_for(error).code).inc()
        _log.info("client closed", extra={"room": shorten(room_id), "why": str(error)})
        await close(socket, error, LINGER)


def _event(error: BaseException, ref: object = None) -> messages.Error:
    return messages.Error(code=response_for(error).code, detail=public_text(error), ref=ref)


def _key(room_id: str, hello: str, message: client_messages.DropMessage) -> IdempotencyKey | None:
    """The key under which a client may repeat a drop, also over another connection: its `ref`.

    `hello` is the key in the hello of the connection that sent it first, which no other client
    knows.
    """
    if message.ref is None:
        return None
    ref = msgspec.json.encode(message.ref, order="sorted").decode()
    request = msgspec.structs.replace(message, ref=None, key=None)
    return key_of("drop", room_id, Caller(f"connection {hello}", proven=True), ref, request)


class RoomClient:
    """One client in one room."""

    def __init__(self, socket: WebSocket, server: Services, live: LiveRoom, stream: str) -> None:
        settings = server.settings
        now = time.monotonic()
        self.socket = socket
        self.server = server
        self.live = live
        self.client = Client(
            next(server.client_ids),
            connection_of(socket),
            Mailbox(UNREAD_EVENTS, UNREAD_BYTES),
            READING_GRACE,
            stream=live.room.stream_of(stream),
            traffic=server.hub.traffic,
            key=secrets.token_hex(8),
        )
        self._messages = TokenBucket(settings.message_rate, 2 * settings.message_rate, now)
        self._drops = TokenBucket(settings.drop_rate, 2 * settings.drop_rate, now)
        self._appearances = TokenBucket(_APPEARANCES, _APPEARANCES_AT_ONCE, now)
        self._changes = Changes(server, live, self.client)
        self._sessions = JoinedSessions(server)
        self._served: set[asyncio.Task[None]] = set()  # else they would be garbage-collected
        self._strikes = TokenBucket(_STRIKES_FORGIVEN, _STRIKES, now)

    async def run(self) -> AppError | None:
        """Serve the client until it leaves, or return why it must leave; raises RoomFullError."""
        self.server.rooms.enter(self.live, self.client)
        tasks = [asyncio.create_task(self._read()), asyncio.create_task(self.client.run())]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self.server.rooms.exit(self.live, self.client)
            for task in tasks:
                task.cancel()
            ended = await asyncio.gather(*tasks, return_exceptions=True)
            await self._changes.release_all()
        for outcome in ended:
            if isinstance(outcome, AppError):
                return outcome
            if isinstance(outcome, Exception) and not isinstance(outcome, WebSocketDisconnect):
                raise outcome
        return None

    async def _read(self) -> None:
        """Serve each message in its own task until the client disconnects.

        The tasks start in the order of the messages, so the room accepts their inputs in that
        order. But no message waits until the ledger has committed an earlier one, except for the
        messages that join, open and end a session: see `JoinedSessions.in_turn`.
        """
        while True:
            message = await self.socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            task = asyncio.create_task(self._serve(message.get("text")))
            self._served.add(task)
            task.add_done_callback(self._served.discard)

    async def _serve(self, data: str | None) -> None:
        """Carry out one message; if that fails, send the client an error."""
        try:
            self.server.rooms.orders.check_banned(address_of(self.socket))
        except BannedError as banned:
            self.client.fail(banned)
            return
        try:
            await self._carry_out(data)
        except LeaseLostError as lost:
            self.client.fail(lost)  # close without an error event: the client reconnects
        except Exception as error:  # noqa: BLE001 - the client gets an error event for any fault
            if not isinstance(error, PlinkoError):
                _log.exception("a message failed")
            innocent = isinstance(error, _INNOCENT) and not isinstance(error, MessageFloodError)
            if not innocent and not self._strikes.take(time.monotonic()):
                self.client.fail(AbuseError(f"too many bad messages; the last: {error}"))
                return
            self.server.metrics.errors.labels(response_for(error).code).inc()
            ref = client_messages.peek(data, "ref") if isinstance(data, str) else None
            self._send(_event(error, ref))

    async def _carry_out(self, data: str | None) -> None:
        """Carry out a message and send the answer; raises the errors of the operation."""
        if not self._messages.take(time.monotonic()):
            raise MessageFloodError(
                f"more than {self._messages.rate:g} messages a second; send fewer"
            )
        if not isinstance(data, str):
            raise MalformedError("a binary frame is not a message; send JSON in a text frame")
        message = client_messages.decode_message(data)
        match message:
            case client_messages.PingMessage():
                self._send(self._pong(message))
            case client_messages.ResumeMessage(run=run, since=since, key=key):
                self._send(self.live.audience.missed(self.client, run, since, key))
            case client_messages.DropMessage():
                spend(self._drops, time.monotonic(), "drops")
                async with self._sessions.in_turn(message.session, alone=False):
                    await self._drop(message)
            case (
                client_messages.SessionMessage()
                | client_messages.OpenMessage()
                | client_messages.EndMessage()
            ):
                spend(self._drops, time.monotonic(), "drops")
                async with self._sessions.in_turn(message.session, alone=True):
                    work = self._sessions.take(self.live.room, message)
                    self._send(await self._decided(work, message.ref))
            case AppearMessage():
                self._appear(message)
            case ClaimMessage():
                self._send(self._changes.claim(message))
            case WatchMessage():
                self._changes.watch(message)
            case _:
                event = await self._decided(self._changes.take(message), message.ref)
                if message.ref is not None and not messages.has_ref(event):
                    self._send(messages.Done(tick=self.live.room.world.tick, ref=message.ref))

    async def _decided(self, operation: Awaitable[T], ref: object) -> T:
        """The result of an operation that the ledger commits, however long that takes.

        If the commit takes long, the client first gets the error `undecided`, then the outcome.
        """
        try:
            return await operation
        except UndecidedError as undecided:
            if undecided.outcome is None:
                raise
            self._send(_event(undecided, ref))
            outcome: T = await undecided.outcome
            return outcome

    async def _drop(self, message: client_messages.DropMessage) -> None:
        """Drop a ball; for a drop that an earlier connection has sent, only send its outcome."""
        command = drop_command(message, self.server.rooms.draw)
        if command.tag != NO_TAG:
            self._changes.check_owner("give a ball a name or a colour")
        session = None if message.session is None else self._sessions.of(message.session)
        if message.key is not None and message.ref is None:
            raise InvalidValueError(
                "a drop with a `key` repeats an earlier one: send the `ref` of that drop",
                field="ref",
            )
        key = _key(self.live.id, message.key or self.client.key, message)
        player = Player(
            client=self.client.id, key=self.client.key, ref=message.ref, idempotency_key=key
        )
        found = await self._decided(self.live.drop(command, player, session), message.ref)
        if found.earlier:
            self._send(msgspec.structs.replace(found.accepted, ref=message.ref))
            if found.landed is not None:
                self._send(found.landed)

    def _appear(self, message: AppearMessage) -> None:
        spend(self._appearances, time.monotonic(), "changes of name")
        appearance = Appearance(
            parse_name(message.name),
            parse_colour(message.colour),
            parse_who(message.who),
            message.audience,
        )
        self._send(self.live.audience.appear(self.client, appearance))

    def _pong(self, ping: client_messages.PingMessage) -> messages.Pong:
        tick, at = self.live.room.world.tick, self.live.tick_time
        return messages.Pong(t=ping.t, tick=tick, tick_time=at, server_time=time.monotonic())

    def _send(self, event: messages.Event) -> None:
        self.client.post(WireMessage.of_text(messages.encode_event(event)))
