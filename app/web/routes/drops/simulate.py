"""Many drops at once: where they land, in numbers."""

from fastapi import APIRouter, Request, Response

from app.computing import prices, tasks
from app.errors import InvalidValueError
from app.web.routes.common import (
    Server,
    body_of,
    chosen_solver,
    compute,
    documented,
    read,
    reply,
    resolve_board,
)
from app.web.schemas.drops import Simulation, SimulationRequest
from engine.seeding import parse_seed

router = APIRouter(prefix="/api/v1", tags=["drops"])


@router.post(
    "/simulate",
    summary="Compute many drops",
    responses=documented(Simulation, 400, 404, 413, 422, 503),
    openapi_extra=body_of(SimulationRequest, {"board": "triangle-16", "drops": 100, "seed": "0"}),
)
async def simulate(request: Request, server: Server) -> Response:
    """Drop balls with the seeds `seed`, `seed` + 1, … and count where they land.

    Up to 10,000; for more there is `plinko simulate`, whose numbers are
    the same.
    """
    body = await read(request, SimulationRequest)
    most = prices.MAX_DROPS
    if not 1 <= body.drops <= most:
        raise InvalidValueError(
            f"drops {body.drops} is not from 1 to {most}; plinko simulate takes more", field="drops"
        )
    solver = chosen_solver(body.solver, body.dt, body.substeps)
    first = parse_seed(body.seed)
    parse_seed(first + body.drops - 1)
    board = await resolve_board(request, body.board)
    price = prices.many_drops(board, body.drops, solver)
    found = await compute(request, price, tasks.tally, board, first, body.drops, solver)
    return reply(Simulation(**found))
