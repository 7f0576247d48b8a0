"""Seeds that land in a bin: found by dropping one after the other."""

from fastapi import APIRouter, Request, Response

from app.computing import prices, tasks
from app.errors import InvalidValueError
from app.web.routes.common import Server, body_of, compute, documented, read, reply, resolve_board
from app.web.schemas.drops import SeedsFound, SeedsRequest
from engine.drops.seeds import check_bin
from engine.drops.start import aim_of
from engine.parameters import Exact
from engine.seeding import SEED_LIMIT, parse_seed

router = APIRouter(prefix="/api/v1", tags=["drops"])


@router.post(
    "/seeds",
    summary="Find seeds that land in a bin",
    responses=documented(SeedsFound, 400, 404, 413, 422, 503),
    openapi_extra=body_of(SeedsRequest, {"board": "triangle-16", "bin": 8, "count": 3}),
)
async def find_seeds(request: Request, server: Server) -> Response:
    """List the next seeds whose balls land in `bin`, in rising order, none left out.

    At most `drops` seeds are dropped, up to 10,000. Where fewer than `count` of them land in the
    bin, go on with `after` set to `last` of the reply. `plinko seeds` has no such limit.
    """
    body = await read(request, SeedsRequest)
    most = prices.MAX_DROPS
    for name in ("drops", "count"):
        value = getattr(body, name)
        if not 1 <= value <= most:
            raise InvalidValueError(
                f"{name} {value} is not from 1 to {most}; plinko seeds takes more", field=name
            )
    first = 0 if body.after is None else parse_seed(body.after) + 1
    if first == SEED_LIMIT:
        raise InvalidValueError(f"after {body.after} is the last seed", field="after")
    board = await resolve_board(request, body.board)
    check_bin(board, body.bin)
    aim = None if body.aim is None else aim_of(board, body.aim)
    price = prices.many_drops(board, body.drops, Exact())
    asked = (board, body.bin, first, body.count, body.drops, aim)
    found = await compute(request, price, tasks.seeds_in, *asked)
    return reply(SeedsFound(**found))
