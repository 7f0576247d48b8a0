"""Bodies of the routes of boards."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from app.web.schemas.fields import Digest, WholeBoard


class BoardSummary(msgspec.Struct, frozen=True):
    """A board in a list."""

    name: str
    digest: Digest
    preset: bool
    bins: int
    pegs: int
    rows: Annotated[int | None, Meta(description="Rows of pegs, of a triangle preset.")]
    risk: Annotated[
        Literal["low", "medium", "high"] | None,
        Meta(description="Which payout table, of a triangle preset."),
    ]
    multipliers: list[float]


class BoardList(msgspec.Struct, frozen=True):
    """The presets, then the registered boards."""

    boards: list[BoardSummary]


class Award(msgspec.Struct, frozen=True):
    """A multiplier and how often it comes."""

    multiplier: float
    chance: float


class Odds(msgspec.Struct, frozen=True, rename={"returned": "return"}):
    """What a stake of 1 comes back as, from one aim, by the seeds 0, 1, 2 …"""

    aim: Annotated[float | None, Meta(description="m; null for the board's own start.")]
    drops: int
    returned: float
    doubt: Annotated[float, Meta(description="Half the interval of 95 % of the return.")]
    hit_rate: Annotated[float, Meta(description="How often at least the stake comes back.")]
    volatility: Annotated[float, Meta(description="Standard deviation of what comes back.")]
    unsettled: Annotated[int, Meta(description="Drops without a bin, the stake given back.")]
    chances: Annotated[list[float], Meta(description="Of each bin.")]
    awards: Annotated[list[Award], Meta(description="The highest first.")]


class BoardOdds(msgspec.Struct, frozen=True):
    """Odds of a board, from its own start first; none where they were never counted."""

    board_digest: Digest
    aims: list[Odds]


class BoardView(msgspec.Struct, frozen=True):
    """A whole board under its digest."""

    name: str
    digest: Digest
    board: WholeBoard
