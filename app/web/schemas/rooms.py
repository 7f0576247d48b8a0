"""Bodies of the routes of rooms and scenes."""

import functools
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from app.protocol.messages import BallStart, DrawOdds, Extent, SignedReceipt, Stats
from app.rooms.draw import MAX_SEEDS
from app.rooms.stakes import MAX_STAKE, MAX_WHO
from app.rooms.touching.story import StoryForm
from app.web.schemas.fields import (
    AimIn,
    BoardIn,
    BoardRef,
    ColourIn,
    Digest,
    NameIn,
    OptionalBoard,
    PhysicsVersion,
    Seed,
    SeedIn,
    Solver,
    StartIn,
)
from engine.drops.draws import MAX_WEIGHT
from engine.json_text import Json, JsonObject


class DrawForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Exact odds for a board's bins, and by which seeds a ball falls into each: `find_draw`."""

    weights: Annotated[
        Json,
        Meta(
            description="One for each bin, left to right: a ball falls into it with the chance of "
            "its weight among their sum.",
            examples=[[0, 0, 0, 1, 9999, 0, 0, 0, 0]],
            extra_json_schema={
                "type": "array",
                "items": {"type": "integer", "minimum": 0, "maximum": MAX_WEIGHT},
            },
        ),
    ]
    seeds: Annotated[
        Json,
        Meta(
            description="For each bin with a weight, seeds whose balls land there; for each other "
            f"bin an empty list. {MAX_SEEDS:,} in all at most.",
            extra_json_schema={
                "type": "array",
                "items": {
                    "type": "array",
                    "items": {"anyOf": [{"type": "string"}, {"type": "integer"}]},
                },
            },
        ),
    ]


class DrawView(msgspec.Struct, frozen=True):
    """A room's draw. Its digest is SHA-256 of this as canonical JSON (RFC 8785)."""

    kind: Literal["plinko draw"]
    version: Literal[1]
    board_digest: Digest
    weights: list[int]
    seeds: list[list[Seed]]


class RoomRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A room to open, over a board or as a scene."""

    board: OptionalBoard = msgspec.field(default_factory=functools.partial(msgspec.Raw, b"null"))
    mode: Annotated[
        Literal["independent", "interacting", "draw"],
        Meta(
            description="Whether balls pass through each other or knock each other; `draw`: the "
            "former, with bins that are drawn by the odds of `draw`."
        ),
    ] = "independent"
    draw: Annotated[DrawForm | None, Meta(description="With the mode `draw`.")] = None
    scene: Annotated[
        Json,
        Meta(
            description="Instead of a board: `sandbox` or `galton`, or an object with that name as "
            "`scene` and the parameters that `GET scenes` lists. The message `reset`, a room's "
            "view, its hello and its log have the same object.",
            examples=[{"scene": "sandbox", "balls": 40}],
            extra_json_schema={"anyOf": [{"type": "string"}, {"type": "object"}, {"type": "null"}]},
        ),
    ] = None
    story: Annotated[
        StoryForm | None,
        Meta(
            description="Instead of a scene: one that was played elsewhere, with all that was done "
            "to it. The room goes on from there, to the last bit."
        ),
    ] = None

    def has(self, name: str) -> bool:
        """Whether this field was given, and not as null."""
        value = getattr(self, name)
        return bytes(value) != b"null" if isinstance(value, msgspec.Raw) else value is not None


class SceneView(msgspec.Struct, frozen=True):
    """A scene by name, the room in which everybody may play it, and what it is made with."""

    name: str
    room: str
    parameters: Annotated[JsonObject, Meta(description="With their defaults.")]


class SceneList(msgspec.Struct, frozen=True):
    """The scenes; the ranges of what can be set, with units; the presets by name."""

    scenes: list[SceneView]
    ranges: JsonObject
    presets: dict[str, dict[str, float]]


class RoomChange(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is to be different in a room; it begins anew with it."""

    board: BoardIn


class RoomSummary(msgspec.Struct, frozen=True):
    """A room in a list."""

    id: str
    board_name: str
    board_digest: Digest
    mode: str
    tick: int
    awake: Annotated[bool, Meta(description="Whether anything moves.")]
    balls: Annotated[int, Meta(description="Balls in flight.")]
    clients: int
    drops: Annotated[
        int, Meta(description="Drops accepted so far; where balls touch each other, inputs.")
    ]


class RoomList(msgspec.Struct, frozen=True):
    """Open rooms. Every preset's name is also a room, opened when first asked for."""

    rooms: list[RoomSummary]
    next: Annotated[str | None, Meta(description="`after` of the next page; null on the last.")]


class RoomView(msgspec.Struct, frozen=True):
    """A room with its balls in flight and what came of the others."""

    id: str
    board_name: str
    board_digest: Digest
    mode: str
    solver: Solver
    tick: int
    tick_rate: int
    awake: bool
    clients: int
    owned: Annotated[
        bool, Meta(description="Whether its creator, by its token, may change, reset or close it.")
    ]
    extent: Extent
    balls: Annotated[list[BallStart], Meta(description="The drops in flight.")]
    stats: Stats
    scene: Annotated[
        JsonObject | None, Meta(description="As it was opened; null for a room with a board.")
    ]
    draw: Annotated[
        DrawOdds | None,
        Meta(description="By which odds its bins are drawn; null where the seeds alone decide."),
    ]


class RoomOpened(RoomView, frozen=True):
    """A room of one's own. The token is shown this once and cannot be had again."""

    token: Annotated[
        str, Meta(description="Send it as `Authorization: Bearer TOKEN` to change the room.")
    ]


class LoggedResult(msgspec.Struct, frozen=True):
    """How a drop in a room ended."""

    tick: int
    bin: int | None
    score: float
    t: Annotated[float, Meta(description="Seconds from start to landing.")]
    x_end: float
    digest: str
    unsettled: str | None
    payout: Annotated[int, Meta(description="In minor units.")]


class LoggedDrop(msgspec.Struct, frozen=True):
    """A drop that a room accepted."""

    ball: int
    tick: Annotated[int, Meta(description="The room's tick at which it starts.")]
    seed: Seed
    x: Annotated[float | None, Meta(description="Explicit start; null: the seed decides.")]
    stake: Annotated[int, Meta(description="In minor units.")]
    who: str | None
    result: Annotated[LoggedResult | None, Meta(description="Null while it is in flight.")]
    aim: Annotated[
        float | msgspec.UnsetType,
        Meta(description="Middle of what the seed draws, m; only where it was chosen."),
    ] = msgspec.UNSET
    name: Annotated[
        str | msgspec.UnsetType, Meta(description="Whose ball it was; no digest covers it.")
    ] = msgspec.UNSET
    colour: Annotated[
        str | msgspec.UnsetType, Meta(description="Of the ball, #rrggbb; no digest covers it.")
    ] = msgspec.UNSET


class LoggedInput(msgspec.Struct, frozen=True):
    """A message that changed a room in which balls touch each other."""

    tick: Annotated[int, Meta(description="The room's tick at which it was carried out.")]
    who: str | None
    input: Annotated[JsonObject, Meta(description="Its `type` and fields.")]


class RoomLog(msgspec.Struct, frozen=True):
    """All that a room was told, and what came of it: enough to replay it to the last bit."""

    kind: str
    version: int
    room: str
    board_digest: Digest
    mode: str
    solver: Solver
    tick_rate: int
    physics_version: PhysicsVersion
    tick: Annotated[int, Meta(description="The tick at which the log ends.")]
    world_digest: Annotated[
        str, Meta(description="SHA-256 of the whole state at that tick, balls in flight included.")
    ]
    digest: Annotated[
        str | None,
        Meta(description="SHA-256 over the world's digest and each drop's; null of a part."),
    ]
    board: BoardRef | msgspec.UnsetType = msgspec.UNSET  # not in a scene
    scene: Annotated[
        JsonObject | msgspec.UnsetType | None, Meta(description="A scene's parameters.")
    ] = msgspec.UNSET
    drops: Annotated[
        list[LoggedDrop] | msgspec.UnsetType, Meta(description="Where balls pass each other.")
    ] = msgspec.UNSET
    inputs: Annotated[
        list[LoggedInput] | msgspec.UnsetType,
        Meta(description="Where balls touch each other: the messages that changed the room."),
    ] = msgspec.UNSET
    first: Annotated[
        int | msgspec.UnsetType, Meta(description="Of a part: the number of its first entry.")
    ] = msgspec.UNSET
    next: Annotated[
        int | msgspec.UnsetType | None,
        Meta(description="Of a part: `first` of the following one; null on the last."),
    ] = msgspec.UNSET


class RoomDropRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ball for a room."""

    seed: SeedIn = None
    x: StartIn = None
    aim: AimIn = None
    stake: Annotated[
        Json,
        Meta(
            description="Whole minor units; `landed` has the payout. Needs a `session`.",
            extra_json_schema={
                "anyOf": [{"type": "integer", "minimum": 0, "maximum": MAX_STAKE}, {"type": "null"}]
            },
        ),
    ] = None
    who: Annotated[
        Json,
        Meta(
            description="A mark of the player's own, kept with the drop.",
            extra_json_schema={
                "anyOf": [
                    {"type": "string", "minLength": 1, "maxLength": MAX_WHO},
                    {"type": "null"},
                ]
            },
        ),
    ] = None
    session: Annotated[
        str | None,
        Meta(description="The session whose next drop this is; show its token. No seed, no x."),
    ] = None
    name: NameIn = None
    colour: ColourIn = None


class RoomDrop(msgspec.Struct, frozen=True, omit_defaults=True):
    """A ball accepted in a room; how it ends once it is waited for."""

    room: str
    ball: int
    seed: Seed
    x: float
    tick: Annotated[int, Meta(description="The room's tick at which it starts.")]
    landed: Annotated[
        Json, Meta(description="The `landed` event, with `wait=1`.", extra_json_schema={})
    ] = None
    practice: Annotated[
        bool, Meta(description="Whether its seed or x was chosen: there where it was.")
    ] = False
    receipt: Annotated[
        SignedReceipt | None, Meta(description="Of a drop of a session: its place in the log.")
    ] = None
    name: str | None = None
    colour: str | None = None
