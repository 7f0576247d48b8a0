"""A light client of a room, so that one process can run hundreds of them.

`connect` joins a room and passes every message to a listener as it arrives. The protocol comes from
the part of the library `websockets` that does no I/O. Its tasks and queues, one for each
connection, are not used: with them a message costs up to twice as much. Binary messages are not
decoded here.
"""

import asyncio
import ssl
import time
from collections import deque
from typing import Any, Protocol, cast
from urllib.parse import quote, urlsplit

import msgspec
from websockets.client import ClientProtocol
from websockets.frames import CloseCode, Frame, Opcode
from websockets.protocol import State
from websockets.uri import WebSocketURI, parse_uri

from plinko.app.errors import InvalidValueError
from plinko.engine.json_text import JsonObject

_LATEST = 0.25  # s; a tick that is later means that its room has slept


class RefusedError(Exception):
    """The server refused or closed the connection."""


class Listener(Protocol):
    """Receives a client's messages; `now` is time.monotonic() when a message was read."""

    def event(self, client: "RoomClient", event: dict[str, Any], now: float) -> None:
        """Receive an event of docs/protocol.md."""

    def binary(self, client: "RoomClient", data: bytes, now: float) -> None:
        """Receive a binary message: a snapshot or paths."""

    def closed(self, client: "RoomClient", code: int, reason: str) -> None:
        """The connection has ended; `code` is 1006 if it ended without a close frame."""


class RoomClient(asyncio.Protocol):
    """One connection to a room; made by `connect`."""

    def __init__(self, listener: Listener, uri: WebSocketURI, events: bool) -> None:
        self.ready: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.texts = 0  # text messages read
        self.text_bytes = 0  # bytes in these
        self._listener = listener
        self._events = events
        self._protocol = ClientProtocol(uri, max_size=None)
        self._transport: asyncio.Transport | None = None

    def send(self, **message: object) -> None:
        """Send a message of docs/protocol.md; do nothing if the connection is closed."""
        if self._protocol.state is State.OPEN:
            self._protocol.send_text(msgspec.json.encode(message))
            self._flush()

    def close(self) -> None:
        if self._protocol.state is State.OPEN:
            self._protocol.send_close(CloseCode.NORMAL_CLOSURE)
            self._flush()
        if self._transport is not None:
            self._transport.close()

    def stall(self) -> None:
        """Stop reading, to see how the server treats a stalled client."""
        assert self._transport is not None
        self._transport.pause_reading()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Request the upgrade to a WebSocket."""
        self._transport = cast(asyncio.Transport, transport)
        self._protocol.send_request(self._protocol.connect())
        self._flush()

    def data_received(self, data: bytes) -> None:
        """Process received bytes: first the answer to the handshake, then messages."""
        now = time.monotonic()
        protocol = self._protocol
        protocol.receive_data(data)
        if not self.ready.done() and protocol.state is not State.CONNECTING:
            self.ready.set_result(None)
        for event in protocol.events_received():
            if isinstance(event, Frame):
                self._take(event, now)
        self._flush()
        if protocol.close_expected() and self._transport is not None:
            self._transport.close()

    def connection_lost(self, error: Exception | None) -> None:
        """Fail `ready` if the handshake was not done, otherwise report the end to the listener."""
        if self._protocol.state is not State.CLOSED:
            self._protocol.receive_eof()
        if not self.ready.done():
            why = self._protocol.handshake_exc or error
            self.ready.set_exception(RefusedError(str(why or "the server closed the connection")))
            return
        code, reason = self._protocol.close_code, self._protocol.close_reason
        self._listener.closed(self, code or CloseCode.ABNORMAL_CLOSURE, reason or "")

    def _take(self, frame: Frame, now: float) -> None:
        if frame.opcode is Opcode.BINARY:
            self._listener.binary(self, bytes(frame.data), now)
        elif frame.opcode is Opcode.TEXT:
            self.texts += 1
            self.text_bytes += len(frame.data)
            if not self._events:
                return
            told = msgspec.json.decode(frame.data)
            for event in told if isinstance(told, list) else [told]:
                self._listener.event(self, event, now)

    def _flush(self) -> None:
        """Write the protocol's outgoing bytes: messages, pongs, the answer to a close."""
        assert self._transport is not None
        for data in self._protocol.data_to_send():
            if data and not self._transport.is_closing():
                self._transport.write(data)


def room_url(url: str, room: str, stream: str) -> str:
    """The address of a room's WebSocket, from the server's address or from a full WebSocket URL.

    Raises InvalidValueError if `url` is neither.
    """
    parts = urlsplit(url if "://" in url else f"http://{url}")
    scheme = {"http": "ws", "https": "wss", "ws": "ws", "wss": "wss"}.get(parts.scheme)
    if scheme is None or not parts.hostname:
        raise InvalidValueError(
            f"{url!r} is not an address such as http://127.0.0.1:8000 or ws://HOST/ws/rooms/main",
            field="url",
        )
    path = parts.path.rstrip("/")
    if "/ws/rooms/" not in path:
        path = f"{path}/ws/rooms/{quote(room, safe='')}"
    return f"{scheme}://{parts.netloc}{path}?stream={stream}"


async def connect(url: str, listener: Listener, *, events: bool = True) -> RoomClient:
    """Join the room at a `room_url`; without `events`, text messages are counted but not decoded.

    Raises RefusedError, or OSError if the server cannot be reached.
    """
    uri = parse_uri(url)
    _, client = await asyncio.get_running_loop().create_connection(
        lambda: RoomClient(listener, uri, events),
        uri.host,
        uri.port,
        ssl=ssl.create_default_context() if uri.secure else None,
    )
    await client.ready
    return client


class Clock:
    """Estimates the server's clock, and when each tick was due, from the latest pongs.

    Times are time.monotonic() of this process. The pong with the shortest round trip has the least
    error, at most half of that round trip. A tick is due tick / rate seconds after an origin that
    does not change while the room is awake; the least late of the latest ticks shows it best.
    """

    def __init__(self, tick_rate: float, kept: int = 20) -> None:
        self.rate = tick_rate
        self._pongs: deque[tuple[float, float, float]] = deque(maxlen=kept)

    def observe(self, pong: JsonObject, now: float) -> None:
        """Add a pong, whose `t` is time.monotonic() when the ping was sent."""
        trip = now - pong["t"]
        ahead = pong["server_time"] - (pong["t"] + 0.5 * trip)
        begin = pong["tick_time"] - pong["tick"] / self.rate
        self._pongs.append((trip, ahead, begin))

    @property
    def known(self) -> bool:
        """Whether a pong has arrived."""
        return bool(self._pongs)

    @property
    def offset(self) -> float:
        """Seconds by which the server's clock is ahead of this process's."""
        return min(self._pongs)[1]

    @property
    def trip(self) -> float:
        """Shortest round trip, s."""
        return min(self._pongs)[0]

    def due(self, tick: int) -> float:
        """The time at which this tick was due, on this process's clock."""
        newest = self._pongs[-1][2]
        # A room that has slept since has a new origin, so older pongs do not count.
        begin = min(begin for _, _, begin in self._pongs if begin > newest - _LATEST)
        return begin + tick / self.rate - self.offset
