"""Many drops at once: count where they land, and find the seeds that land in a bin."""

from fastapi import Request, Response

from plinko.app.computing import prices, tasks
from plinko.app.errors import InvalidValueError
from plinko.app.web.routes.common import (
    Server,
    body_of,
    check_count,
    chosen_solver,
    compute,
    documented,
    read,
    reply,
    resolve_board,
)
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.drops import SeedsFound, SeedsRequest, Simulation, SimulationRequest
from plinko.engine.drops.seeds import check_bin
from plinko.engine.drops.start import aim_of
from plinko.engine.parameters import Exact
from plinko.engine.seeding import SEED_LIMIT, parse_seed

router = operations("drops")


@router.post(
    "/simulate",
    summary="Compute many drops",
    responses=documented(Simulation),
    openapi_extra=body_of(SimulationRequest, {"board": "triangle-16", "drops": 100, "seed": "0"}),
)
async def simulate(request: Request, server: Server) -> Response:
    """Drop balls with the seeds `seed`, `seed` + 1, … and count where they land.

    At most 10,000 drops. `plinko simulate` has no limit and gives the same numbers.
    """
    body = await read(request, SimulationRequest)
    check_count(body.drops, "plinko simulate")
    solver = chosen_solver(body.solver, body.dt, body.substeps)
    first = parse_seed(body.seed)
    parse_seed(first + body.drops - 1)
    board = await resolve_board(request, body.board)
    price = prices.many_drops(board, body.drops, solver)
    found = await compute(request, price, tasks.tally, board, first, body.drops, solver)
    return reply(Simulation(**found))


@router.post(
    "/seeds",
    summary="Find seeds that land in a bin",
    responses=documented(SeedsFound),
    openapi_extra=body_of(SeedsRequest, {"board": "triangle-16", "bin": 8, "count": 3}),
)
async def find_seeds(request: Request, server: Server) -> Response:
    """List the next seeds whose balls land in `bin`, in rising order and without gaps.

    The server tries at most `drops` seeds, up to 10,000. If fewer than `count` of them land in the
    bin, continue with `after` set to the response's `last`. `plinko seeds` has no such limit.
    """
    body = await read(request, SeedsRequest)
    check_count(body.drops, "plinko seeds")
    check_count(body.count, "plinko seeds", "count")
    first = 0 if body.after is None else parse_seed(body.after) + 1
    if first == SEED_LIMIT:
        raise InvalidValueError(f"after {body.after} is the last seed there is", field="after")
    board = await resolve_board(request, body.board)
    check_bin(board, body.bin)
    aim = None if body.aim is None else aim_of(board, body.aim)
    price = prices.many_drops(board, body.drops, Exact())
    asked = (board, body.bin, first, body.count, body.drops, aim)
    found = await compute(request, price, tasks.seeds_in, *asked)
    return reply(SeedsFound(**found))
