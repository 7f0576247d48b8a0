"""The binary formats on the bus: messages of a room's feed, and relays' requests for them. Pure.

A message contains exactly the bytes that spectators are sent, which the server has encoded once.
Its header lets a relay detect a missing message and convert the server's clock to its own.
"""

import struct
from dataclasses import dataclass
from typing import Final

from plinko.app.errors import MalformedError

REQUESTS: Final = "plinko:requests"
"""The channel for relays' requests, to which every server listens."""

EVENTS: Final = 0
HELLO: Final = 1
END: Final = 2
"""Kinds of messages: events, the full state to begin from, and the end of the feed."""

_HEADER = struct.Struct("!B8sQQdd")
_HELLO_BEGINS = b'{"type":"hello"'
_LENGTHS = {126: 4, 127: 10}  # bytes of a frame's header by its second byte, otherwise 2 (RFC 6455)


def channel_of(room_id: str) -> str:
    return f"plinko:room:{room_id}"


@dataclass(frozen=True, slots=True)
class FeedMessage:
    """One message to all relays of a room.

    feed: the random name of the `Feed` that sent it; number: counts that feed's messages from 1.
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


def decode(data: bytes) -> FeedMessage:
    """Parse a message; raises MalformedError."""
    if len(data) < _HEADER.size:
        raise MalformedError(
            f"a message of {len(data)} bytes is too short: at least {_HEADER.size} are needed"
        )
    kind, feed, number, tick, tick_time, now = _HEADER.unpack_from(data)
    return FeedMessage(kind, feed, number, tick, tick_time, now, data[_HEADER.size :])


def payload_of(wire: bytes) -> bytes:
    """The payload of a WebSocket frame from the server."""
    return wire[_LENGTHS.get(wire[1], 2) :]


def kind_of(payload: bytes) -> int:
    return HELLO if payload.startswith(_HELLO_BEGINS) else EVENTS


def encode_request(room_id: str, *, hello: bool) -> bytes:
    """A relay's request for a room's messages, with a hello first if a new spectator needs one."""
    return (b"h" if hello else b"k") + room_id.encode()


def decode_request(data: bytes) -> tuple[str, bool]:
    """Parse a request into the room's id and whether a hello is wanted; raises MalformedError."""
    try:
        room_id = data[1:].decode()
    except UnicodeDecodeError:
        room_id = ""
    if data[:1] not in (b"h", b"k") or not room_id:
        raise MalformedError(f"{data[:40]!r} is not a request for a room")
    return room_id, data[:1] == b"h"
