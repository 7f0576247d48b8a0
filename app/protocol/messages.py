"""The events that the server sends to a room's clients, as JSON. Pure.

docs/protocol.md describes every field; tests/golden/ has examples that other languages decode too.
client_messages.py has the messages of clients, snapshots.py and paths.py the binary messages.
"""

from collections.abc import Sequence
from typing import Annotated, Final

import msgspec
from msgspec import Meta

from plinko.app.protocol.visitors import Visitor
from plinko.engine.json_text import Json, JsonObject

PROTOCOL_VERSION = 2

SNAPSHOTS = "snapshots"  # the streams of a room, one of which each client chooses
PATHS = "paths"
SEEDS = "seeds"
STREAMS = (SNAPSHOTS, PATHS, SEEDS)


class Event(msgspec.Struct, frozen=True, tag_field="type", kw_only=True):
    """The base of all events; the JSON field `type` is the tag."""


class Extent(msgspec.Struct, frozen=True):
    """The box, in metres, that the 16-bit coordinates of snapshots span."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float


class Stats(msgspec.Struct, frozen=True):
    """Counts of a room: accepted drops, landings per bin, drops that ended in no bin."""

    drops: int
    histogram: list[int]
    unsettled: int


class BallStart(msgspec.Struct, frozen=True):
    """The start of a ball in flight, which determines its whole path."""

    ball: int
    seed: str
    x: float
    tick: int
    practice: bool | msgspec.UnsetType = msgspec.UNSET
    name: str | msgspec.UnsetType = msgspec.UNSET
    colour: str | msgspec.UnsetType = msgspec.UNSET


class SignedReceipt(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A drop's receipt at its place in the log: leaf `index`, after which the log has this root.

    The signature covers receipt, index and root; docs/fairness.md says how.
    """

    receipt: JsonObject
    index: Annotated[int, Meta(ge=0, le=(1 << 53) - 1)]
    root: str
    signature: str


MESSAGE_BYTES: Final = 4096
"""The most bytes in a WebSocket message from a client."""


class Limits(msgspec.Struct, frozen=True):
    """The limits for a client in the room."""

    balls: int
    drops_per_second: float
    message_bytes: int


class ArenaState(msgspec.Struct, frozen=True, kw_only=True):
    """The further state of a room of touching balls; `balls` has a list for each property."""

    scene: JsonObject | None
    place: JsonObject
    settings: dict[str, float]
    paused: bool
    owned: bool
    balls: dict[str, list[float]]
    ranges: JsonObject
    presets: dict[str, dict[str, float]]


class DrawOdds(msgspec.Struct, frozen=True):
    """A room's draw: its digest, and the weights of the bins from left to right."""

    digest: str
    weights: list[int]


class Hello(Event, frozen=True, tag="hello", kw_only=True):
    """The full state of a room, the first message to each client."""

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
    stream: str
    stakes: bool
    limits: Limits
    balls: list[BallStart]
    stats: Stats
    run: str = ""
    key: str = ""
    arena: ArenaState | msgspec.UnsetType = msgspec.UNSET
    draw: DrawOdds | msgspec.UnsetType = msgspec.UNSET


class Accepted(Event, frozen=True, tag="accepted", kw_only=True):
    """The room has accepted a drop; the ball starts at `tick`. Only the sender gets the `ref`.

    Optional fields:
    aim: in m, if the player chose the middle of the interval from which the seed draws the start.
    stake: in minor units, if there is one.
    receipt: of a drop of a fair session.
    practice: true if the player chose the seed or x.
    visitor: the player's number, if the player is a visitor.
    name, colour: the drop's tag.
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
    """A drop has ended; `digest` is that of the drop replayed alone, null where balls touch.

    Optional fields:
    payout: in minor units, if the drop had a stake.
    label: of the bin.
    name, colour: the drop's tag.
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


class BriefAccepted(Event, frozen=True, tag="accepted", kw_only=True, omit_defaults=True):
    """`accepted` in the stream `seeds`: with `x` only if the seed does not determine it."""

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
    """`landed` in the stream `seeds`: the client computes the rest; `digest` is shortened."""

    ball: int
    digest: str
    payout: int | msgspec.UnsetType = msgspec.UNSET


class Clock(Event, frozen=True, tag="clock", kw_only=True):
    """The room's current tick and number of events, once a second in the stream `seeds`."""

    tick: int
    seq: int


class Placed(Event, frozen=True, tag="placed", kw_only=True):
    """A ball was added to a room of touching balls, with this size and material."""

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
    """A ball, or every ball if `ball` is null, now has these properties."""

    tick: int
    ball: int | None
    radius: float | None = None
    density: float | None = None
    restitution: float | None = None
    friction: float | None = None


class Removed(Event, frozen=True, tag="removed", kw_only=True):
    """Balls were removed, or left the board without having been drops."""

    tick: int
    balls: list[int]


class RoomSettings(Event, frozen=True, tag="settings", kw_only=True):
    """All settings of the room from now on, and whether its clock is stopped."""

    tick: int
    settings: dict[str, float]
    paused: bool


class SessionState(Event, frozen=True, tag="session", kw_only=True):
    """The state of a fair session: the server's signed commitment and the number of the next drop.

    token: joins the session later; only in the answer that begins it.
    open: the player has revealed their secret, so that the session takes drops.
    void: the restore of a backup ended the session; drops that the backup lacks are void.
    """

    session: str
    room: str
    statement: JsonObject
    signature: str
    key: str
    open: bool
    drops: int
    ended: bool
    void: bool = False
    token: str | None = None
    ref: Json = None


class SessionEnded(Event, frozen=True, tag="ended", kw_only=True):
    """A fair session has ended: the server's secret, and the signed number of drops."""

    session: str
    server_seed: str
    statement: JsonObject
    signature: str
    ref: Json = None


class Halted(Event, frozen=True, tag="halted", kw_only=True):
    """Whether the operator has halted the room; if so, it takes no drops, but balls still land."""

    halted: bool


class Notice(Event, frozen=True, tag="notice", kw_only=True, omit_defaults=True):
    """What the operator announces to all players now; null: nothing any more.

    leaving: whether this server is about to stop; clients then reconnect.
    """

    text: str | None
    leaving: bool = False


class QueueItem(msgspec.Struct, frozen=True, kw_only=True):
    """Balls of one player that wait to be dropped."""

    number: int
    left: int
    name: str | msgspec.UnsetType = msgspec.UNSET
    colour: str | msgspec.UnsetType = msgspec.UNSET


class QueueState(Event, frozen=True, tag="queue", kw_only=True):
    """The room's queue: the number of waiting balls, and its first items."""

    waiting: int
    paused: bool
    items: list[QueueItem]


class ShowChanged(Event, frozen=True, tag="show", kw_only=True):
    """The room's show has changed; `GET rooms/{id}/show` has the new one."""


class Presence(Event, frozen=True, tag="presence", kw_only=True):
    """The number of visitors, and the most recently active ones; sent only to visitors.

    you: the receiver's own number, in the answer to `appear`.
    """

    here: int
    visitors: list[Visitor]
    you: int | msgspec.UnsetType = msgspec.UNSET


class Claimed(Event, frozen=True, tag="claimed", kw_only=True):
    """The token was valid: this connection may change the room."""

    ref: Json = None


class Done(Event, frozen=True, tag="done", kw_only=True):
    """A change with a `ref` was carried out at this tick; its events came before."""

    tick: int
    ref: Json


class Diagnostics(Event, frozen=True, tag="diagnostics", kw_only=True):
    """Energies in J (potential: zero at the origin), momentum in kg m/s, angular in kg m^2/s.

    penetration: the deepest overlap, in m. cell: size of the broad phase's smallest cells, in m.
    time: of the arena, in s.
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
    cell: float


class Error(Event, frozen=True, tag="error", kw_only=True):
    """A message was refused; `detail` says why and names the bad value."""

    code: str
    detail: str
    ref: Json = None


class Missed(Event, frozen=True, tag="missed", kw_only=True):
    """The answer to `resume`: the events after `since` up to `until`, in order.

    until: number of the last event before this connection's hello.
    events: null if the server no longer has all of them.
    """

    since: int
    until: int
    events: Sequence[Json] | None


class Pong(Event, frozen=True, tag="pong", kw_only=True):
    """The answer to `ping`: its `t`, and the server's clock now and at the room's last tick."""

    t: float
    tick: int
    tick_time: float
    server_time: float


def has_ref(event: Event | None) -> bool:
    """Whether the client that caused an event gets its `ref` with it."""
    return isinstance(event, Accepted | Placed | SessionState | SessionEnded)


_encoder = msgspec.json.Encoder()


def encode_event(event: Event) -> bytes:
    """The text message of one event, a JSON object."""
    return _encoder.encode(event)


def encode_events(events: list[Event]) -> bytes:
    """The text message of a tick's events: a JSON array, or an object if there is only one."""
    return _encoder.encode(events[0] if len(events) == 1 else events)
