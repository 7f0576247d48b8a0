"""Halts: the operator stops drops in one room or in all, and allows them again."""

from typing import Annotated

import msgspec
from fastapi import Request, Response
from msgspec import Meta

from plinko.app.rooms.records import EVERY_ROOM
from plinko.app.web.routes.common import Server, body_of, documented, read, reply
from plinko.app.web.routes.rooms.operator import Token, check_operator
from plinko.app.web.routes.table import operations
from plinko.app.web.services import Services


class HaltRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Halt a room, or resume it."""

    halted: Annotated[bool, Meta(description="True halts the room, false resumes it.")]
    room: Annotated[str | None, Meta(description="The room's id; null: all rooms.")] = None


class HaltedTable(msgspec.Struct, frozen=True):
    """A room that refuses drops."""

    room: str
    since: Annotated[float, Meta(description="Unix time, in s.")]


class HaltView(msgspec.Struct, frozen=True):
    """All halts in force."""

    all_since: Annotated[
        float | None,
        Meta(description="When all rooms were halted, Unix time in s; null if they are not."),
    ]
    rooms: Annotated[list[HaltedTable], Meta(description="The rooms halted one by one.")]


router = operations("health")


@router.get("/halts", summary="List the halted rooms", responses=documented(HaltView))
async def get_halts(server: Server) -> Response:
    """The rooms that refuse drops now. Balls in flight there still land and are paid."""
    return reply(_view(server), headers={"cache-control": "no-store"})


@router.post(
    "/halts",
    summary="Halt or resume rooms",
    responses=documented(HaltView, 400, 401, 403, 404, 413, 422, 503),
    openapi_extra=body_of(HaltRequest, {"room": "main", "halted": True}),
    dependencies=[Token],
)
async def change_halts(request: Request, server: Server) -> Response:
    """Halt or resume a room, or all rooms with `room` null. Only for the operator.

    A halted room refuses new drops; balls in flight land and are paid. The ledger stores the halt,
    so it survives a restart. Resuming all rooms does not resume those that were halted one by one.
    """
    check_operator(request, server, "halting a room")
    body = await read(request, HaltRequest)
    room_id = EVERY_ROOM if body.room is None else (await server.rooms.seek(body.room)).id
    halts = server.rooms.halts
    await (halts.halt(room_id) if body.halted else halts.release(room_id))
    return reply(_view(server), headers={"cache-control": "no-store"})


def _view(server: Services) -> HaltView:
    since = server.rooms.halts.since
    everything = since.pop(EVERY_ROOM, None)
    return HaltView(everything, [HaltedTable(*each) for each in sorted(since.items())])
