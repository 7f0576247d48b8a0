"""Bodies of the route that recalls a player's plays."""

from typing import Annotated

import msgspec
from msgspec import Meta

from app.web.schemas.fields import Digest, PhysicsVersion, Seed


class PlayView(msgspec.Struct, frozen=True):
    """A drop as it was played. Lengths in m, times in s, stake and payout in minor units."""

    play: Annotated[str, Meta(description="Its place; `before` of the page that follows it.")]
    room: str
    board: str
    board_digest: Digest
    physics_version: PhysicsVersion
    seed: Seed
    x: Annotated[float | None, Meta(description="The start, where the player chose it.")]
    aim: Annotated[float | None, Meta(description="Middle of what the seed drew, if chosen.")]
    stake: int
    practice: bool
    name: Annotated[str | None, Meta(description="Whose ball it was, as those who watched saw.")]
    colour: Annotated[str | None, Meta(description="Of the ball, #rrggbb.")]
    session: Annotated[str | None, Meta(description="The fair session that it was in.")]
    session_drop: Annotated[int | None, Meta(description="Its number there.")]
    time: Annotated[int | None, Meta(description="Of its receipt: Unix time, in ms.")]
    digest: Annotated[str | None, Meta(description="Of its whole path; null while it falls.")]
    bin: int | None
    label: Annotated[str | None, Meta(description="The prize: text of its bin's label.")]
    score: Annotated[float | None, Meta(description="The multiplier.")]
    payout: int | None
    duration: float | None
    x_end: float | None
    unsettled: str | None
    path: Annotated[str, Meta(description="Where its path is told, impact by impact.")]


class PlayList(msgspec.Struct, frozen=True):
    """A page of a player's plays, the last one first."""

    plays: list[PlayView]
    next: Annotated[str | None, Meta(description="`before` of the following page; null: no more.")]
