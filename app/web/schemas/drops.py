"""Bodies of the routes that compute drops: one drop, its frames, its verification, many drops."""

from typing import Annotated

import msgspec
from msgspec import Meta

from plinko.app.web.schemas.fields import (
    AimIn,
    BoardIn,
    BoardRef,
    Digest,
    PhysicsVersion,
    SeedIn,
    Solver,
    StartIn,
)
from plinko.engine.json_text import Json

Dt = Annotated[
    float | None, Meta(description="Step in seconds; only for the stepped solver. Default: 1/60.")
]
Substeps = Annotated[
    int | None, Meta(description="Substeps per step; only for the stepped solver. Default: 4.")
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
    certainty: Annotated[
        bool, Meta(description="Also estimate the error of `x_end` and whether the bin is certain.")
    ] = False
    certified: Annotated[bool, Meta(description="Also prove the bin.")] = False


class Enclosed(msgspec.Struct, frozen=True):
    """A real number that is proven to lie between two float64 values."""

    low: float
    high: float
    text: Annotated[str, Meta(description="Its first digits and a bound on their error.")]


EventRow = Annotated[tuple[float, ...], Meta(min_length=6, max_length=6)]


class Proven(msgspec.Struct, frozen=True):
    """What is proven of a drop, taking the board's numbers as exact."""

    certified: Annotated[bool, Meta(description="False if the precision did not suffice.")]
    x: Annotated[str, Meta(description="The start in metres, exactly.")]
    bin: int | None
    unsettled: Annotated[
        str | None, Meta(description="Why the ball does not land; this is proven too.")
    ]
    undecided: Annotated[str | None, Meta(description="The comparison that was not decided.")]
    x_end: Enclosed | None
    duration: Enclosed | None
    impacts: int
    bits: Annotated[int, Meta(description="Precision of the arithmetic that decided the drop.")]
    comparisons: Annotated[int, Meta(description="Number of proven comparisons.")]
    ties: Annotated[list[str], Meta(description="Events that symmetry makes simultaneous.")]
    double_bin: Annotated[int | None, Meta(description="The bin in double precision.")]
    agrees: Annotated[bool | None, Meta(description="Whether `double_bin` is the proven bin.")]
    events: Annotated[
        list[EventRow],
        Meta(
            description="[kind, index, t, x, y, error]: the true t, x and y are within `error` of "
            "these, in s and m."
        ),
    ]


class DropRecord(msgspec.Struct, frozen=True):
    """A whole drop, as `plinko drop --json` prints it. `POST verify` accepts it unchanged."""

    board: BoardRef
    board_digest: Digest
    seed: Annotated[str | None, Meta(description="The seed, as a decimal string.")]
    solver: Solver
    physics_version: PhysicsVersion
    bin: Annotated[int | None, Meta(description="The bin; null if the ball never lands.")]
    score: Annotated[float, Meta(description="The bin's multiplier; 1 if the ball never lands.")]
    duration: Annotated[float, Meta(description="Seconds from start to landing.")]
    x_end: Annotated[float, Meta(description="Where the ball entered the bin, in metres.")]
    impacts: Annotated[
        list[Annotated[tuple[float, ...], Meta(min_length=8, max_length=8)]],
        Meta(description="[t, x, y, vx, vy, omega, kind, index] right after each impact."),
    ]
    digest: Digest
    label: Annotated[
        str | None, Meta(description="The prize: the text of the bin's label, if it has one.")
    ] = None
    x: Annotated[float | None, Meta(description="Only if the start was explicit.")] = None
    aim: Annotated[
        float | None,
        Meta(description="Middle of the starts that seeds draw, m; only if it was chosen."),
    ] = None
    dt: Annotated[float | None, Meta(description="Only with the stepped solver.")] = None
    substeps: Annotated[int | None, Meta(description="Only with the stepped solver.")] = None
    correction: Annotated[
        float | None, Meta(description="Positional correction, only with the stepped solver.")
    ] = None
    amplification: Annotated[
        float | None,
        Meta(description="|dx_end / dx_start|; only on request. Null if the ball never lands."),
    ] = None
    x_error: Annotated[
        float | None, Meta(description="Estimated error of x_end in metres; only on request.")
    ] = None
    certain: Annotated[
        bool | None,
        Meta(
            description="Whether the bin stays the same if the start moves by half a unit in the "
            "last place; only on request."
        ),
    ] = None
    certificate: Annotated[
        Proven | None, Meta(description="What is proven of the drop; only on request.")
    ] = None


State = Annotated[tuple[float, ...], Meta(min_length=7, max_length=7)]


class Frames(msgspec.Struct, frozen=True):
    """The states of a ball at `fps` frames a second, and at the landing."""

    board_digest: Digest
    digest: Digest
    fps: float
    duration: float
    fields: list[str]
    frames: list[State]
    before: Annotated[
        list[State],
        Meta(description="The state right before each impact of the record, in the same order."),
    ]


class Verdict(msgspec.Struct, frozen=True):
    """Whether the drop of a record was reproduced; if not, the first field that differs."""

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
            description="Of the first drop; each next drop has the next seed.",
            extra_json_schema={"anyOf": [{"type": "string"}, {"type": "integer"}]},
        ),
    ] = "0"
    solver: Solver = "exact"
    dt: Dt = None
    substeps: Substeps = None


class SeedsRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A bin to find seeds for."""

    board: BoardIn
    bin: Annotated[int, Meta(description="Its number from the left, from 0.")]
    count: Annotated[int, Meta(description="Seeds wanted, at least 1.")] = 1
    after: Annotated[
        Json,
        Meta(
            description="Begin with the seed after this one; default: begin with 0.",
            extra_json_schema={
                "anyOf": [{"type": "string"}, {"type": "integer"}, {"type": "null"}]
            },
        ),
    ] = None
    drops: Annotated[int, Meta(description="Number of seeds to try at most.")] = 10_000
    aim: Annotated[float | None, Meta(description="Middle of the starts that seeds draw, m.")] = (
        None
    )


class SeedsFound(msgspec.Struct, frozen=True):
    """The next seeds whose balls land in a bin."""

    board_digest: Digest
    bin: int
    seeds: Annotated[
        list[str], Meta(description="In rising order; complete from the first seed to `last`.")
    ]
    last: Annotated[str, Meta(description="The last seed tried; send it as `after` to continue.")]


class Simulation(msgspec.Struct, frozen=True):
    """The results of many drops: the fields of `plinko simulate --json` without its times."""

    board_digest: Digest
    drops: int
    histogram: Annotated[list[int], Meta(description="Balls in each bin.")]
    unsettled: Annotated[int, Meta(description="Balls that did not land.")]
    mean_duration: Annotated[float, Meta(description="Seconds.")]
    mean_impacts: float
    digest: Annotated[Digest, Meta(description="Over all outcomes, in the order of the seeds.")]
