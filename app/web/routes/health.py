"""Routes for the server's operator: health, readiness, metrics."""

import functools
from typing import Annotated, Literal

import msgspec
from fastapi import Depends, Request, Response
from fastapi.responses import PlainTextResponse
from msgspec import Meta

from plinko.app.errors import LedgerError
from plinko.app.protocol import asyncapi
from plinko.app.web.routes.common import Server, documented, reply
from plinko.app.web.routes.table import unlisted
from plinko.app.web.schemas.fields import PhysicsVersion
from plinko.app.web.services import Services
from plinko.app.web.tokens import check_bearer
from plinko.engine import PHYSICS_VERSION


class ClusterView(msgspec.Struct, frozen=True):
    """A server's view of its cluster."""

    name: str
    leases: Annotated[bool, Meta(description="Whether it sees the other servers.")]
    servers: Annotated[list[str], Meta(description="The names of the servers that are alive.")]
    rooms: Annotated[int, Meta(description="Number of rooms that this server has.")]


class TickerHealth(msgspec.Struct, frozen=True):
    """The ticker's counts since the server started."""

    asleep: bool
    ticks: int
    wakeups: int
    overruns: int
    skipped: int


class Health(msgspec.Struct, frozen=True):
    """Proof that the process answers, with the ticker's counts."""

    status: str
    version: str
    physics_version: PhysicsVersion
    ticker: TickerHealth


class RoomsBack(msgspec.Struct, frozen=True):
    """Rooms that cannot open."""

    set_aside: Annotated[
        list[str], Meta(description="Rooms whose record is damaged; at most the first 100.")
    ]


class Readiness(msgspec.Struct, frozen=True):
    """Whether the server can accept drops, by each check, and the state of its recovery."""

    ready: bool
    checks: dict[str, bool]
    rooms: RoomsBack
    integrity: Annotated[
        Literal["checking", "sound", "damaged", "unknown"],
        Meta(description="Result of the check of the ledger's database that runs at the start."),
    ]
    cluster: Annotated[
        ClusterView | None, Meta(description="Its cluster; null for a single server.")
    ] = None


router = unlisted(tags=["health"])

_NAMED = 100  # rooms that readiness names


@router.get("/healthz", summary="Liveness", responses=documented(Health))
async def healthz(server: Server) -> Response:
    """The process answers. The ticker's counts do not grow while nothing moves."""
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
    summary="Readiness",
    responses={
        **documented(Readiness, description="Ready"),
        **documented(Readiness, status=503, description="Not ready; `checks` says why"),
    },
)
async def readyz(server: Server) -> Response:
    """200 if the physics is compiled, the ticker runs, and ledger and workers work; else 503.

    To check ledger and workers, the server writes a database page and has a worker process compute
    something.

    `rooms` names rooms whose record is damaged. They do not affect the other rooms, so they do not
    make the server unready.
    """
    checks = {
        "ledger": await _writable(server),
        "physics": server.warm,
        "ticker": server.ticking is not None and not server.ticking.done(),
        "workers": await server.computing.workers.compute(),
    }
    if server.others is not None:
        checks["cluster"] = server.others.joined
    ready = all(checks.values())
    rooms = RoomsBack(list(server.rooms.persistence.recovery.set_aside)[:_NAMED])
    answer = Readiness(ready, checks, rooms, server.integrity.finding, _cluster(server))
    return reply(answer, 200 if ready else 503)


@router.get("/asyncapi.json", include_in_schema=False)
async def asyncapi_document(server: Server) -> Response:
    """The WebSocket's messages as an AsyncAPI document."""
    return reply(_asyncapi(server.version))


@functools.cache
def _asyncapi(version: str) -> bytes:
    """Made once, because it takes longer than most requests."""
    return msgspec.json.encode(asyncapi.document(version))


def _may_read(request: Request, server: Server) -> None:
    """Check the metrics' token, if the settings have one; raises NoTokenError or TokenError."""
    token = server.settings.metrics_token
    if token:
        check_bearer(request.headers.get("authorization"), token, "of the metrics")


@router.get(
    "/metrics",
    summary="Metrics",
    response_class=PlainTextResponse,
    responses=documented(
        None, 401, 403, media_type="text/plain", description="Prometheus' text format"
    ),
    dependencies=[Depends(_may_read)],
)
async def metrics(request: Request, server: Server) -> Response:
    """Counts and times for Prometheus; docs/server.md explains each."""
    await server.returns.refresh()
    body, media_type = server.metrics.exposition(request.headers.get("accept", ""))
    return Response(body, media_type=media_type, headers={"cache-control": "no-store"})


def _cluster(server: Services) -> ClusterView | None:
    if server.others is None:
        return None
    stands = server.others.standing()
    return ClusterView(stands.name, stands.leases, stands.members, stands.rooms)


async def _writable(server: Services) -> bool:
    """Whether the ledger can write a database page now."""
    try:
        await server.ledger.commit()
    except LedgerError:
        return False
    return True
