"""Payout tables: solve one for a board, by as many drops as a request may have."""

from fastapi import APIRouter, Request, Response

from app.computing import prices, tasks
from app.errors import InvalidValueError
from app.web.routes.common import Server, body_of, compute, documented, read, reply, resolve_board
from app.web.schemas.payouts import Payouts, PayoutsRequest
from engine.parameters import Exact
from engine.payouts.landings import aims_of

router = APIRouter(prefix="/api/v1", tags=["boards"])


@router.post(
    "/payouts",
    summary="Solve a payout table",
    responses=documented(Payouts, 400, 404, 413, 422, 503),
    openapi_extra=body_of(PayoutsRequest, {"board": "triangle-8", "return": 0.99, "risk": "low"}),
)
async def solve_payouts(request: Request, server: Server) -> Response:
    """Multipliers that give the return from the board's own start, and bounds from every aim.

    Drops of later seeds, which did not choose them, say what they return. So few know it to a
    percent or so; each aim says its interval. `plinko payouts` goes on until it is known to 0.1 %.
    """
    body = await read(request, PayoutsRequest)
    most = prices.MAX_DROPS
    if not 1 <= body.drops <= most:
        raise InvalidValueError(
            f"drops {body.drops} is not from 1 to {most}; plinko payouts takes more", field="drops"
        )
    board = await resolve_board(request, body.board)
    drops = 2 * body.drops * len(aims_of(board))  # some choose the table, as many judge it
    price = prices.many_drops(board, drops, Exact())
    chosen = (board, body.returned, body.risk, body.drops)
    return reply(await compute(request, price, tasks.payouts, *chosen))
