"""Health: does the process answer, and can it take drops."""

from fastapi import APIRouter, Response

from app.routes.common import Server, documented, reply
from app.schemas import Health, Readiness, TickerHealth
from engine import PHYSICS_VERSION

router = APIRouter(tags=["health"])


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
    """200 when the physics is compiled, the ticker runs and work is taken; else 503."""
    checks = {
        "physics": server.warm,
        "ticker": server.ticker_runs,
        "workers": not server.workers.full,
    }
    ready = all(checks.values())
    return reply(Readiness(ready, checks), 200 if ready else 503)
