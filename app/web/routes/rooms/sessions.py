"""Fair sessions over REST: begin, open, end, export; and the log of their receipts."""

from typing import Annotated

import msgspec
from fastapi import Depends, Query, Request, Response
from fastapi.security import HTTPBearer
from msgspec import Meta

from plinko.app.fairness.export import KeyChange, SessionExport, Signed
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.web.routes.common import (
    OPTIONAL_TOKEN,
    Server,
    body_of,
    documented,
    limit_drops,
    read,
    reply,
)
from plinko.app.web.routes.queries import Whole
from plinko.app.web.routes.rooms.repeats import Repeats
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.fields import Digest
from plinko.app.web.services import Services
from plinko.engine.json_text import Json, JsonObject

_HEX = {"type": "string", "pattern": "^[0-9a-fA-F]{64}$"}

Key = Annotated[str, Meta(description="The server's public key (Ed25519), 64 hexadecimal digits.")]
Signature = Annotated[
    str,
    Meta(
        description="Ed25519 over the statement as canonical JSON (RFC 8785), 128 hexadecimal "
        "digits."
    ),
]


class SessionRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Begin a session in a room."""

    commitment: Annotated[
        Json,
        Meta(
            description="SHA-256 of your secret of 32 bytes, as 64 hexadecimal digits.",
            extra_json_schema=_HEX,
        ),
    ]
    room: Annotated[str, Meta(description="The room for its drops.")] = "main"


class SessionOpening(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Reveal the secret of the commitment."""

    seed: Annotated[
        Json, Meta(description="Your secret, 64 hexadecimal digits.", extra_json_schema=_HEX)
    ]


class SessionView(msgspec.Struct, frozen=True, kw_only=True):
    """The state of a session."""

    session: str
    room: str
    statement: Annotated[JsonObject, Meta(description="The server's commitment at the beginning.")]
    signature: Signature
    key: Key
    open: Annotated[bool, Meta(description="Whether the player has revealed the secret.")]
    drops: Annotated[
        int, Meta(description="The number of drops until now, which is the next drop's number.")
    ]
    ended: bool
    void: Annotated[
        bool,
        Meta(description="Whether the restore of a backup ended it: drops that it lacks are void."),
    ] = False


class SessionBegun(SessionView, frozen=True, kw_only=True):
    """A new session with its player's token."""

    token: Annotated[
        str | None,
        Meta(
            description="Send it as `Authorization: Bearer TOKEN` to drop and to end. Null for a "
            "repeated request without the `Idempotency-Secret` of the first one."
        ),
    ]


class SessionEnd(msgspec.Struct, frozen=True):
    """The end of a session, with the server's secret."""

    session: str
    server_seed: Digest
    statement: JsonObject
    signature: Signature


class LogHead(msgspec.Struct, frozen=True):
    """The signed head of the log of all receipts, and a proof that the log has only grown."""

    key: Key
    head: Signed
    consistency: Annotated[
        list[str], Meta(description="The proof (RFC 6962) from the size `since`; empty for 0.")
    ]
    restores: Annotated[
        list[Signed],
        Meta(
            description="A signed statement for each restore of a backup, which began a new log; "
            "the latest began this one."
        ),
    ] = []
    keys: Annotated[
        list[KeyChange],
        Meta(description="The changes of the server's key, signed by both keys, latest first."),
    ] = []


router = operations("sessions")

Since = Annotated[Whole, Query(ge=0, description="An earlier size of the log.")]

_EXAMPLE = "9f64a747e1b97f131fabb6b447296c9b6f0201e79fb3c5356e6c77e89b6a806a"

# These only document the schemes for OpenAPI; `plinko.app.web.tokens` checks the tokens.
Token = Depends(
    HTTPBearer(
        scheme_name="sessionToken", description="The token from `POST sessions`.", auto_error=False
    )
)

RoomToken = Depends(
    HTTPBearer(
        scheme_name="roomToken", description="The token from `POST rooms`.", auto_error=False
    )
)


@router.post(
    "/sessions",
    status_code=201,
    summary="Begin a session",
    responses=documented(SessionBegun, 403, status=201, description="Begun"),
    openapi_extra=OPTIONAL_TOKEN
    | body_of(SessionRequest, {"room": "main", "commitment": _EXAMPLE}),
    dependencies=[RoomToken],
)
async def begin_session(request: Request, server: Server, repeats: Repeats) -> Response:
    """Commit to your secret; the server commits to its own secret and signs that.

    After that, neither side can choose its secret by knowing the other's. If the request has the
    token of the room, the session's drops may have names. A request repeated with the same
    `Idempotency-Key` gets the same session. It gets the token again only if both requests have the
    same `Idempotency-Secret`; else `token` is null.
    """
    limit_drops(request, server)
    body = await read(request, SessionRequest)
    live = await server.rooms.seek(body.room)
    shown = request.headers.get("authorization")
    if shown is not None and live.owned:
        server.tokens.check(live.id, shown)
    use = repeats.use("session", live.id, body)
    session = await server.fair.begin(live.room, body.commitment, use)
    token = None
    if use.is_new or repeats.caller.proven:
        tokens, owners = server.session_tokens, shown is not None and live.owned
        token = tokens.of_owner(session.id) if owners else tokens.of(session.id)
    headers = {"location": f"/api/v1/sessions/{session.id}", "cache-control": "no-store"}
    return reply(SessionBegun(**_fields(session), token=token), 201, headers)


@router.get("/sessions/{session}", summary="Get a session", responses=documented(SessionView))
async def get_session(session: str, server: Server) -> Response:
    """The server's commitment, and the number of drops until now."""
    return reply(SessionView(**_fields(await server.fair.find(session))))


@router.post(
    "/sessions/{session}/opening",
    summary="Open a session",
    responses=documented(SessionView, 409),
    openapi_extra=body_of(SessionOpening, {"seed": "00" * 32}),
    dependencies=[Token],
)
async def open_session(session: str, request: Request, server: Server) -> Response:
    """Reveal your secret to the server. After that, drops can begin."""
    found = await own_session(session, request, server)
    body = await read(request, SessionOpening)
    await server.fair.open(found, body.seed)
    return reply(SessionView(**_fields(found)))


@router.post(
    "/sessions/{session}/end",
    summary="End a session",
    responses=documented(SessionEnd, 409),
    dependencies=[Token],
)
async def end_session(session: str, request: Request, server: Server) -> Response:
    """End a session: the server reveals its secret. Drops in flight still land and are paid.

    Ending a session again returns the same response.
    """
    found = await own_session(session, request, server)
    await server.fair.end(found)
    ended = found.ended()
    return reply(SessionEnd(ended.session, ended.server_seed, ended.statement, ended.signature))


@router.get(
    "/sessions/{session}/export",
    summary="Export a session",
    responses=documented(SessionExport),
    dependencies=[Token],
)
async def export_session(session: str, request: Request, server: Server) -> Response:
    """Everything needed to check a session offline, with `plinko verify` or `verify.html`.

    Only for its player, with the session's token. The server's secret is null until the session has
    ended.
    """
    export = await server.fair.export(await own_session(session, request, server))
    return reply(export, headers={"cache-control": "private, no-cache"})


@router.get("/log", summary="Get the log's head", responses=documented(LogHead))
async def get_log(server: Server, since: Since = 0) -> Response:
    """The signed head of the log of all receipts, and a proof that it has only grown `since`."""
    head, consistency = await server.fair.head(since)
    fair = server.fair
    found = LogHead(fair.signer.public.hex(), head, consistency, fair.restores, fair.key_changes)
    return reply(found, headers={"cache-control": "no-cache"})


async def own_session(session: str, request: Request, server: Services) -> FairSession:
    """The session, if the request has its token; raises TokenError, UnknownSessionError."""
    server.session_tokens.check(session, request.headers.get("authorization"))
    return await server.fair.find(session)


def _fields(session: FairSession) -> JsonObject:
    state = msgspec.to_builtins(session.state())
    return {name: state[name] for name in SessionView.__struct_fields__}
