"""Rooms over REST: list, open, look at, and drop a ball into."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from app.ledger.records import Parked
from app.protocol import parse_x
from app.room import MODE, SOLVER, Room
from app.routes.common import (
    Server,
    body_of,
    documented,
    limit_drops,
    optional_seed,
    read,
    reply,
    resolve_board,
)
from app.schemas import (
    RoomDrop,
    RoomDropRequest,
    RoomList,
    RoomRequest,
    RoomSummary,
    RoomView,
)
from app.services import Services

router = APIRouter(prefix="/api/v1/rooms", tags=["rooms"])


@router.get("", summary="List the rooms", responses=documented(RoomList))
async def list_rooms(server: Server) -> Response:
    """The open rooms. `main` is always there; every preset's name is a room too, once asked for."""
    rooms = [_summary(server, room) for room in server.rooms.all()]
    return reply(RoomList([*map(_parked, server.rooms.parked()), *rooms]))


@router.post(
    "",
    status_code=201,
    summary="Open a room",
    responses=documented(RoomView, 400, 404, 413, 422, 429, 503, status=201, description="Opened"),
    openapi_extra=body_of(RoomRequest, {"board": "triangle-12-high"}),
)
async def open_room(request: Request, server: Server) -> Response:
    """Open a room with an id of its own over any board; watch it at `/ws/rooms/{id}`."""
    body = await read(request, RoomRequest)
    room = await server.rooms.create(await resolve_board(server, body.board))
    return reply(_view(server, room), 201, {"location": f"/api/v1/rooms/{room.id}"})


@router.get("/{room}", summary="Look at a room", responses=documented(RoomView, 404, 429, 503))
async def get_room(room: str, server: Server) -> Response:
    """The room's clock, its balls in flight by their starts, and what came of the others."""
    return reply(_view(server, await server.rooms.seek(room)))


@router.post(
    "/{room}/drops",
    status_code=202,
    summary="Drop a ball into a room",
    responses={
        **documented(RoomDrop, 400, 404, 413, 422, 429, 503, status=202, description="In flight"),
        **documented(RoomDrop, status=200, description="Landed, with `wait=1`"),
    },
    openapi_extra=body_of(RoomDropRequest, {"seed": "42"}, required=False),
)
async def post_room_drop(
    room: str,
    request: Request,
    server: Server,
    wait: Annotated[bool, Query(description="Reply only once the ball has landed.")] = False,
) -> Response:
    """Put a ball in; everyone who watches sees it fall.

    With `wait=1` the reply comes with the landing, or as 202 without it should that take too long.
    """
    limit_drops(request, server)
    body = await read(request, RoomDropRequest, empty=RoomDropRequest())
    found = await server.rooms.seek(room)
    accepted = await server.rooms.drop(found, optional_seed(body.seed), parse_x(body.x))
    landed = None
    if wait:
        landed = await server.rooms.landing(found, accepted.ball, server.settings.wait_limit)
    drop = RoomDrop(found.id, accepted.ball, accepted.seed, accepted.x, accepted.tick, landed)
    return reply(drop, 202 if landed is None else 200)


def _summary(server: Services, room: Room) -> RoomSummary:
    return RoomSummary(
        id=room.id,
        board_name=room.board.name,
        board_digest=room.board.digest,
        mode=MODE,
        tick=room.world.tick,
        awake=room.awake,
        balls=len(room.balls),
        clients=server.hub.count(room.id),
        drops=room.drops,
    )


def _parked(room: Parked) -> RoomSummary:
    return RoomSummary(
        id=room.id,
        board_name=room.board_name,
        board_digest=room.board,
        mode=room.mode,
        tick=room.tick,
        awake=False,
        balls=0,
        clients=0,
        drops=room.drops,
    )


def _view(server: Services, room: Room) -> RoomView:
    return RoomView(
        id=room.id,
        board_name=room.board.name,
        board_digest=room.board.digest,
        mode=MODE,
        solver=SOLVER,
        tick=room.world.tick,
        tick_rate=room.tick_rate,
        awake=room.awake,
        clients=server.hub.count(room.id),
        extent=room.extent,
        balls=room.balls,
        stats=room.stats(),
    )
