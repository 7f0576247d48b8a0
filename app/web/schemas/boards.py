"""Bodies of the routes for boards."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from plinko.app.web.schemas.fields import Digest, WholeBoard


class BoardSummary(msgspec.Struct, frozen=True, rename={"returned": "return"}):
    """A board's entry in a list."""

    name: str
    digest: Digest
    preset: bool
    stakes: Annotated[
        bool,
        Meta(description="Whether drops may have a stake. On all other boards they are practice."),
    ]
    world: Annotated[
        str | None, Meta(description="Of a preset: `house`, `moon`, …; null for other boards.")
    ]
    bins: int
    pegs: int
    rows: Annotated[int | None, Meta(description="Rows of pegs; only of a triangle preset.")]
    risk: Annotated[
        Literal["low", "medium", "high"] | None,
        Meta(description="The payout table; only of a triangle preset."),
    ]
    multipliers: list[float]
    returned: Annotated[
        float | None,
        Meta(description="Counted return from the board's own start; null if never counted."),
    ]
    top_multiplier: float


class BoardList(msgspec.Struct, frozen=True):
    """The presets, then the registered boards."""

    boards: list[BoardSummary]


class Award(msgspec.Struct, frozen=True):
    """A multiplier and its chance."""

    multiplier: float
    chance: float


class Odds(msgspec.Struct, frozen=True, rename={"returned": "return"}):
    """The payouts of a stake of 1 from one aim, counted over the seeds 0, 1, 2 …"""

    aim: Annotated[float | None, Meta(description="m; null for the board's own start.")]
    drops: int
    returned: float
    doubt: Annotated[
        float, Meta(description="Half the width of the return's 95 % confidence interval.")
    ]
    hit_rate: Annotated[
        float, Meta(description="Share of drops that pay back at least their stake.")
    ]
    volatility: Annotated[float, Meta(description="Standard deviation of the payout.")]
    unsettled: Annotated[
        int, Meta(description="Drops that ended in no bin; they pay back their stake.")
    ]
    chances: Annotated[list[float], Meta(description="Of each bin.")]
    awards: Annotated[list[Award], Meta(description="The highest first.")]


class BoardOdds(msgspec.Struct, frozen=True):
    """A board's odds, its own start first; empty for a board whose odds were never counted."""

    board_digest: Digest
    aims: list[Odds]


class BoardView(msgspec.Struct, frozen=True):
    """A whole board with its digest."""

    name: str
    digest: Digest
    board: WholeBoard
