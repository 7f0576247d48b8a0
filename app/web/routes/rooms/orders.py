"""The operator's orders: halts and moves of rooms, bans of clients, an announcement."""

import hmac
from typing import Annotated

import msgspec
from fastapi import Depends, Request, Response
from fastapi.security import HTTPBearer
from msgspec import Meta

from plinko.app.errors import TokenError
from plinko.app.live.orders import ANNOUNCE, BAN, HALT, RELEASE, UNBAN
from plinko.app.rooms.records import EVERY_ROOM
from plinko.app.web.edge.addresses import one_client
from plinko.app.web.routes.common import Server, body_of, documented, read, reply
from plinko.app.web.routes.table import operations
from plinko.app.web.services import Services
from plinko.app.web.tokens import bearer_of, check_bearer
from plinko.engine.errors import MissingPartError

# This only documents the scheme for OpenAPI; `plinko.app.web.tokens` checks the token.
Token = Depends(
    HTTPBearer(
        scheme_name="operatorToken", description="`PLINKO_OPERATOR_TOKEN`.", auto_error=False
    )
)


def check_operator(request: Request, server: Services, what: str) -> None:
    """Raise NoTokenError or TokenError unless the request has the operator's token.

    `what` names the operation for the message: 'halting a room'.
    """
    token = server.settings.operator_token
    if not token:
        raise TokenError(
            f"{what} needs the operator's token, but this server was started without one: "
            "set PLINKO_OPERATOR_TOKEN",
            field="authorization",
        )
    check_bearer(request.headers.get("authorization"), token, "of the operator")


def is_operator(request: Request, server: Services) -> bool:
    token = server.settings.operator_token
    shown = bearer_of(request.headers.get("authorization"))
    return bool(token and shown) and hmac.compare_digest(str(shown).encode(), token.encode())


class HaltRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Halt a room, or resume it."""

    halted: Annotated[bool, Meta(description="True halts the room, false resumes it.")]
    room: Annotated[str | None, Meta(description="The room's id; null: all rooms.")] = None


class Announcement(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What all players read."""

    text: Annotated[
        Annotated[str, Meta(min_length=1, max_length=500)] | None,
        Meta(description="Null ends the announcement."),
    ]


class Ban(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A client, and for how long it is banned."""

    client: Annotated[
        str, Meta(min_length=1, max_length=64, description="An address, or the `who` of drops.")
    ]
    minutes: Annotated[int, Meta(ge=0, le=525_600, description="0 ends the ban.")]


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


class MoveRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The server that a room is to move to."""

    to: Annotated[str, Meta(description="The server's `--name`.")]


class MoveView(msgspec.Struct, frozen=True):
    """A room and the server that now has it."""

    room: str
    server: str


router = operations("health")


@router.get("/halts", summary="List the halted rooms", responses=documented(HaltView))
async def get_halts(server: Server) -> Response:
    """The rooms that refuse drops now. Balls in flight there still land and are paid."""
    return reply(_view(server), headers={"cache-control": "no-store"})


@router.post(
    "/halts",
    summary="Halt or resume rooms",
    responses=documented(HaltView),
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
    await server.rooms.orders.give(HALT if body.halted else RELEASE, room_id)
    return reply(_view(server), headers={"cache-control": "no-store"})


@router.post(
    "/announcement",
    summary="Announce something to all players",
    responses=documented(Announcement),
    openapi_extra=body_of(Announcement, {"text": "Maintenance at 18:00"}),
    dependencies=[Token],
)
async def announce(request: Request, server: Server) -> Response:
    """Show a text on the pages of all players, until it is replaced or ended. For the operator."""
    check_operator(request, server, "announcing")
    body = await read(request, Announcement)
    await server.rooms.orders.give(ANNOUNCE, text=body.text)
    return reply(body, headers={"cache-control": "no-store"})


@router.post(
    "/bans",
    summary="Ban a client for a time",
    responses=documented(Ban),
    openapi_extra=body_of(Ban, {"client": "192.0.2.1", "minutes": 60}),
    dependencies=[Token],
)
async def ban(request: Request, server: Server) -> Response:
    """Refuse an address all requests, or a `who` all drops, for a time. Only for the operator.

    Everybody behind one address is banned with it, and a `who` is chosen by its player.
    """
    check_operator(request, server, "banning a client")
    body = await read(request, Ban)
    whom = one_client(body.client)
    orders = server.rooms.orders
    if body.minutes:
        await orders.give(BAN, whom, until=server.rooms.persistence.now() + 60.0 * body.minutes)
    else:
        await orders.give(UNBAN, whom)
    return reply(body, headers={"cache-control": "no-store"})


def _view(server: Services) -> HaltView:
    since = server.rooms.orders.since
    everything = since.pop(EVERY_ROOM, None)
    return HaltView(everything, [HaltedTable(*each) for each in sorted(since.items())])


@router.post(
    "/rooms/{room}/move",
    summary="Move a room to another server",
    responses=documented(MoveView, 501),
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
        raise MissingPartError(
            "this server is not in a cluster: only servers with a `--name` can move rooms"
        )
    found = await server.rooms.seek(room)
    name = await server.others.move(found.id, body.to)
    await server.rooms.orders.give("move", found.id, body.to)
    return reply(MoveView(found.id, name), headers={"cache-control": "no-store"})
