"""Moves: the operator moves a room from one server of a cluster to another."""

from fastapi import Request, Response

from plinko.app.web.routes.common import Server, body_of, documented, read, reply
from plinko.app.web.routes.rooms.operator import Token, check_operator
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.cluster import MoveRequest, MoveView
from plinko.engine.errors import MissingPartError

router = operations("health")


@router.post(
    "/rooms/{room}/move",
    summary="Move a room to another server",
    responses=documented(MoveView, 400, 401, 403, 404, 413, 422, 501, 503),
    openapi_extra=body_of(MoveRequest, {"to": "plinko2"}),
    dependencies=[Token],
)
async def move_room(room: str, request: Request, server: Server) -> Response:
    """Have another server of the cluster continue a room at its present tick.

    The room's clients are sent to that server. Only for the operator.
    """
    check_operator(request, server, "moving a room")
    body = await read(request, MoveRequest)
    if server.others is None:
        raise MissingPartError("this server is alone: rooms move between servers with a `--name`")
    found = await server.rooms.seek(room)
    peer = await server.others.move(found.id, body.to)
    await server.rooms.orders.give("move", found.id, body.to)
    return reply(MoveView(found.id, peer.name), headers={"cache-control": "no-store"})
