"""For those who run the server: does it answer, can it take drops, how does it do."""

import functools
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import PlainTextResponse
from msgspec import Meta

from app.errors import LedgerError
from app.protocol import asyncapi
from app.web.routes.common import Server, documented, reply
from app.web.schemas.cluster import ClusterView
from app.web.schemas.fields import PhysicsVersion
from app.web.services import Services
from app.web.tokens import check_bearer
from engine import PHYSICS_VERSION


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


router = APIRouter(tags=["health"])

_NAMED = 100  # rooms that readiness names


@router.get("/healthz", summary="Is it alive", responses=documented(Health))
async def healthz(server: Server) -> Response:
    """The process answers; with the ticker's counts, which stand still while nothing moves."""
    ticker = server.rooms.ticker
    counts = TickerHealth(
        asleep=ticker.asleep,
        ticks=ticker.ticks,
        wakeups=ticker.wakeups,
        overruns=ticker.schedule.overruns,
        skipped=ticker.schedule.skipped,
    )
    return reply(Health("ok", server.version, PHYSICS_VERSION, counts))


@router.get(
    "/readyz",
    summary="Is it ready",
    responses={
        **documented(Readiness, description="Ready"),
        **documented(Readiness, status=503, description="Not ready; `checks` says why"),
    },
)
async def readyz(server: Server) -> Response:
    """200 when the physics is compiled, the ticker runs, work and drops are taken; else 503.

    Ledger and workers are tried: a page's worth is written, and a process computes something.

    `rooms` tells how the last server's rooms come back. One that is not back yet, or is set aside,
    keeps nobody from playing in the others, so it makes the server no less ready.
    """
    checks = {
        "ledger": await _writable(server),
        "physics": server.warm,
        "ticker": server.ticker_runs,
        "workers": await server.workers.compute(),
    }
    if server.others is not None:
        checks["cluster"] = server.others.joined
    ready = all(checks.values())
    rooms = RoomsBack(
        rebuilding=len(server.rooms.rebuilding.waiting),
        set_aside=list(server.rooms.persistence.recovery.set_aside)[:_NAMED],
    )
    answer = Readiness(ready, checks, rooms, server.integrity.finding, _cluster(server))
    return reply(answer, 200 if ready else 503)


@router.get(
    "/api/v1/integrity", summary="Is it what was installed", responses=documented(IntegrityView)
)
async def integrity(server: Server) -> Response:
    """Digests of code, kernels and configuration as they are now, beside those of the start.

    `plinko integrity` gives the same ones offline, of the same release with the same settings.
    """
    found = await server.self_check.look()
    return reply(IntegrityView(**found.to_dict()), headers={"cache-control": "no-store"})


@router.get("/asyncapi.json", include_in_schema=False)
async def asyncapi_document(server: Server) -> Response:
    """The WebSocket's messages, as an AsyncAPI document."""
    return reply(_asyncapi(server.version))


@functools.cache
def _asyncapi(version: str) -> bytes:
    """Made once: it takes longer than most requests."""
    return msgspec.json.encode(asyncapi.document(version))


def _may_read(request: Request, server: Server) -> None:
    """Raise NoTokenError or TokenError unless the request may read the metrics."""
    token = server.settings.metrics_token
    if token:
        check_bearer(request.headers.get("authorization"), token, "of the metrics")


@router.get(
    "/metrics",
    summary="How does it do",
    response_class=PlainTextResponse,
    responses=documented(
        None, 401, 403, media_type="text/plain", description="Prometheus' text format"
    ),
    dependencies=[Depends(_may_read)],
)
async def metrics(request: Request, server: Server) -> Response:
    """Counts and times for Prometheus; docs/server.md says what each means."""
    await server.returns.refresh()
    body, media_type = server.metrics.exposition(request.headers.get("accept", ""))
    return Response(body, media_type=media_type, headers={"cache-control": "no-store"})


def _cluster(server: Services) -> ClusterView | None:
    if server.others is None:
        return None
    stands = server.others.standing()
    return ClusterView(stands.name, stands.leases, stands.members, stands.rooms)


async def _writable(server: Services) -> bool:
    """Whether the ledger takes a page's worth of data now."""
    try:
        await server.ledger.probe()
    except LedgerError:
        return False
    return True
