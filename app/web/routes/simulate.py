"""Many drops at once: where they land, in numbers."""

import functools
import time

from fastapi import APIRouter, Request, Response

from app.errors import InvalidValueError
from app.web.routes.common import (
    Server,
    body_of,
    chosen_solver,
    documented,
    read,
    reply,
    resolve_board,
)
from app.web.schemas.drops import Simulation, SimulationRequest
from engine import Board, drop_many
from engine.drops.tally import Tally
from engine.parameters import Solver
from engine.seeding import parse_seed

router = APIRouter(prefix="/api/v1", tags=["drops"])

_CHUNK = 100  # drops between two looks at the clock: a few ms on any preset
MAX_SECONDS = 10.0
"""s of one thread. Only boards where balls bounce for ever, or tiny steps, take so long."""


@router.post(
    "/simulate",
    summary="Compute many drops",
    responses=documented(Simulation, 400, 404, 413, 422, 503),
    openapi_extra=body_of(SimulationRequest, {"board": "triangle-16", "drops": 100, "seed": "0"}),
)
async def simulate(request: Request, server: Server) -> Response:
    """Drop balls with the seeds `seed`, `seed` + 1, … and count where they land.

    Up to the server's `--max-simulation`; for more there is `plinko simulate`, whose numbers are
    the same.
    """
    body = await read(request, SimulationRequest)
    most = server.settings.max_simulation
    if not 1 <= body.drops <= most:
        raise InvalidValueError(
            f"drops {body.drops} is not from 1 to {most}; plinko simulate takes more", field="drops"
        )
    solver = chosen_solver(server, body.solver, body.dt, body.substeps)
    first = parse_seed(body.seed)
    parse_seed(first + body.drops - 1)
    board = await resolve_board(server, body.board)
    run = functools.partial(tally_of, board, first, body.drops, solver)
    return reply(Simulation(**(await server.workers.run(run)).summary()))


def tally_of(board: Board, first: int, drops: int, solver: Solver) -> Tally:
    """The tally of the drops; raises InvalidValueError when they take a thread for too long."""
    tally = Tally(board, solver)
    started = time.monotonic()
    how = {"solver": solver.name, "threads": 1, **solver.fields()}
    while tally.drops < drops:
        seeds = range(first + tally.drops, first + min(tally.drops + _CHUNK, drops))
        tally.add(drop_many(board, seeds, **how))  # type: ignore[arg-type]
        if tally.drops < drops and time.monotonic() - started > MAX_SECONDS:
            raise InvalidValueError(
                f"drops {drops} take too long on this board: {tally.drops} were done after "
                f"{MAX_SECONDS:g} s; plinko simulate takes its time",
                field="drops",
            )
    return tally
