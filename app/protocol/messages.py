"""What the server says in a room as JSON, pure: events, and how they become bytes.

docs/protocol.md describes every field; tests/golden/ holds examples that other languages decode
too. What clients say is in client_messages.py, the binary messages in snapshots.py and segments.py.
"""

from collections.abc import Sequence
from typing import Annotated, Final

import msgspec
from msgspec import Meta

from app.protocol.visitors import Visitor
from engine.json_text import Json, JsonObject

PROTOCOL_VERSION = 1

SNAPSHOTS = "snapshots"  # the streams of a room: what its binary messages hold
SEGMENTS = "segments"
SEEDS = "seeds"
STREAMS = (SNAPSHOTS, SEGMENTS, SEEDS)


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
    practice: bool | msgspec.UnsetType = msgspec.UNSET
    name: str | msgspec.UnsetType = msgspec.UNSET
    colour: str | msgspec.UnsetType = msgspec.UNSET


class SignedReceipt(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A receipt of a drop as it is in the log: leaf `index`, with which the log has this root.

    The signature is over all of it; docs/fairness.md says how.
    """

    receipt: JsonObject
    index: Annotated[int, Meta(ge=0, le=(1 << 63) - 1)]
    root: str
    signature: str


MESSAGE_BYTES: Final = 4096
"""Of a WebSocket message that a client sends, at most."""


class Limits(msgspec.Struct, frozen=True):
    """What a client may do in the room."""

    balls: int
    drops_per_second: float
    message_bytes: int


class ArenaState(msgspec.Struct, frozen=True, kw_only=True):
    """What a room whose balls touch each other has beside the rest; `balls` is in columns."""

    scene: JsonObject | None
    place: JsonObject
    settings: dict[str, float]
    paused: bool
    owned: bool
    balls: dict[str, list[float]]
    ranges: JsonObject
    presets: dict[str, dict[str, float]]


class DrawOdds(msgspec.Struct, frozen=True):
    """The draw of a room that has one: its digest, and the weights of the bins, left to right."""

    digest: str
    weights: list[int]


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
    draw: DrawOdds | msgspec.UnsetType = msgspec.UNSET


class Accepted(Event, frozen=True, tag="accepted", kw_only=True):
    """A drop was taken; the ball starts at `tick`. Only its sender sees its own `ref`.

    `aim` in m is there where the player chose the middle of what the seed draws, `stake` in minor
    units where something was staked, `receipt` where the drop is one of a session, `practice`
    (true) where its player chose the seed or x, `visitor` where who dropped it is one, `name` and
    `colour` where the drop has such a tag.
    """

    ball: int
    seed: str
    x: float
    explicit_x: bool
    tick: int
    ref: Json = None
    aim: float | msgspec.UnsetType = msgspec.UNSET
    stake: int | msgspec.UnsetType = msgspec.UNSET
    practice: bool | msgspec.UnsetType = msgspec.UNSET
    receipt: SignedReceipt | msgspec.UnsetType = msgspec.UNSET
    visitor: int | msgspec.UnsetType = msgspec.UNSET
    name: str | msgspec.UnsetType = msgspec.UNSET
    colour: str | msgspec.UnsetType = msgspec.UNSET


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

    `payout` in minor units is there where something was staked, `label` where the bin has one,
    `name` and `colour` where the drop has such a tag.
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
    practice: bool | msgspec.UnsetType = msgspec.UNSET
    label: str | msgspec.UnsetType = msgspec.UNSET
    name: str | msgspec.UnsetType = msgspec.UNSET
    colour: str | msgspec.UnsetType = msgspec.UNSET

    @property
    def paid(self) -> int:
        """The payout, 0 where nothing was staked."""
        return self.payout if isinstance(self.payout, int) else 0


class BriefAccepted(Event, frozen=True, tag="accepted", kw_only=True, omit_defaults=True):
    """`accepted` in the stream `seeds`: `x` only where the seed does not say it."""

    ball: int
    seed: str
    tick: int
    x: float | None = None
    explicit_x: bool = False
    ref: Json = None
    aim: float | msgspec.UnsetType = msgspec.UNSET
    stake: int | msgspec.UnsetType = msgspec.UNSET
    practice: bool | msgspec.UnsetType = msgspec.UNSET
    receipt: SignedReceipt | msgspec.UnsetType = msgspec.UNSET
    visitor: int | msgspec.UnsetType = msgspec.UNSET
    name: str | msgspec.UnsetType = msgspec.UNSET
    colour: str | msgspec.UnsetType = msgspec.UNSET


class BriefLanded(Event, frozen=True, tag="landed", kw_only=True, omit_defaults=True):
    """`landed` in the stream `seeds`: the rest follows from the path; `digest` is cut short."""

    ball: int
    digest: str
    payout: int | msgspec.UnsetType = msgspec.UNSET


class Clock(Event, frozen=True, tag="clock", kw_only=True):
    """The room's tick now, and how many events it has announced; only in the stream `seeds`."""

    tick: int
    seq: int


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
    ref: Json = None


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


class RoomSettings(Event, frozen=True, tag="settings", kw_only=True):
    """What holds for the room from now on, all of it, and whether its clock is stopped."""

    tick: int
    settings: dict[str, float]
    paused: bool


class SessionState(Event, frozen=True, tag="session", kw_only=True):
    """A session as it stands: what the server committed to, and the number of the next drop.

    `token` is told to who begins it, this once. `open`: both sides may drop in it.
    """

    session: str
    room: str
    statement: JsonObject
    signature: str
    key: str
    open: bool
    drops: int
    ended: bool
    token: str | None = None
    ref: Json = None


class SessionEnded(Event, frozen=True, tag="ended", kw_only=True):
    """A session is over: the server's secret, and the signed count of drops."""

    session: str
    server_seed: str
    statement: JsonObject
    signature: str
    ref: Json = None


class Halted(Event, frozen=True, tag="halted", kw_only=True):
    """Whether an operator lets the room take anything new; what is in flight lands all the same."""

    halted: bool


class QueueItem(msgspec.Struct, frozen=True, kw_only=True):
    """Balls that wait to be dropped, for somebody."""

    number: int
    left: int
    name: str | msgspec.UnsetType = msgspec.UNSET
    colour: str | msgspec.UnsetType = msgspec.UNSET


class QueueState(Event, frozen=True, tag="queue", kw_only=True):
    """How many balls wait to be dropped, and the first of them by item."""

    waiting: int
    paused: bool
    items: list[QueueItem]


class Presence(Event, frozen=True, tag="presence", kw_only=True):
    """How many visitors are here, and who was last heard of. `you`: who is told, once it appears.

    Only visitors are told.
    """

    here: int
    visitors: list[Visitor]
    you: int | msgspec.UnsetType = msgspec.UNSET


class Claimed(Event, frozen=True, tag="claimed", kw_only=True):
    """The token was right: this connection may change the room."""

    ref: Json = None


class Done(Event, frozen=True, tag="done", kw_only=True):
    """A change that had a `ref` was carried out at this tick; its own events came before."""

    tick: int
    ref: Json


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
    ref: Json = None


class Missed(Event, frozen=True, tag="missed", kw_only=True):
    """Answer to `resume`: what was announced after `since`, up to `until`, in order.

    `until` is this connection's hello; what came after it was heard. Null when it is not known.
    """

    since: int
    until: int
    events: Sequence[Json] | None


class Pong(Event, frozen=True, tag="pong", kw_only=True):
    """Answer to a ping: its own `t`, and the server's clock now and at the room's last tick."""

    t: float
    tick: int
    tick_time: float
    server_time: float


def has_ref(event: Event | None) -> bool:
    """Whether an event is told to who asked for it with their own note."""
    return isinstance(event, Accepted | Placed | SessionState | SessionEnded)


_encoder = msgspec.json.Encoder()


def encode_event(event: Event) -> bytes:
    """One event as the text message of a single JSON object."""
    return _encoder.encode(event)


def encode_events(events: list[Event]) -> bytes:
    """Several events of one tick as one text message, a JSON array; a single one as an object."""
    return _encoder.encode(events[0] if len(events) == 1 else events)
