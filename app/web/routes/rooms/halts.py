"""What only who runs the server may do: halt one table or all, and let them go on."""

from typing import Annotated

import msgspec
from fastapi import APIRouter, Depends, Request, Response
from fastapi.security import HTTPBearer
from msgspec import Meta

from app.rooms.records import EVERY_ROOM
from app.web.routes.common import Server, body_of, documented, read, reply
from app.web.routes.rooms.operator import check_operator
from app.web.services import Services


class HaltRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Halt a table, or let it go on."""

    halted: Annotated[bool, Meta(description="False lets it go on.")]
    room: Annotated[str | None, Meta(description="Which; null, or nothing, is all of them.")] = None


class HaltedTable(msgspec.Struct, frozen=True):
    """A table that takes no drops."""

    room: str
    since: Annotated[float, Meta(description="Unix time, in s.")]


class HaltView(msgspec.Struct, frozen=True):
    """What takes no drops now."""

    all_since: Annotated[
        float | None, Meta(description="Since when all tables are halted, Unix time in s.")
    ]
    rooms: Annotated[list[HaltedTable], Meta(description="Those halted by themselves.")]


router = APIRouter(prefix="/api/v1", tags=["health"])

# Only documents the scheme: what is missing or wrong is said by `app.web.tokens`.
Token = Depends(
    HTTPBearer(
        scheme_name="operatorToken", description="`PLINKO_OPERATOR_TOKEN`.", auto_error=False
    )
)


@router.get("/halts", summary="Which tables are halted", responses=documented(HaltView))
async def get_halts(server: Server) -> Response:
    """The tables that take no drops now; balls in flight there land and are paid."""
    return reply(_view(server), headers={"cache-control": "no-store"})


@router.post(
    "/halts",
    summary="Halt tables or let them go on",
    responses=documented(HaltView, 400, 401, 403, 404, 413, 422, 503),
    openapi_extra=body_of(HaltRequest, {"room": "main", "halted": True}),
    dependencies=[Token],
)
async def change_halts(request: Request, server: Server) -> Response:
    """Halt a table, or all with `room` null: no new drops; what is in flight lands and is paid.

    It is kept in the ledger and outlives the server. To let all go on leaves a table halted that
    was halted by itself. For who runs the server alone.
    """
    check_operator(request, server, "tables are halted")
    body = await read(request, HaltRequest)
    room_id = EVERY_ROOM if body.room is None else (await server.rooms.seek(body.room)).id
    halts = server.rooms.halts
    await (halts.halt(room_id) if body.halted else halts.release(room_id))
    return reply(_view(server), headers={"cache-control": "no-store"})


def _view(server: Services) -> HaltView:
    since = server.rooms.halts.since
    everything = since.pop(EVERY_ROOM, None)
    return HaltView(everything, [HaltedTable(*each) for each in sorted(since.items())])
