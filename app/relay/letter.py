"""What goes over the bus: letters from a room's process, and wishes of relays. Pure.

A letter holds the very bytes that a spectator is sent, framed once, beside what a relay needs to
know of them: whether one is missing, and what time it is where the room is.
"""

import struct
from dataclasses import dataclass
from typing import Final

from app.errors import MalformedError

WISHES: Final = "plinko:wishes"
"""The channel that every process listens to that has rooms."""

EVENTS: Final = 0
HELLO: Final = 1
END: Final = 2
"""Kinds: what happened, the full state to begin from, and that there will be no more."""

_HEADER = struct.Struct("!B8sQQdd")
_HELLO_BEGINS = b'{"type":"hello"'
_LENGTHS = {126: 4, 127: 10}  # bytes of a frame's header by its second byte; else 2


def channel_of(room_id: str) -> str:
    """The channel that a room's letters are sent to."""
    return f"plinko:room:{room_id}"


@dataclass(frozen=True, slots=True)
class Letter:
    """One message to all relays of a room.

    feed: names who sends it, for one stretch of time; number: counts its letters. tick, tick_time:
    the room's last tick and when it was; now: when this was sent; s of the sender's clock. payload:
    of one text message.
    """

    kind: int
    feed: bytes
    number: int
    tick: int
    tick_time: float
    now: float
    payload: bytes = b""

    def encode(self) -> bytes:
        """As it goes over the bus."""
        clock = (self.tick, self.tick_time, self.now)
        return _HEADER.pack(self.kind, self.feed, self.number, *clock) + self.payload


def decode(data: bytes) -> Letter:
    """A letter; MalformedError for what is none."""
    if len(data) < _HEADER.size:
        raise MalformedError(f"{len(data)} bytes are no letter, which has {_HEADER.size} or more")
    kind, feed, number, tick, tick_time, now = _HEADER.unpack_from(data)
    return Letter(kind, feed, number, tick, tick_time, now, data[_HEADER.size :])


def payload_of(wire: bytes) -> bytes:
    """What is in the one frame that a client is written."""
    return wire[_LENGTHS.get(wire[1], 2) :]


def kind_of(payload: bytes) -> int:
    """Whether a message begins anew or goes on."""
    return HELLO if payload.startswith(_HELLO_BEGINS) else EVENTS


def wish(room_id: str, *, hello: bool) -> bytes:
    """That a room's letters go on coming, and begin with a hello if somebody waits for one."""
    return (b"h" if hello else b"k") + room_id.encode()


def wished(data: bytes) -> tuple[str, bool]:
    """The room of a wish, and whether a hello is wanted; MalformedError for what is none."""
    try:
        room_id = data[1:].decode()
    except UnicodeDecodeError:
        room_id = ""
    if data[:1] not in (b"h", b"k") or not room_id:
        raise MalformedError(f"{data[:40]!r} is no wish for a room")
    return room_id, data[:1] == b"h"
