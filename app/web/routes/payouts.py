"""Payout tables: solve one for a board, with as many drops as a request may have."""

from typing import Annotated

import msgspec
from fastapi import Request, Response
from msgspec import Meta

from plinko.app.computing import prices, tasks
from plinko.app.web.routes.common import (
    Server,
    body_of,
    check_count,
    compute,
    documented,
    read,
    reply,
    resolve_board,
)
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.boards import Odds
from plinko.app.web.schemas.fields import BoardIn, Digest
from plinko.engine.parameters import Exact
from plinko.engine.payouts.landings import aims_of


class PayoutsRequest(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, rename={"returned": "return"}
):
    """A board to solve a payout table for."""

    board: BoardIn
    returned: Annotated[float, Meta(description="Mean payout for a stake of 1, from 0.5 to 1.")] = (
        0.99
    )
    risk: Annotated[str, Meta(description="low, medium or high.")] = "medium"
    drops: Annotated[
        int,
        Meta(
            description="At most this many drops from each aim choose the table; as many more "
            "judge it."
        ),
    ] = 10_000


class LeastReturn(msgspec.Struct, frozen=True):
    """The aim with the lowest return."""

    aim: float | None
    returned: float = msgspec.field(name="return")


class Payouts(msgspec.Struct, frozen=True):
    """A solved table and its odds: the fields of `plinko payouts --json`."""

    board: str
    board_digest: Annotated[Digest, Meta(description="Of the board with this table.")]
    risk: str
    target: float
    multipliers: Annotated[list[float], Meta(description="Of all bins, left to right.")]
    drops: Annotated[int, Meta(description="Drops that judged the table, for all aims together.")]
    chosen_by: Annotated[int, Meta(description="Other drops, which chose the multipliers.")]
    least: LeastReturn
    aims: Annotated[list[Odds], Meta(description="The board's own start first.")]
    warnings: Annotated[
        list[str],
        Meta(
            description="Weak points of the table, a sentence each, about `rare_bins` and "
            "`falling_bins`."
        ),
    ]
    rare_bins: Annotated[
        list[int], Meta(description="Bins hit too rarely to know their multipliers.")
    ]
    falling_bins: Annotated[
        list[int],
        Meta(description="Bins that pay less than their neighbour nearer the middle."),
    ]


router = operations("boards")


@router.post(
    "/payouts",
    summary="Solve a payout table",
    responses=documented(Payouts),
    openapi_extra=body_of(PayoutsRequest, {"board": "triangle-8", "return": 0.99, "risk": "low"}),
)
async def solve_payouts(request: Request, server: Server) -> Response:
    """Find multipliers with the wanted return from the board's own start; judge them from each aim.

    Drops of later seeds, which did not choose the table, measure its return. With so few drops it
    is known only to about a percent; each aim has its interval in `doubt`. `plinko payouts`
    continues until it is known to 0.1 %.
    """
    body = await read(request, PayoutsRequest)
    check_count(body.drops, "plinko payouts")
    board = await resolve_board(request, body.board)
    drops = 2 * body.drops * len(aims_of(board))  # half choose the table, half judge it
    price = prices.many_drops(board, drops, Exact())
    chosen = (board, body.returned, body.risk, body.drops)
    return reply(await compute(request, price, tasks.payouts, *chosen))
