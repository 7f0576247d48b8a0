"""The wire protocol of a room, pure: JSON events and binary snapshots, bytes in and values out.

docs/protocol.md describes every byte; tests/golden/ holds examples that other languages decode too.
"""

import math
import re
import struct
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from app.errors import InvalidValueError, MalformedError, UnknownMessageError
from app.protocol.touching_messages import Change, ClaimMessage, WatchMessage
from engine import Board

PROTOCOL_VERSION = 1

MAGIC = 0x50
HEADER = struct.Struct("<BBHII")  # magic, version, balls, tick, events announced so far
SNAPSHOTS = "snapshots"  # the streams of a room: what the binary frames hold
SEGMENTS = "segments"
STREAMS = (SNAPSHOTS, SEGMENTS)

BALL = np.dtype(
    [
        ("id", "<u2"),
        ("x", "<u2"),
        ("y", "<u2"),
        ("angle", "u1"),
        ("flags", "u1"),
        ("vx", "<i2"),
        ("vy", "<i2"),
    ]
)
FLAG_BOUNCED = 1  # the ball hit something since the snapshot before
FLAG_ASLEEP = 2  # the ball is at rest, and stays so until something touches it

_GRID = 65535  # steps of a 16-bit coordinate across the extent
_TURN = 256  # steps of the angle in a full turn
_TOP = 32767  # largest 16-bit velocity


# Events, server to client.


class Event(msgspec.Struct, frozen=True, tag_field="type", kw_only=True):
    """Anything sent as JSON; `type` is its tag."""


class Extent(msgspec.Struct, frozen=True):
    """The box in metres that the snapshots' 16-bit coordinates span."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float


class Stats(msgspec.Struct, frozen=True):
    """What has happened in a room: drops accepted, landings per bin, balls that never settled."""

    drops: int
    histogram: list[int]
    unsettled: int


class BallStart(msgspec.Struct, frozen=True):
    """A ball in flight by its start, from which its whole path follows."""

    ball: int
    seed: str
    x: float
    tick: int


class Limits(msgspec.Struct, frozen=True):
    """What a client may do in the room."""

    balls: int
    drops_per_second: float
    message_bytes: int


class ArenaState(msgspec.Struct, frozen=True, kw_only=True):
    """What a room whose balls touch each other has beside the rest; `balls` is in columns."""

    scene: dict[str, Any] | None
    place: dict[str, Any]
    settings: dict[str, float]
    paused: bool
    owned: bool
    balls: dict[str, list[float]]
    ranges: dict[str, Any]
    presets: dict[str, dict[str, float]]


class Hello(Event, frozen=True, tag="hello", kw_only=True):
    """The full state of a room, first to each client that connects."""

    protocol: int
    physics_version: int | str
    room: str
    board_name: str
    board_digest: str
    board: msgspec.Raw
    slots: list[float]
    solver: str
    mode: str
    tick_rate: int
    tick: int
    seq: int
    server_time: float
    extent: Extent
    velocity_scale: float
    spin_scale: float
    stream: str
    limits: Limits
    balls: list[BallStart]
    stats: Stats
    run: str = ""
    key: str = ""
    arena: ArenaState | msgspec.UnsetType = msgspec.UNSET


class Accepted(Event, frozen=True, tag="accepted", kw_only=True):
    """A drop was taken; the ball starts at `tick`. Only its sender sees its own `ref`.

    `stake` in minor units is there where something was staked.
    """

    ball: int
    seed: str
    x: float
    explicit_x: bool
    tick: int
    ref: Any = None
    stake: int | msgspec.UnsetType = msgspec.UNSET


class Contact(Event, frozen=True, tag="contact", kw_only=True):
    """A ball hit something, `t` seconds after its start, in the tick that ends at `tick`."""

    ball: int
    tick: int
    t: float
    x: float
    y: float
    kind: int
    index: int
    speed: float


class Landed(Event, frozen=True, tag="landed", kw_only=True):
    """A ball's end; `digest` is that of the same drop replayed alone, if no other ball touches it.

    `payout` in minor units is there where something was staked.
    """

    ball: int
    seed: str
    bin: int | None
    score: float
    tick: int
    t: float
    x_end: float
    digest: str | None
    unsettled: str | None
    payout: int | msgspec.UnsetType = msgspec.UNSET

    @property
    def paid(self) -> int:
        """The payout, 0 where nothing was staked."""
        return self.payout if isinstance(self.payout, int) else 0


class Placed(Event, frozen=True, tag="placed", kw_only=True):
    """A ball was put in where balls touch each other, and what it is made of."""

    tick: int
    ball: int
    x: float
    y: float
    radius: float
    density: float
    restitution: float
    friction: float
    ref: Any = None


class Edited(Event, frozen=True, tag="edited", kw_only=True, omit_defaults=True):
    """A ball, or every one where `ball` is null, is made of something else now."""

    tick: int
    ball: int | None
    radius: float | None = None
    density: float | None = None
    restitution: float | None = None
    friction: float | None = None


class Removed(Event, frozen=True, tag="removed", kw_only=True):
    """Balls are gone without having landed as a drop."""

    tick: int
    balls: list[int]


class Settings(Event, frozen=True, tag="settings", kw_only=True):
    """What holds for the room from now on, all of it, and whether its clock is stopped."""

    tick: int
    settings: dict[str, float]
    paused: bool


class Claimed(Event, frozen=True, tag="claimed", kw_only=True):
    """The token was right: this connection may change the room."""

    ref: Any = None


class Diagnostics(Event, frozen=True, tag="diagnostics", kw_only=True):
    """Energies in J (potential: zero at y = 0), momentum in kg m/s, angular in kg m^2/s.

    `penetration` is the deepest overlap in m; `time` seconds of the arena.
    """

    tick: int
    time: float
    kinetic: float
    potential: float
    rotational: float
    total: float
    px: float
    py: float
    angular: float
    contacts: int
    penetration: float
    asleep: int
    count: int


class Error(Event, frozen=True, tag="error", kw_only=True):
    """What was wrong with a message; `detail` names the bad value."""

    code: str
    detail: str
    ref: Any = None


class Missed(Event, frozen=True, tag="missed", kw_only=True):
    """Answer to `resume`: what was announced since, in order; null when that is not known."""

    since: int
    events: list[Any] | None


class Pong(Event, frozen=True, tag="pong", kw_only=True):
    """Answer to a ping: its own `t`, and the server's clock now and at the room's last tick."""

    t: float
    tick: int
    tick_time: float
    server_time: float


_encoder = msgspec.json.Encoder()


def encode_event(event: Event) -> bytes:
    """One event as the text frame of a single JSON object."""
    return _encoder.encode(event)


def encode_events(events: list[Event]) -> bytes:
    """Several events of one tick as one text frame, a JSON array; a single one as an object."""
    return _encoder.encode(events[0] if len(events) == 1 else events)


# Messages, client to server.


class DropMessage(msgspec.Struct, frozen=True, tag="drop", forbid_unknown_fields=True):
    """Ask for a ball. `seed` and `x` stay as they came: their own parsers name what is wrong."""

    seed: Any = None
    x: Any = None
    ref: Any = None
    stake: Any = None
    who: Any = None


class PingMessage(msgspec.Struct, frozen=True, tag="ping", forbid_unknown_fields=True):
    """Ask for the clocks; `t` comes back as it is."""

    t: float


class ResumeMessage(msgspec.Struct, frozen=True, tag="resume", forbid_unknown_fields=True):
    """Ask for what was announced while the line was broken: after number `since` of `run`."""

    run: str
    since: int
    key: str = ""


Message = DropMessage | PingMessage | ResumeMessage | Change | WatchMessage | ClaimMessage
_DEEPEST = 64  # brackets within brackets
_TOO_DEEP = f"JSON nested too deeply: more than {_DEEPEST} levels"
_BRACKETS = re.compile(r"[\[\]{}]")
_STRINGS = re.compile(r'"(?:[^"\\]|\\.)*"', re.DOTALL)

_messages: msgspec.json.Decoder[Message] = msgspec.json.Decoder(Message)
_types = (
    "drop", "ping", "resume", "add", "kick", "drag", "release", "remove", "clear", "edit",
    "settings", "pause", "step", "reset", "watch", "claim",
)  # fmt: skip


def decode_message(data: str | bytes) -> Message:
    """A client's text frame as a message.

    Raises MalformedError for what is not a JSON object of a message's shape, UnknownMessageError
    for a `type` that is none of the protocol's.
    """
    if too_deep(data):
        raise MalformedError(_TOO_DEEP)
    try:
        return _messages.decode(data)
    except msgspec.ValidationError as error:
        kind = peek(data, "type")
        if isinstance(kind, str) and kind not in _types:
            known = ", ".join(_types)
            raise UnknownMessageError(
                f"type {shorten(kind)} is not one of: {known}", field="type"
            ) from None
        raise MalformedError(str(error)) from None
    except (msgspec.DecodeError, UnicodeError) as error:
        raise MalformedError(f"not JSON: {error}") from None


def peek(data: str | bytes, key: str) -> Any:
    """Field `key` of a JSON object that may be no valid message; None when there is none."""
    if too_deep(data):
        return None
    try:
        value = msgspec.json.decode(data)
    except ValueError:
        return None
    return value.get(key) if isinstance(value, dict) else None


def too_deep(data: str | bytes) -> bool:
    """Whether JSON is nested deeper than anyone needs.

    What can just be decoded here could not be encoded again elsewhere, where Python's own stack is
    deeper: a `ref` would come back as a failure of the room.
    """
    text = data if isinstance(data, str) else data.decode(errors="replace")
    if text.count("[") + text.count("{") <= _DEEPEST:
        return False
    depth = 0
    for bracket in _BRACKETS.findall(_STRINGS.sub("", text)):
        depth += 1 if bracket in "[{" else -1
        if depth > _DEEPEST:
            return True
    return False


def parse_x(value: object) -> float | None:
    """An explicit start in metres, or None; raises InvalidValueError naming what is no number."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidValueError(f"x {shorten(value)} is not a number of metres", field="x")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InvalidValueError(f"x {shorten(value)} is not a finite number of metres", field="x")
    return number


def parse_stream(value: str | None) -> str:
    """The stream asked for, snapshots if none; raises InvalidValueError for one there is not."""
    stream = value or SNAPSHOTS
    if stream not in STREAMS:
        known = ", ".join(STREAMS)
        raise InvalidValueError(f"stream {shorten(value)} is not one of: {known}", field="stream")
    return stream


def shorten(value: object, limit: int = 40) -> str:
    """`repr` for messages, cut so that a huge value does not make a huge message."""
    try:
        shown = repr(value)
    except ValueError:  # an integer of more digits than Python prints
        shown = "an integer of thousands of digits"
    return shown if len(shown) <= limit else shown[: limit - 3] + "..."


# Snapshots.


def velocity_scale_of(board: Board, extent: Extent) -> float:
    """Metres per second of one velocity step: a power of two, 1/1024 or the next that suffices.

    A ball that falls from rest by h gains at most sqrt(2 g h); twice that leaves room for what
    other balls may give it.
    """
    top = 2.0 * math.sqrt(2.0 * board.gravity * (extent.y_max - extent.y_min))
    scale = 1.0 / 1024.0
    while _TOP * scale < top:
        scale *= 2.0
    return scale


def encode_snapshot(
    tick: int,
    seq: int,
    bodies: npt.NDArray[np.void],
    bounced: npt.NDArray[np.bool_],
    extent: Extent,
    velocity_scale: float,
    asleep: npt.NDArray[np.bool_] | None = None,
) -> bytes:
    """A snapshot of `bodies` (shape (n,): id x y theta vx vy, SI units) with `bounced`, shape (n,).

    `asleep`, of the same shape, is for rooms whose balls stay when they rest.

    `tick` and `seq` are taken modulo 2^32, ids modulo 2^16. What lies outside the extent or the
    velocity range is clamped to its edge.
    """
    count = len(bodies)
    balls = np.empty(count, BALL)
    balls["id"] = bodies["id"] & 0xFFFF
    balls["x"] = _grid(bodies["x"], extent.x_min, extent.x_max)
    balls["y"] = _grid(bodies["y"], extent.y_min, extent.y_max)
    turns = bodies["theta"] * (1.0 / (2.0 * math.pi))
    balls["angle"] = np.rint((turns - np.floor(turns)) * _TURN).astype(np.int64) & (_TURN - 1)
    balls["flags"] = np.where(bounced, FLAG_BOUNCED, 0)
    if asleep is not None:
        balls["flags"] |= np.where(asleep, FLAG_ASLEEP, 0).astype(np.uint8)
    balls["vx"] = np.clip(np.rint(bodies["vx"] / velocity_scale), -_TOP, _TOP)
    balls["vy"] = np.clip(np.rint(bodies["vy"] / velocity_scale), -_TOP, _TOP)
    header = HEADER.pack(MAGIC, PROTOCOL_VERSION, count, tick & 0xFFFFFFFF, seq & 0xFFFFFFFF)
    return header + balls.tobytes()


def _grid(values: npt.NDArray[np.float64], low: float, high: float) -> npt.NDArray[np.float64]:
    scaled: npt.NDArray[np.float64] = np.rint((values - low) * (_GRID / (high - low)))
    return np.clip(scaled, 0, _GRID)


class Snapshot(msgspec.Struct, frozen=True):
    """A decoded snapshot: `balls` has fields id x y theta vx vy (SI units), bounced, asleep."""

    tick: int
    seq: int
    balls: npt.NDArray[np.void]


DECODED = np.dtype(
    [
        ("id", "u2"),
        ("x", "f8"),
        ("y", "f8"),
        ("theta", "f8"),
        ("vx", "f8"),
        ("vy", "f8"),
        ("bounced", "?"),
        ("asleep", "?"),
    ]
)


def decode_snapshot(data: bytes, extent: Extent, velocity_scale: float) -> Snapshot:
    """A snapshot's bytes as values in SI units.

    Raises MalformedError naming the byte count, magic or version that is wrong.
    """
    if len(data) < HEADER.size:
        raise MalformedError(f"a snapshot of {len(data)} bytes has no whole header")
    magic, version, count, tick, seq = HEADER.unpack_from(data)
    if magic != MAGIC or version != PROTOCOL_VERSION:
        raise MalformedError(f"magic {magic:#x}, version {version} is not a snapshot of version 1")
    if len(data) != HEADER.size + count * BALL.itemsize:
        raise MalformedError(f"{len(data)} bytes do not hold {count} balls")
    raw = np.frombuffer(data, BALL, count, HEADER.size)
    balls = np.empty(count, DECODED)
    balls["id"] = raw["id"]
    balls["x"] = raw["x"] / _GRID * (extent.x_max - extent.x_min) + extent.x_min
    balls["y"] = raw["y"] / _GRID * (extent.y_max - extent.y_min) + extent.y_min
    balls["theta"] = raw["angle"] * (2.0 * math.pi / _TURN)
    balls["vx"] = raw["vx"] * velocity_scale
    balls["vy"] = raw["vy"] * velocity_scale
    balls["bounced"] = (raw["flags"] & FLAG_BOUNCED) != 0
    balls["asleep"] = (raw["flags"] & FLAG_ASLEEP) != 0
    return Snapshot(tick, seq, balls)
