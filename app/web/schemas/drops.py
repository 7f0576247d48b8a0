"""Bodies of the routes that compute drops: one, its frames, its verdict, and many."""

from typing import Annotated

import msgspec
from msgspec import Meta

from app.web.schemas.fields import (
    AimIn,
    BoardIn,
    BoardRef,
    Digest,
    PhysicsVersion,
    SeedIn,
    Solver,
    StartIn,
)
from engine.json_text import Json

Dt = Annotated[
    float | None, Meta(description="Step in seconds, of the stepped solver alone; 1/60.")
]
Substeps = Annotated[
    int | None, Meta(description="Substeps a step, of the stepped solver alone; 4.")
]


class DropRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A drop to compute."""

    board: BoardIn
    seed: SeedIn = None
    x: StartIn = None
    aim: AimIn = None
    solver: Solver = "exact"
    dt: Dt = None
    substeps: Substeps = None
    certainty: Annotated[bool, Meta(description="Say also how sure the bin is.")] = False
    certified: Annotated[bool, Meta(description="Prove the bin as well.")] = False


class Enclosed(msgspec.Struct, frozen=True):
    """A real number that is proven to lie between two float64."""

    low: float
    high: float
    text: Annotated[str, Meta(description="Its first digits and the bound of their error.")]


EventRow = Annotated[tuple[float, ...], Meta(min_length=6, max_length=6)]


class Proven(msgspec.Struct, frozen=True):
    """What is proven of a drop about the board's numbers as they stand: a theorem."""

    certified: Annotated[bool, Meta(description="False when arithmetic did not decide it.")]
    x: Annotated[str, Meta(description="The start in metres, exactly.")]
    bin: int | None
    unsettled: Annotated[str | None, Meta(description="Why it does not land, proven too.")]
    undecided: Annotated[str | None, Meta(description="The comparison that was left open.")]
    x_end: Enclosed | None
    duration: Enclosed | None
    impacts: int
    bits: Annotated[int, Meta(description="Of precision that decided it.")]
    comparisons: Annotated[int, Meta(description="That were proven.")]
    ties: Annotated[list[str], Meta(description="Simultaneous by symmetry.")]
    double_bin: Annotated[int | None, Meta(description="The bin in double precision.")]
    agrees: Annotated[bool | None, Meta(description="Whether that is the proven one.")]
    events: Annotated[
        list[EventRow],
        Meta(description="[kind, index, t, x, y, error]: enclosed within error, in s and m."),
    ]


class DropRecord(msgspec.Struct, frozen=True):
    """A whole drop; feed it to `POST verify` as it is. The fields of `plinko drop --json`."""

    board: BoardRef
    board_digest: Digest
    seed: Annotated[str | None, Meta(description="The seed, as a decimal string.")]
    solver: Solver
    physics_version: PhysicsVersion
    bin: Annotated[int | None, Meta(description="Bin landed in; null when it never settles.")]
    score: Annotated[float, Meta(description="The bin's multiplier; 1 when it never settles.")]
    duration: Annotated[float, Meta(description="Seconds from start to landing.")]
    x_end: Annotated[float, Meta(description="Where it crossed into the bin, in metres.")]
    impacts: Annotated[
        list[Annotated[tuple[float, ...], Meta(min_length=8, max_length=8)]],
        Meta(description="[t, x, y, vx, vy, omega, kind, index] right after each impact."),
    ]
    digest: Digest
    label: Annotated[
        str | None, Meta(description="The prize: the text of the bin's label, only if it has one.")
    ] = None
    x: Annotated[float | None, Meta(description="Only when the start was explicit.")] = None
    aim: Annotated[
        float | None, Meta(description="Middle of what the seed draws, m; only when it was chosen.")
    ] = None
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
    certificate: Annotated[
        Proven | None, Meta(description="What is proven of the drop; only on request.")
    ] = None


class MapTile(msgspec.Struct, frozen=True):
    """A row of pixels of the map of starts."""

    x: Annotated[str, Meta(description="The start that is zoomed in on, m, exactly.")]
    width: Annotated[str, Meta(description="Of the whole strip, m, exactly.")]
    level: Annotated[int, Meta(description="Zooms by ten.")]
    first: Annotated[int, Meta(description="The strip's pixel that comes first here.")]
    bins: Annotated[
        list[int], Meta(description="From left to right; -1 stays, -2 undecided, -3 no start.")
    ]
    proofs: int
    whole: Annotated[
        int, Meta(description="Pixels proven for every start in them, not for the middle alone.")
    ]


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
    expected: Annotated[Json, Meta(description="What the record says.")]
    actual: Annotated[Json, Meta(description="What the engine computes.")]


class SimulationRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Many drops to compute and count."""

    board: BoardIn
    drops: Annotated[int, Meta(description="How many, at least 1.")] = 100
    seed: Annotated[
        Json,
        Meta(
            description="Of the first drop; then one more each.",
            extra_json_schema={"anyOf": [{"type": "string"}, {"type": "integer"}]},
        ),
    ] = "0"
    solver: Solver = "exact"
    dt: Dt = None
    substeps: Substeps = None


class SeedsRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A bin for which seeds are looked for."""

    board: BoardIn
    bin: Annotated[int, Meta(description="Its number from the left, from 0.")]
    count: Annotated[int, Meta(description="Seeds wanted, at least 1.")] = 1
    after: Annotated[
        Json,
        Meta(
            description="Begin with the seed after this one; from 0 on if left out.",
            extra_json_schema={
                "anyOf": [{"type": "string"}, {"type": "integer"}, {"type": "null"}]
            },
        ),
    ] = None
    drops: Annotated[int, Meta(description="Seeds to drop at most.")] = 10_000
    aim: Annotated[float | None, Meta(description="Middle of what the seeds draw, m.")] = None


class SeedsFound(msgspec.Struct, frozen=True):
    """The next seeds that land in a bin."""

    board_digest: Digest
    bin: int
    seeds: Annotated[list[str], Meta(description="In rising order, none left out up to `last`.")]
    last: Annotated[str, Meta(description="Last seed that was looked at: `after`, to go on.")]


class Simulation(msgspec.Struct, frozen=True):
    """What came of many drops: the fields of `plinko simulate --json`, but for its times."""

    board_digest: Digest
    drops: int
    histogram: Annotated[list[int], Meta(description="Balls in each bin.")]
    unsettled: Annotated[int, Meta(description="Balls that did not land.")]
    mean_duration: Annotated[float, Meta(description="Seconds.")]
    mean_impacts: float
    digest: Annotated[Digest, Meta(description="Over all outcomes, in the order of the seeds.")]
