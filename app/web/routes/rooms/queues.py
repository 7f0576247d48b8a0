"""A room's queue of balls over REST: add balls, list them, pause, skip, clear."""

from collections.abc import Callable
from typing import Annotated

import msgspec
from fastapi import Request, Response
from msgspec import Meta

from plinko.app.errors import InvalidValueError
from plinko.app.live.live_room import LiveRoom
from plinko.app.protocol.visitors import parse_tag
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.queue import MOST_BALLS, Queue
from plinko.app.web.routes.common import (
    Server,
    body_of,
    charge_drops,
    documented,
    limit_drops,
    read,
    reply,
)
from plinko.app.web.routes.rooms.repeats import OWNER, Repeats
from plinko.app.web.routes.rooms.rooms import own_room
from plinko.app.web.routes.rooms.sessions import RoomToken as Token
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.fields import ColourIn, NameIn
from plinko.app.web.services import Services


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


router = operations("rooms", "/api/v1/rooms")


@router.get("/{room}/queue", summary="Get a room's queue", responses=documented(QueueView))
async def get_queue(room: str, server: Server) -> Response:
    """The balls that wait, with their names, and whether the queue is paused."""
    return reply(_view(await server.rooms.seek(room)))


@router.post(
    "/{room}/queue",
    status_code=202,
    summary="Add balls to a room's queue",
    responses=documented(QueueView, status=202, description="Queued"),
    openapi_extra=body_of(QueueRequest, {"n": 3, "name": "Ada"}),
    dependencies=[Token],
)
async def add_to_queue(room: str, request: Request, server: Server, repeats: Repeats) -> Response:
    """Have the room drop `n` balls under one name, one `every` seconds. Only for its owner.

    At most twenty of them fall at a time; the next ones wait. The queue survives a restart of the
    server, and each ball is dropped once. Resetting or closing the room empties the queue. The
    request counts as `n` drops of the client's address. If the response was `undecided`, or never
    came, send the request again with the same `Idempotency-Key`: the balls are queued only once.
    """
    found = await own_room(room, request, server)  # first: the room's server counts the request
    limit_drops(request, server)
    body = await read(request, QueueRequest)
    if not found.room.format.has_results:
        raise InvalidValueError(
            f"room {found.id!r} has touching balls, and such a room has no queue", field="room"
        )
    tag = parse_tag(body.name, body.colour)
    found.room.check_drop(DropCommand(0), fair=False)
    use = repeats.use("queue", found.id, body, OWNER)
    await found.queue.add(body.n, body.every, tag, use)
    if use.is_new:
        charge_drops(request, server, body.n - 1)  # in addition to the one of `limit_drops`
    return reply(_view(found), 202)


@router.patch(
    "/{room}/queue",
    summary="Pause or resume a room's queue",
    responses=documented(QueueView),
    openapi_extra=body_of(QueueChange, {"paused": True}),
    dependencies=[Token],
)
async def change_queue(room: str, request: Request, server: Server) -> Response:
    """Pause or resume the queue; balls in flight are not affected. Only for the room's owner."""
    found = await own_room(room, request, server)
    body = await read(request, QueueChange)
    await found.queue.change(lambda queue: queue.halted(body.paused))
    return reply(_view(found))


@router.post(
    "/{room}/queue/skip",
    summary="Skip the first item of a room's queue",
    responses=documented(QueueView),
    dependencies=[Token],
)
async def skip_queued(room: str, request: Request, server: Server) -> Response:
    """Remove the rest of the first item. Only for the room's owner."""
    return await _changed(room, request, server, Queue.skipped)


@router.post(
    "/{room}/queue/clear",
    summary="Clear a room's queue",
    responses=documented(QueueView),
    dependencies=[Token],
)
async def clear_queue(room: str, request: Request, server: Server) -> Response:
    """Remove all balls that wait. Only for the room's owner."""
    return await _changed(room, request, server, Queue.cleared)


async def _changed(
    room: str, request: Request, server: Services, step: Callable[[Queue], Queue]
) -> Response:
    found = await own_room(room, request, server)
    await found.queue.change(step)
    return reply(_view(found))


def _view(live: LiveRoom) -> QueueView:
    queue = live.queue
    items = [
        QueuedItem(item.number, item.balls, left, item.every, **item.tag.fields)
        for item, left in queue.items
    ]
    return QueueView(live.id, queue.state.paused, queue.waiting, items)
