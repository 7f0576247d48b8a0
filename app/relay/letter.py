"""The bus's binary formats: a room's messages (`Letter`), and relays' requests (`wish`). Pure.

A letter contains exactly the bytes that a spectator is sent, which the server has encoded once.
Its header lets a relay detect a missing letter and convert the server's clock to its own.
"""

import struct
from dataclasses import dataclass
from typing import Final

from app.errors import MalformedError

WISHES: Final = "plinko:wishes"
"""The channel for relays' requests, to which every server listens."""

EVENTS: Final = 0
HELLO: Final = 1
END: Final = 2
"""Kinds of letters: events, the full state to begin from, and the end of the feed."""

_HEADER = struct.Struct("!B8sQQdd")
_HELLO_BEGINS = b'{"type":"hello"'
_LENGTHS = {126: 4, 127: 10}  # bytes of a frame's header by its second byte, otherwise 2 (RFC 6455)


def channel_of(room_id: str) -> str:
    """The channel for a room's letters."""
    return f"plinko:room:{room_id}"


@dataclass(frozen=True, slots=True)
class Letter:
    """One message to all relays of a room.

    feed: the random name of the `Feed` that sent it; number: counts that feed's letters from 1.
    tick, tick_time: the room's last tick and its time; now: the time of sending; both in s of the
    sender's clock. payload: the text of one WebSocket message.
    """

    kind: int
    feed: bytes
    number: int
    tick: int
    tick_time: float
    now: float
    payload: bytes = b""

    def encode(self) -> bytes:
        clock = (self.tick, self.tick_time, self.now)
        return _HEADER.pack(self.kind, self.feed, self.number, *clock) + self.payload


def decode(data: bytes) -> Letter:
    """Parse a letter; raises MalformedError."""
    if len(data) < _HEADER.size:
        raise MalformedError(f"a letter of {len(data)} bytes is too short: {_HEADER.size} or more")
    kind, feed, number, tick, tick_time, now = _HEADER.unpack_from(data)
    return Letter(kind, feed, number, tick, tick_time, now, data[_HEADER.size :])


def payload_of(wire: bytes) -> bytes:
    """The payload of a WebSocket frame from the server."""
    return wire[_LENGTHS.get(wire[1], 2) :]


def kind_of(payload: bytes) -> int:
    """HELLO or EVENTS."""
    return HELLO if payload.startswith(_HELLO_BEGINS) else EVENTS


def wish(room_id: str, *, hello: bool) -> bytes:
    """A relay's request for a room's letters, with a hello first if a new spectator needs one."""
    return (b"h" if hello else b"k") + room_id.encode()


def wished(data: bytes) -> tuple[str, bool]:
    """Parse a relay's request into room and hello; raises MalformedError."""
    try:
        room_id = data[1:].decode()
    except UnicodeDecodeError:
        room_id = ""
    if data[:1] not in (b"h", b"k") or not room_id:
        raise MalformedError(f"{data[:40]!r} is not a request for a room")
    return room_id, data[:1] == b"h"
