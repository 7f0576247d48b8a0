"""Request and reply bodies of the REST interface: one definition decodes, encodes and documents.

Values with a parser of their own (seeds, boards, starts) stay `Any` here, so that the parser that
knows what is wrong names it; what they may be is said in the description.
"""

import contextlib
import json
from typing import Annotated, Any, Literal, NoReturn, TypeVar

import msgspec
from msgspec import Meta

from app.errors import InvalidValueError, MalformedError
from app.protocol.messages import BallStart, Extent, Stats
from app.rooms.stakes import MAX_STAKE, MAX_WHO
from engine.parameters import DEFAULT_DT, DEFAULT_SUBSTEPS

T = TypeVar("T")

BoardRef = Annotated[
    Any,
    Meta(
        description="A preset's name, the digest of a registered board, or a whole board object.",
        examples=["triangle-16"],
        extra_json_schema={"anyOf": [{"type": "string"}, {"type": "object"}]},
    ),
]
SeedIn = Annotated[
    Any,
    Meta(
        description="0 <= seed < 2^64, as a decimal string or an integer; without it the server "
        "draws one.",
        examples=["42"],
        extra_json_schema={"anyOf": [{"type": "string"}, {"type": "integer"}, {"type": "null"}]},
    ),
]
StartIn = Annotated[
    Any,
    Meta(
        description="Explicit start in metres; without it the seed decides.",
        examples=[0.1],
        extra_json_schema={"anyOf": [{"type": "number"}, {"type": "null"}]},
    ),
]
Seed = Annotated[str, Meta(description="The seed, as a decimal string.", examples=["42"])]
Digest = Annotated[
    str, Meta(description="SHA-256, 64 hexadecimal digits.", pattern="^[0-9a-f]{64}$")
]
Solver = Annotated[
    Literal["exact", "stepped"],
    Meta(description="`exact`: event-driven, no stepping error. `stepped`: fixed steps of `dt`."),
]


class Problem(msgspec.Struct, frozen=True, omit_defaults=True):
    """An error, as RFC 9457 problem details; `detail` names the bad value."""

    type: str
    title: str
    status: int
    detail: str
    code: Annotated[str, Meta(description="Stable slug of the kind of error.")]
    field: Annotated[str | None, Meta(description="Where the bad value is, if in one place.")] = (
        None
    )
    instance: str | None = None


class BoardSummary(msgspec.Struct, frozen=True):
    """A board in a list."""

    name: str
    digest: Digest
    preset: bool
    bins: int
    pegs: int
    rows: Annotated[int | None, Meta(description="Rows of pegs, of a triangle preset.")]
    risk: Annotated[
        Literal["low", "medium", "high"] | None,
        Meta(description="Which payout table, of a triangle preset."),
    ]
    multipliers: list[float]


class BoardList(msgspec.Struct, frozen=True):
    """The presets, then the registered boards."""

    boards: list[BoardSummary]


class BoardView(msgspec.Struct, frozen=True):
    """A whole board under its digest."""

    name: str
    digest: Digest
    board: Annotated[Any, Meta(extra_json_schema={"type": "object"})]


class DropRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A drop to compute."""

    board: BoardRef
    seed: SeedIn = None
    x: StartIn = None
    solver: Solver = "exact"
    dt: Annotated[float, Meta(description="Step in seconds, of the stepped solver.")] = DEFAULT_DT
    substeps: Annotated[int, Meta(description="Substeps a step, of the stepped solver.")] = (
        DEFAULT_SUBSTEPS
    )
    certainty: Annotated[bool, Meta(description="Say also how sure the bin is.")] = False


class DropRecord(msgspec.Struct, frozen=True):
    """A whole drop; feed it to `POST verify` as it is. The fields of `plinko drop --json`."""

    board: BoardRef
    board_digest: Digest
    seed: Annotated[str | None, Meta(description="The seed, as a decimal string.")]
    solver: Solver
    physics_version: Any
    bin: Annotated[int | None, Meta(description="Bin landed in; null when it never settles.")]
    score: Annotated[float, Meta(description="The bin's multiplier; 1 when it never settles.")]
    duration: Annotated[float, Meta(description="Seconds from start to landing.")]
    x_end: Annotated[float, Meta(description="Where it crossed into the bin, in metres.")]
    impacts: Annotated[
        list[Annotated[tuple[float, ...], Meta(min_length=8, max_length=8)]],
        Meta(description="[t, x, y, vx, vy, omega, kind, index] right after each impact."),
    ]
    digest: Digest
    x: Annotated[float | None, Meta(description="Only when the start was explicit.")] = None
    dt: Annotated[float | None, Meta(description="Only with the stepped solver.")] = None
    substeps: Annotated[int | None, Meta(description="Only with the stepped solver.")] = None
    correction: Annotated[
        float | None, Meta(description="Positional correction, only with the stepped solver.")
    ] = None
    amplification: Annotated[
        float | None,
        Meta(description="|dx_end / dx_start|; only on request. Null when it never settles."),
    ] = None
    x_error: Annotated[
        float | None, Meta(description="Estimated error of x_end in metres; only on request.")
    ] = None
    certain: Annotated[
        bool | None,
        Meta(
            description="Whether the bin stands if the start moves by half a unit in the last "
            "place; only on request."
        ),
    ] = None


State = Annotated[tuple[float, ...], Meta(min_length=7, max_length=7)]


class Frames(msgspec.Struct, frozen=True):
    """The states of a ball at a steady rate, and at the landing."""

    board_digest: Digest
    digest: Digest
    fps: float
    duration: float
    fields: list[str]
    frames: list[State]
    before: Annotated[
        list[State],
        Meta(description="The state right before each impact of the record, in its order."),
    ]


class Verdict(msgspec.Struct, frozen=True):
    """Whether a record's drop was reproduced, and the first field that differs if not."""

    ok: bool
    field: str | None
    expected: Annotated[Any, Meta(description="What the record says.")]
    actual: Annotated[Any, Meta(description="What the engine computes.")]


class SimulationRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Many drops to compute and count."""

    board: BoardRef
    drops: Annotated[int, Meta(description="How many, at least 1.")] = 100
    seed: Annotated[
        Any,
        Meta(
            description="Of the first drop; then one more each.",
            extra_json_schema={"anyOf": [{"type": "string"}, {"type": "integer"}]},
        ),
    ] = "0"
    solver: Solver = "exact"
    dt: Annotated[float, Meta(description="Step in seconds, of the stepped solver.")] = DEFAULT_DT
    substeps: Annotated[int, Meta(description="Substeps a step, of the stepped solver.")] = (
        DEFAULT_SUBSTEPS
    )


class Simulation(msgspec.Struct, frozen=True):
    """What came of many drops: the fields of `plinko simulate --json`, but for its times."""

    board_digest: Digest
    drops: int
    histogram: Annotated[list[int], Meta(description="Balls in each bin.")]
    unsettled: Annotated[int, Meta(description="Balls that did not land.")]
    mean_duration: Annotated[float, Meta(description="Seconds.")]
    mean_impacts: float
    digest: Annotated[Digest, Meta(description="Over all outcomes, in the order of the seeds.")]


SceneValue = Annotated[
    Any, Meta(description="A parameter of the scene, as `GET scenes` lists them.")
]


class RoomRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A room to open, over a board or as a scene."""

    board: BoardRef = None
    mode: Annotated[
        Literal["independent", "interacting"],
        Meta(description="Whether balls pass through each other or knock each other."),
    ] = "independent"
    scene: Annotated[
        str | None,
        Meta(description="`sandbox` or `galton`, instead of a board; the rest is for scenes."),
    ] = None
    balls: SceneValue = None
    seed: SceneValue = None
    width: SceneValue = None
    height: SceneValue = None
    radii: SceneValue = None
    speed: SceneValue = None
    gravity: SceneValue = None
    drag: SceneValue = None
    restitution: SceneValue = None
    friction: SceneValue = None
    density: SceneValue = None
    damping: SceneValue = None
    correction: SceneValue = None
    dt: SceneValue = None
    substeps: SceneValue = None


SCENE_PARAMETERS = tuple(
    name for name in RoomRequest.__struct_fields__ if name not in ("board", "mode", "scene")
)


class SceneView(msgspec.Struct, frozen=True):
    """A scene by name, the room in which everybody may play it, and what it is made with."""

    name: str
    room: str
    parameters: Annotated[dict[str, Any], Meta(description="With their defaults.")]


class SceneList(msgspec.Struct, frozen=True):
    """The scenes; the ranges of what can be set, with units; the presets by name."""

    scenes: list[SceneView]
    ranges: dict[str, Any]
    presets: dict[str, dict[str, float]]


class RoomChange(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is to be different in a room; it begins anew with it."""

    board: BoardRef


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
    """The open rooms. Every preset's name is also a room, opened when first asked for."""

    rooms: list[RoomSummary]


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
        dict[str, Any] | None, Meta(description="As it was opened; null for a room with a board.")
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


class RoomLog(msgspec.Struct, frozen=True):
    """All that a room was told, and what came of it: enough to replay it to the last bit."""

    kind: str
    version: int
    room: str
    board: BoardRef
    board_digest: Digest
    mode: str
    solver: Solver
    tick_rate: int
    physics_version: Any
    tick: Annotated[int, Meta(description="The tick at which the log ends.")]
    world_digest: Annotated[
        str, Meta(description="SHA-256 of the whole state at that tick, balls in flight included.")
    ]
    drops: list[LoggedDrop]
    digest: Annotated[
        str, Meta(description="SHA-256 over the world's digest and each drop's, in order.")
    ]


class RoomDropRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ball for a room."""

    seed: SeedIn = None
    x: StartIn = None
    stake: Annotated[
        Any,
        Meta(
            description="Whole minor units, kept with the drop; `landed` has the payout.",
            extra_json_schema={
                "anyOf": [
                    {"type": "integer", "minimum": 0, "maximum": MAX_STAKE},
                    {"type": "null"},
                ]
            },
        ),
    ] = None
    who: Annotated[
        Any,
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


class RoomDrop(msgspec.Struct, frozen=True, omit_defaults=True):
    """A ball accepted in a room; how it ends once it is waited for."""

    room: str
    ball: int
    seed: Seed
    x: float
    tick: Annotated[int, Meta(description="The room's tick at which it starts.")]
    landed: Annotated[
        Any, Meta(description="The `landed` event, with `wait=1`.", extra_json_schema={})
    ] = None


class TickerHealth(msgspec.Struct, frozen=True):
    """The ticker's counts since the start."""

    asleep: bool
    ticks: int
    wakeups: int
    overruns: int
    skipped: int


class Health(msgspec.Struct, frozen=True):
    """That the process answers, and its clock's counts."""

    status: str
    version: str
    physics_version: Any
    ticker: TickerHealth


class Readiness(msgspec.Struct, frozen=True):
    """Whether the server can take drops; each check by itself."""

    ready: bool
    checks: dict[str, bool]


DOCUMENTED = (
    Problem,
    BoardList,
    BoardView,
    DropRequest,
    DropRecord,
    Frames,
    Verdict,
    SimulationRequest,
    Simulation,
    RoomRequest,
    SceneList,
    RoomChange,
    RoomList,
    RoomView,
    RoomOpened,
    RoomLog,
    RoomDropRequest,
    RoomDrop,
    Health,
    Readiness,
)


def components() -> dict[str, Any]:
    """The JSON Schemas of all bodies, by name, for OpenAPI's components."""
    return msgspec.json.schema_components(DOCUMENTED, ref_template="#/components/schemas/{name}")[1]


def decode(body: bytes, kind: type[T]) -> T:
    """A JSON body as `kind`.

    Raises MalformedError for what is not JSON, InvalidValueError for a wrong shape or for NaN and
    its kin, which JSON does not have.
    """
    try:
        return msgspec.json.decode(body, type=kind)
    except msgspec.ValidationError as error:
        raise InvalidValueError(f"body: {error}", field="body") from None
    except RecursionError:
        raise MalformedError("the body's JSON is nested too deeply", field="body") from None
    except (msgspec.DecodeError, ValueError) as error:
        _explain(body, error)


def _explain(body: bytes, error: Exception) -> NoReturn:
    """Raise the error that says best why `body` is not JSON."""

    def no_constant(name: str) -> NoReturn:
        raise InvalidValueError(f"body: {name} is not a JSON number", field="body")

    # What is not JSON in any dialect keeps the first reader's message.
    with contextlib.suppress(ValueError, RecursionError):
        json.loads(body, parse_constant=no_constant)
    raise MalformedError(f"the body is not JSON: {error}", field="body") from None
