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


class BoardView(msgspec.Struct, frozen=True):
    """A whole board under its digest."""

    name: str
    digest: Digest
    board: WholeBoard
