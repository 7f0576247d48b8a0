"""A client of a room in Python: small, and quick enough to be hundreds of clients in one process.

`connect` joins a room and hands every event and every picture to a listener as it comes. The bytes
of pictures are decoded by app.protocol.messages and app.protocol.segments.
"""

import asyncio
import base64
import hashlib
import os
import ssl
import struct
import time
from collections import deque
from collections.abc import Iterator
from typing import Any, Protocol, cast
from urllib.parse import quote, urlsplit

import msgspec

from app.errors import AppError, InvalidValueError, MalformedError

_GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455, section 1.3
_TEXT, _BINARY, _CLOSE, _PING, _PONG = 0x1, 0x2, 0x8, 0x9, 0xA
_FIN = 0x80
_MASKED = 0x80
_HEAD_LIMIT = 1 << 14  # bytes of the answer to a handshake

_LATEST = 0.25  # s that a tick may be late and its room not yet have slept

_DEFAULT_PORTS = {"ws": 80, "wss": 443}


class RefusedError(AppError):
    """The server did not open the connection."""


class FrameReader:
    """A server's byte stream as messages, pure: any number of bytes in, whole frames out."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Opcode and payload of every frame that is complete with `data`.

        Raises MalformedError for a fragmented or masked frame, which this server never sends.
        """
        buffer = self._buffer
        buffer += data
        start = 0
        while len(buffer) - start >= 2:
            first, size = buffer[start], buffer[start + 1]
            body = start + 2
            if size == 126:
                body += 2
                size = int.from_bytes(buffer[start + 2 : body], "big")
            elif size == 127:
                body += 8
                size = int.from_bytes(buffer[start + 2 : body], "big")
            elif size > 127 or not first & _FIN:
                raise MalformedError(f"a frame begins with {first:#04x} {size:#04x}")
            if len(buffer) < body + size:
                break
            yield first & 0x0F, bytes(buffer[body : body + size])
            start = body + size
        del buffer[:start]


def frame(opcode: int, payload: bytes) -> bytes:
    """A client's frame, masked as RFC 6455 demands."""
    mask = os.urandom(4)
    size = len(payload)
    if size <= 125:
        head = struct.pack("!BB", _FIN | opcode, _MASKED | size)
    else:
        head = struct.pack("!BBH", _FIN | opcode, _MASKED | 126, size)
    masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))
    return head + mask + masked


class Listener(Protocol):
    """What a client does with what it hears; `now` is time.monotonic() at its arrival."""

    def event(self, client: "RoomClient", event: dict[str, Any], now: float) -> None:
        """An event of docs/protocol.md."""

    def picture(self, client: "RoomClient", data: bytes, now: float) -> None:
        """A binary frame: a snapshot or segments."""

    def closed(self, client: "RoomClient", code: int, reason: str) -> None:
        """The connection has ended; 1006 without a word."""


class RoomClient(asyncio.Protocol):
    """One connection to a room; made by `connect`."""

    def __init__(self, listener: Listener, host: str, path: str, events: bool) -> None:
        self.ready: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._listener = listener
        self._events = events
        self._key = base64.b64encode(os.urandom(16))
        self._request = (
            f"GET {path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            f"Sec-WebSocket-Key: {self._key.decode()}\r\n\r\n"
        ).encode()
        self._head = b""
        self._reader = FrameReader()
        self._transport: asyncio.Transport | None = None
        self._end = (1006, "")

    def send(self, **message: Any) -> None:
        """Send a message of docs/protocol.md; nothing once the connection is closed."""
        assert self._transport is not None
        if not self._transport.is_closing():
            self._transport.write(frame(_TEXT, msgspec.json.encode(message)))

    def close(self) -> None:
        """Leave."""
        if self._transport is not None and not self._transport.is_closing():
            self._transport.write(frame(_CLOSE, struct.pack("!H", 1000)))
            self._transport.close()

    def stall(self) -> None:
        """Stop reading, for those who test what a server does then."""
        assert self._transport is not None
        self._transport.pause_reading()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Ask for the upgrade."""
        self._transport = cast(asyncio.Transport, transport)
        self._transport.write(self._request)

    def data_received(self, data: bytes) -> None:
        """Take what came: first the answer to the handshake, then frames."""
        now = time.monotonic()
        if not self.ready.done():
            data = self._shake_hands(data)
        for opcode, payload in self._reader.feed(data):
            if opcode == _BINARY:
                self._listener.picture(self, payload, now)
            elif opcode == _TEXT and self._events:
                told = msgspec.json.decode(payload)
                for event in told if isinstance(told, list) else [told]:
                    self._listener.event(self, event, now)
            elif opcode == _PING and self._transport is not None:
                self._transport.write(frame(_PONG, payload))
            elif opcode == _CLOSE:
                self._end = _end_of(payload)
                self.close()

    def connection_lost(self, error: Exception | None) -> None:
        """Tell how it ended."""
        if not self.ready.done():
            said = self._head[:200].decode("latin-1").partition("\r\n")[0]
            self.ready.set_exception(RefusedError(f"the server answered {said!r}"))
            return
        self._listener.closed(self, *self._end)

    def _shake_hands(self, data: bytes) -> bytes:
        """Read the answer; returns what follows it."""
        assert self._transport is not None
        self._head += data
        head, found, rest = self._head.partition(b"\r\n\r\n")
        wanted = base64.b64encode(hashlib.sha1(self._key + _GUID).digest())
        if found and head.startswith(b"HTTP/1.1 101 ") and wanted in head:
            self.ready.set_result(None)
            return rest
        if found or len(self._head) > _HEAD_LIMIT:
            self._transport.abort()
        return b""


def _end_of(payload: bytes) -> tuple[int, str]:
    """Code and reason of a close frame; 1005 when it has none."""
    if len(payload) < 2:
        return 1005, ""
    return int.from_bytes(payload[:2], "big"), payload[2:].decode(errors="replace")


def room_url(url: str, room: str, stream: str) -> str:
    """The address of a room's WebSocket from that of the server, or a whole one as it is.

    Raises InvalidValueError for what is no address of either kind.
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
    """Join the room at a `room_url`; without `events` they are read and not looked at.

    Raises RefusedError, or OSError when nobody answers.
    """
    parts = urlsplit(url)
    secure = ssl.create_default_context() if parts.scheme == "wss" else None
    _, client = await asyncio.get_running_loop().create_connection(
        lambda: RoomClient(listener, parts.netloc, f"{parts.path}?{parts.query}", events),
        parts.hostname or "",
        parts.port or _DEFAULT_PORTS[parts.scheme],
        ssl=secure,
    )
    await client.ready
    return client


class Clock:
    """What time it is on the server, and when it made each tick: estimated from pongs, for ever.

    Times are time.monotonic() of this process. The quickest of the last pongs has the least error
    in it, at most half its way there and back. A tick is due tick / rate seconds after a beginning
    that stands while the room is awake; the least late of the last ticks shows it best.
    """

    def __init__(self, tick_rate: float, kept: int = 20) -> None:
        self.rate = tick_rate
        self._pongs: deque[tuple[float, float, float]] = deque(maxlen=kept)

    def observe(self, pong: dict[str, Any], now: float) -> None:
        """Take a pong whose `t` was time.monotonic() when the ping left."""
        trip = now - pong["t"]
        ahead = pong["server_time"] - (pong["t"] + 0.5 * trip)
        begin = pong["tick_time"] - pong["tick"] / self.rate
        self._pongs.append((trip, ahead, begin))

    @property
    def known(self) -> bool:
        """Whether there was a pong."""
        return bool(self._pongs)

    @property
    def offset(self) -> float:
        """Seconds by which the server's clock is ahead of this process's."""
        return min(self._pongs)[1]

    @property
    def trip(self) -> float:
        """Seconds of the quickest way there and back."""
        return min(self._pongs)[0]

    def due(self, tick: int) -> float:
        """When this tick was due, on this process's clock."""
        newest = self._pongs[-1][2]
        # A room that slept meanwhile has another beginning: what it was before says nothing.
        begin = min(begin for _, _, begin in self._pongs if begin > newest - _LATEST)
        return begin + tick / self.rate - self.offset
