"""What waits to be dropped into a room, over REST: add, look, pause, skip, clear."""

from collections.abc import Callable

from fastapi import APIRouter, Request, Response

from app.errors import InvalidValueError
from app.live.live_room import LiveRoom
from app.protocol.visitors import parse_tag
from app.rooms.pending import DropCommand, again_of
from app.rooms.queue import Queue
from app.web.routes.common import (
    Server,
    body_of,
    charge_drops,
    documented,
    limit_drops,
    read,
    reply,
)
from app.web.routes.rooms.rooms import Key, own_room
from app.web.routes.rooms.sessions import RoomToken as Token
from app.web.schemas.queues import QueueChange, QueuedItem, QueueRequest, QueueView
from app.web.services import Services

router = APIRouter(prefix="/api/v1/rooms", tags=["rooms"])


@router.get(
    "/{room}/queue",
    summary="Look at what waits in a room",
    responses=documented(QueueView, 404, 429, 503),
)
async def get_queue(room: str, server: Server) -> Response:
    """The balls that wait, for whom, and whether they are paused."""
    return reply(_view(await server.rooms.seek(room)))


@router.post(
    "/{room}/queue",
    status_code=202,
    summary="Have balls wait to be dropped into a room",
    responses=documented(
        QueueView, 400, 401, 403, 404, 413, 422, 429, 503, status=202, description="They wait"
    ),
    openapi_extra=body_of(QueueRequest, {"n": 3, "name": "Ada"}),
    dependencies=[Token],
)
async def add_to_queue(room: str, request: Request, server: Server, key: Key = None) -> Response:
    """The room drops `n` balls for a name, one `every` so many seconds; for its creator alone.

    At most twenty of them fall at a time; what comes later waits. It survives a restart of the
    server, with each ball dropped once. A room that is begun anew or closed forgets what waits.
    It counts as `n` drops of the client's address. Where the answer was `undecided`, or never came,
    ask again with the same `Idempotency-Key`: the balls wait once.
    """
    found = await own_room(room, request, server)  # first: it counts where its room is
    limit_drops(request, server)
    body = await read(request, QueueRequest)
    if not found.room.format.has_results:
        raise InvalidValueError(
            f"room {found.id!r} has balls that touch each other, and no queue", field="room"
        )
    tag = parse_tag(body.name, body.colour)
    found.room.check_drop(DropCommand(0), fair=False)
    again = None if key is None else again_of("queued", key, *tag.marks)
    if await found.queue.add(body.n, body.every, tag, again):
        charge_drops(request, server, body.n - 1)  # beside the one that was taken
    return reply(_view(found), 202)


@router.patch(
    "/{room}/queue",
    summary="Pause a room's queue or let it go on",
    responses=documented(QueueView, 400, 401, 403, 404, 413, 422, 429, 503),
    openapi_extra=body_of(QueueChange, {"paused": True}),
    dependencies=[Token],
)
async def change_queue(room: str, request: Request, server: Server) -> Response:
    """What falls goes on falling; for the room's creator alone."""
    found = await own_room(room, request, server)
    body = await read(request, QueueChange)
    await found.queue.change(lambda queue: queue.halted(body.paused))
    return reply(_view(found))


@router.post(
    "/{room}/queue/skip",
    summary="Skip the first of what waits in a room",
    responses=documented(QueueView, 401, 403, 404, 429, 503),
    dependencies=[Token],
)
async def skip_queued(room: str, request: Request, server: Server) -> Response:
    """Forget what is left of the first item; for the room's creator alone."""
    return await _changed(room, request, server, Queue.skipped)


@router.post(
    "/{room}/queue/clear",
    summary="Clear a room's queue",
    responses=documented(QueueView, 401, 403, 404, 429, 503),
    dependencies=[Token],
)
async def clear_queue(room: str, request: Request, server: Server) -> Response:
    """Forget all that waits; for the room's creator alone."""
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
