"""Bodies of the routes for rooms and scenes."""

import functools
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from plinko.app.protocol.messages import BallStart, DrawOdds, Extent, SignedReceipt, Stats
from plinko.app.rooms.draw import MAX_SEEDS
from plinko.app.rooms.stakes import MAX_STAKE, MAX_WHO
from plinko.app.rooms.touching.story import StoryForm
from plinko.app.web.schemas.fields import (
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
from plinko.engine.drops.draws import MAX_WEIGHT
from plinko.engine.json_text import Json, JsonObject


class DrawForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Exact odds for a board's bins, and the seeds that lead into each; `find_draw` makes it."""

    weights: Annotated[
        Json,
        Meta(
            description="One for each bin, left to right: the chance of a bin is its weight "
            "divided by the sum of all weights.",
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
            description="For each bin with a weight, seeds whose balls land there; for any other "
            f"bin an empty list. At most {MAX_SEEDS:,} in all.",
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
    """A room's draw. Its digest is the SHA-256 of this object as canonical JSON (RFC 8785)."""

    kind: Literal["plinko draw"]
    version: Literal[1]
    board_digest: Digest
    weights: list[int]
    seeds: list[list[Seed]]


class RoomRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A room to open: over a board, as a scene, or from a story."""

    board: OptionalBoard = msgspec.field(default_factory=functools.partial(msgspec.Raw, b"null"))
    mode: Annotated[
        Literal["independent", "interacting", "draw"],
        Meta(
            description="`independent`: balls pass through each other. `interacting`: they touch "
            "each other. `draw`: they pass through each other, and each ball's bin is drawn with "
            "the odds in `draw`."
        ),
    ] = "independent"
    draw: Annotated[DrawForm | None, Meta(description="Only with the mode `draw`.")] = None
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
            description="Instead of a scene: a box that was played elsewhere, with all its inputs. "
            "The room continues from its state, to the last bit."
        ),
    ] = None

    def has(self, name: str) -> bool:
        """Whether this field was given and is not null."""
        value = getattr(self, name)
        return bytes(value) != b"null" if isinstance(value, msgspec.Raw) else value is not None


class SceneView(msgspec.Struct, frozen=True):
    """A scene: its name, its public room, and its parameters."""

    name: str
    room: str
    parameters: Annotated[JsonObject, Meta(description="With their defaults.")]


class SceneList(msgspec.Struct, frozen=True):
    """The scenes; the ranges of their parameters, with units; the presets by name."""

    scenes: list[SceneView]
    ranges: JsonObject
    presets: dict[str, dict[str, float]]


class RoomChange(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A change of a room; the room is reset with it."""

    board: BoardIn


class RoomSummary(msgspec.Struct, frozen=True):
    """A room's entry in a list."""

    id: str
    board_name: str
    board_digest: Digest
    mode: str
    tick: int
    awake: Annotated[bool, Meta(description="Whether anything moves.")]
    balls: Annotated[int, Meta(description="Balls in flight.")]
    clients: int
    drops: Annotated[
        int, Meta(description="Drops accepted until now; inputs, in a room of touching balls.")
    ]


class RoomList(msgspec.Struct, frozen=True):
    """Open rooms. Every preset's name is also a room, which opens at the first request for it."""

    rooms: list[RoomSummary]
    next: Annotated[
        str | None, Meta(description="Send it as `after` for the next page; null on the last.")
    ]


class RoomView(msgspec.Struct, frozen=True):
    """A room with its balls in flight and its statistics."""

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
        bool, Meta(description="Whether it has an owner; the owner may change, reset or close it.")
    ]
    extent: Extent
    balls: Annotated[list[BallStart], Meta(description="The drops in flight.")]
    stats: Stats
    scene: Annotated[
        JsonObject | None,
        Meta(description="The scene as it was opened; null for a room with a board."),
    ]
    draw: Annotated[
        DrawOdds | None,
        Meta(description="The odds with which bins are drawn; null if only the seeds decide."),
    ]


class RoomOpened(RoomView, frozen=True):
    """A new room with its owner's token."""

    token: Annotated[
        str | None,
        Meta(
            description="Send it as `Authorization: Bearer TOKEN` to change the room. Null for a "
            "repeated request without the `Idempotency-Secret` of the first one."
        ),
    ]


class LoggedResult(msgspec.Struct, frozen=True):
    """The result of a drop in a room."""

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
    x: Annotated[float | None, Meta(description="Explicit start; null: drawn from the seed.")]
    stake: Annotated[int, Meta(description="In minor units.")]
    who: str | None
    result: Annotated[LoggedResult | None, Meta(description="Null while the ball is in flight.")]
    aim: Annotated[
        float | msgspec.UnsetType,
        Meta(description="Middle of the starts that seeds draw, m; only if it was chosen."),
    ] = msgspec.UNSET
    name: Annotated[
        str | msgspec.UnsetType, Meta(description="Shown at the ball; no digest covers it.")
    ] = msgspec.UNSET
    colour: Annotated[
        str | msgspec.UnsetType, Meta(description="Of the ball, #rrggbb; no digest covers it.")
    ] = msgspec.UNSET


class LoggedInput(msgspec.Struct, frozen=True):
    """A message that changed a room of touching balls."""

    tick: Annotated[int, Meta(description="The room's tick at which it took effect.")]
    who: str | None
    input: Annotated[JsonObject, Meta(description="Its `type` and fields.")]


class RoomLog(msgspec.Struct, frozen=True):
    """All inputs of a room and their results: enough to replay the room to the last bit."""

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
        str, Meta(description="SHA-256 of the whole state at `tick`, including balls in flight.")
    ]
    digest: Annotated[
        str | None,
        Meta(description="SHA-256 of the world's digest and each drop's; null for part of a log."),
    ]
    board: BoardRef | msgspec.UnsetType = msgspec.UNSET  # not in a scene
    scene: Annotated[
        JsonObject | msgspec.UnsetType | None, Meta(description="A scene's parameters.")
    ] = msgspec.UNSET
    drops: Annotated[
        list[LoggedDrop] | msgspec.UnsetType,
        Meta(description="In a room whose balls pass through each other."),
    ] = msgspec.UNSET
    inputs: Annotated[
        list[LoggedInput] | msgspec.UnsetType,
        Meta(description="In a room of touching balls: the messages that changed it."),
    ] = msgspec.UNSET
    first: Annotated[
        int | msgspec.UnsetType,
        Meta(description="In part of a log: the number of its first entry."),
    ] = msgspec.UNSET
    next: Annotated[
        int | msgspec.UnsetType | None,
        Meta(description="In part of a log: `first` of the next part; null in the last."),
    ] = msgspec.UNSET


class RoomDropRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A drop requested in a room."""

    seed: SeedIn = None
    x: StartIn = None
    aim: AimIn = None
    stake: Annotated[
        Json,
        Meta(
            description="Whole minor units that can pay at most 2^53 - 1 on the room's board; "
            "`landed` has the payout. Needs a `session`.",
            extra_json_schema={
                "anyOf": [{"type": "integer", "minimum": 0, "maximum": MAX_STAKE}, {"type": "null"}]
            },
        ),
    ] = None
    who: Annotated[
        Json,
        Meta(
            description="Any text that identifies the player; stored with the drop.",
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
        Meta(
            description="The session whose next drop this is. It needs the session's token, and "
            "no `seed` or `x`."
        ),
    ] = None
    name: NameIn = None
    colour: ColourIn = None


class RoomDrop(msgspec.Struct, frozen=True, omit_defaults=True):
    """A drop accepted in a room, with its result if the request waited for it."""

    room: str
    ball: int
    seed: Seed
    x: float
    tick: Annotated[int, Meta(description="The room's tick at which it starts.")]
    landed: Annotated[
        Json, Meta(description="The `landed` event, with `wait=1`.", extra_json_schema={})
    ] = None
    practice: Annotated[
        bool, Meta(description="Whether the player chose seed or x; only present if so.")
    ] = False
    receipt: Annotated[
        SignedReceipt | None, Meta(description="Only of a drop of a session: its place in the log.")
    ] = None
    name: str | None = None
    colour: str | None = None
