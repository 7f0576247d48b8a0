"""Bodies of the route that solves payout tables."""

from typing import Annotated

import msgspec
from msgspec import Meta

from app.web.schemas.boards import Odds
from app.web.schemas.fields import BoardIn, Digest


class PayoutsRequest(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, rename={"returned": "return"}
):
    """A board whose payout table is to be solved."""

    board: BoardIn
    returned: Annotated[float, Meta(description="Of a stake of 1, 0.5 to 1.")] = 0.99
    risk: Annotated[str, Meta(description="low, medium or high.")] = "medium"
    drops: Annotated[int, Meta(description="From each aim, at most; as many then judge.")] = 10_000


class LeastReturn(msgspec.Struct, frozen=True):
    """The aim that returns least."""

    aim: float | None
    returned: float = msgspec.field(name="return")


class Payouts(msgspec.Struct, frozen=True):
    """A solved table and what it gives: the fields of `plinko payouts --json`."""

    board: str
    board_digest: Annotated[Digest, Meta(description="Of the board with this table.")]
    risk: str
    target: float
    multipliers: Annotated[list[float], Meta(description="Of all bins, left to right.")]
    drops: Annotated[int, Meta(description="That judge the table, all aims together.")]
    chosen_by: Annotated[int, Meta(description="Others, that its multipliers were solved for.")]
    least: LeastReturn
    aims: Annotated[list[Odds], Meta(description="The board's own start first.")]
    warnings: Annotated[
        list[str],
        Meta(description="What the table cannot be trusted for: bins hit too rarely, a fall."),
    ]
