"""Bodies of the routes that say how the server is."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from app.web.schemas.cluster import ClusterView
from app.web.schemas.fields import PhysicsVersion


class TickerHealth(msgspec.Struct, frozen=True):
    """The ticker's counts since the start."""

    asleep: bool
    ticks: int
    wakeups: int
    overruns: int
    skipped: int


Sha256 = Annotated[str, Meta(pattern="^[0-9a-f]{64}$", description="SHA-256, in hexadecimal.")]


class IntegrityView(msgspec.Struct, frozen=True):
    """Digests of the program's files and of its settings, which `plinko integrity` reproduces."""

    code: Sha256
    kernels: Sha256
    configuration: Sha256
    whole: Annotated[Sha256, Meta(description="Of the three others.")]
    at: Annotated[float, Meta(description="When the files were read: Unix time, in s.")]
    at_start: Annotated[Sha256, Meta(description="`whole` when the server started.")]
    unchanged: Annotated[bool, Meta(description="Whether both are the same.")]


class Health(msgspec.Struct, frozen=True):
    """That the process answers, and its clock's counts."""

    status: str
    version: str
    physics_version: PhysicsVersion
    ticker: TickerHealth


class RoomsBack(msgspec.Struct, frozen=True):
    """Rooms from before the start: how many are not back yet, and which were set aside."""

    rebuilding: int
    set_aside: Annotated[list[str], Meta(description="Their record is damaged; the first 100.")]


class Readiness(msgspec.Struct, frozen=True):
    """Whether the server can take drops; each check by itself, and what of it is still going on."""

    ready: bool
    checks: dict[str, bool]
    rooms: RoomsBack
    integrity: Annotated[
        Literal["checking", "sound", "damaged", "unknown"],
        Meta(description="What the look at the ledger's database at the start has found."),
    ]
    cluster: Annotated[
        ClusterView | None, Meta(description="Among which servers it is; null for one alone.")
    ] = None
