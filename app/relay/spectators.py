"""Serves a relay's clients: spectators from the bus, all others through the room's server."""

import asyncio
import contextlib
import secrets
import time
from collections.abc import Callable
from itertools import count

from starlette.websockets import WebSocket, WebSocketDisconnect

from plinko.app.errors import (
    AppError,
    MalformedError,
    MessageFloodError,
    SlowClientError,
    public_text,
    response_for,
)
from plinko.app.live.broadcast.hub import Client, Hub, Mailbox
from plinko.app.live.broadcast.transport import close, connection_of
from plinko.app.protocol import client_messages, messages
from plinko.app.protocol.wire import WireMessage
from plinko.app.relay import proxy
from plinko.app.relay.bus import Bus
from plinko.app.relay.feed_messages import REQUESTS, channel_of, encode_request
from plinko.app.relay.replica import Replica
from plinko.app.settings import Settings
from plinko.app.web.limits import LINGER, READING_GRACE, UNREAD_BYTES, UNREAD_EVENTS, TokenBucket
from plinko.engine.errors import PlinkoError


class Spectators:
    """All clients of a relay, and its replicas. `rooms` is the address of the rooms' server.

    `lines` counts the clients that are connected with that server (`plinko.app.relay.proxy`).
    """

    def __init__(
        self,
        bus: Bus,
        rooms: str,
        settings: Settings,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        proxy.address(rooms, "main", "")  # raises SettingError if `rooms` is invalid
        self.hub = Hub(settings.max_clients)
        self.settings = settings
        self.clock = clock
        self.lines = 0
        self._rooms = rooms
        self._bus = bus
        self._replicas: dict[str, Replica] = {}
        self._numbers = count()

    @property
    def replicas(self) -> int:
        """The number of rooms with spectators here."""
        return len(self._replicas)

    async def serve(self, socket: WebSocket, room_id: str) -> None:
        """Serve a client until it leaves.

        A client that only watches is served from the bus; any other is connected with the server.
        """
        await socket.accept()
        query = socket.url.query
        first = None
        try:
            if _only_watches(socket):
                first = await Spectator(self, socket, room_id).watch()
            await self._talk(socket, proxy.address(self._rooms, room_id, query), first)
        except WebSocketDisconnect:
            return
        except AppError as error:
            if not isinstance(error, SlowClientError):
                event = messages.Error(code=response_for(error).code, detail=public_text(error))
                with contextlib.suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
                    async with asyncio.timeout(1.0):
                        await socket.send_text(messages.encode_event(event).decode())
            await close(socket, error, LINGER)

    async def _talk(self, socket: WebSocket, url: str, first: str | None) -> None:
        self.lines += 1
        try:
            await proxy.talk(socket, url, first)
        finally:
            self.lines -= 1

    def next_client(self, socket: WebSocket) -> Client:
        return Client(
            next(self._numbers),
            connection_of(socket),
            Mailbox(UNREAD_EVENTS, UNREAD_BYTES),
            READING_GRACE,
            stream=messages.SEEDS,
            key=secrets.token_hex(8),
            traffic=self.hub.traffic,
        )

    def join(self, room_id: str, client: Client, hand_over: Callable[[], None]) -> Replica:
        """Add a spectator to a room's replica, created if need be; raises RoomFullError."""
        replica = self._replicas.get(room_id)
        if replica is None:
            channel = channel_of(room_id)
            replica = Replica(
                room_id, self.hub, lambda hello: self._request(room_id, hello), self.clock
            )
            self._bus.subscribe(channel, replica.take)
            self._replicas[room_id] = replica
        replica.join(client, hand_over)
        return replica

    def leave(self, room_id: str, client: Client) -> None:
        """Remove a spectator, and the replica with its last one."""
        replica = self._replicas[room_id]
        replica.leave(client)
        if not replica.count:
            del self._replicas[room_id]
            self._bus.unsubscribe(channel_of(room_id))

    def _request(self, room_id: str, hello: bool) -> None:
        self._bus.publish(REQUESTS, encode_request(room_id, hello=hello))

    async def tend(self) -> None:
        """Call every replica's `tend` once a second, for ever."""
        while True:
            for replica in list(self._replicas.values()):
                replica.tend()
            await asyncio.sleep(1.0)


class Spectator:
    """A client that is served from the bus until it sends a message other than `ping`."""

    def __init__(self, all_here: Spectators, socket: WebSocket, room_id: str) -> None:
        settings = all_here.settings
        self._here = all_here
        self._socket = socket
        self._room_id = room_id
        self._client = all_here.next_client(socket)
        self._messages = TokenBucket(
            settings.message_rate, 2 * settings.message_rate, all_here.clock()
        )
        self._handed_over = asyncio.Event()
        self._replica: Replica | None = None

    async def watch(self) -> str | None:
        """Serve the client until it must be connected with the room's server.

        Returns the message to send to that server first, if any. Raises WebSocketDisconnect when
        the client leaves, or the AppError for which it must be closed.
        """
        self._replica = self._here.join(self._room_id, self._client, self._handed_over.set)
        reading = asyncio.create_task(self._read())
        writing = asyncio.create_task(self._client.run())
        handed = asyncio.create_task(self._handed_over.wait())
        tasks = (reading, writing, handed)
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._here.leave(self._room_id, self._client)
            for task in tasks:
                task.cancel()
            ended = await asyncio.gather(*tasks, return_exceptions=True)
        for outcome in ended:
            if isinstance(outcome, Exception) and not isinstance(outcome, asyncio.CancelledError):
                raise outcome
        said = ended[0]
        return said if isinstance(said, str) else None

    async def _read(self) -> str:
        """Answer pings; returns the first message that is not a ping."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                raise WebSocketDisconnect(message.get("code", 1005))
            if not self._messages.take(self._here.clock()):
                raise MessageFloodError(
                    f"more than {self._messages.rate:g} messages a second; send fewer"
                )
            said = message.get("text")
            if said is None:
                raise MalformedError("a binary frame is not a message; send JSON in a text frame")
            ping = _ping_of(said)
            if ping is None:
                return str(said)
            # Before the feed's first message the server's tick is unknown, and not needed.
            pong = self._replica and self._replica.pong(ping.t)
            if pong:
                self._client.post(WireMessage.of_text(messages.encode_event(pong)))


def _only_watches(socket: WebSocket) -> bool:
    """Whether the client has declared with its query that it only watches the stream `seeds`.

    Every other client is connected with the server from the start. Connecting it later would send
    it a second hello, which it would not expect after its own requests.
    """
    asked = socket.query_params
    return asked.get("stream") == messages.SEEDS and asked.get("watch") == "true"


def _ping_of(said: str) -> client_messages.PingMessage | None:
    """The message as a ping; None if it is anything else."""
    with contextlib.suppress(PlinkoError):
        asked = client_messages.decode_message(said)
        return asked if isinstance(asked, client_messages.PingMessage) else None
    return None
