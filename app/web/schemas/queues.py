"""Bodies of the routes for a room's queue of balls."""

from typing import Annotated

import msgspec
from msgspec import Meta

from plinko.app.rooms.queue import MOST_BALLS
from plinko.app.web.schemas.fields import ColourIn, NameIn


class QueueRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Balls to queue, all with the same name and colour."""

    n: Annotated[int, Meta(ge=1, le=MOST_BALLS, description="How many balls.")]
    name: NameIn = None
    colour: ColourIn = None
    every: Annotated[
        float, Meta(ge=0.02, le=60.0, description="Seconds from one of the balls to the next.")
    ] = 0.5


class QueueChange(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A change of a queue."""

    paused: bool


class QueuedItem(msgspec.Struct, frozen=True, omit_defaults=True):
    """An item of the queue: balls with the same name and colour."""

    number: Annotated[int, Meta(description="Identifies the item until the room is reset.")]
    n: Annotated[int, Meta(description="How many balls it had at first.")]
    left: Annotated[int, Meta(description="How many of them still wait.")]
    every: float
    name: str | None = None
    colour: str | None = None


class QueueView(msgspec.Struct, frozen=True):
    """The balls that wait to be dropped into a room."""

    room: str
    paused: bool
    waiting: Annotated[int, Meta(description="Balls of all items.")]
    items: Annotated[list[QueuedItem], Meta(description="In the order in which they are dropped.")]
