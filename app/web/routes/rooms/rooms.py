"""Rooms over REST: list, open, view, drop a ball, change, reset, close, read the log."""

import asyncio
import bisect
import functools
import logging
from typing import Annotated, Literal

import msgspec
from fastapi import Query, Request, Response
from fastapi.responses import StreamingResponse
from msgspec import UNSET
from starlette.types import Send

from plinko.app.computing import prices
from plinko.app.errors import (
    AppError,
    InvalidValueError,
    NotFoundError,
    TokenError,
    UnknownRoomError,
)
from plinko.app.live.broadcast.audience import Player
from plinko.app.live.live_room import LiveRoom
from plinko.app.persistence.room_log import LogPart
from plinko.app.protocol.visitors import NO_TAG
from plinko.app.rooms.draw import MAX_SEEDS, Draw
from plinko.app.rooms.keys import KeyUse
from plinko.app.rooms.kinds import DRAW, SCENE
from plinko.app.rooms.room import Basis, Room
from plinko.app.rooms.touching.scene import Scene
from plinko.app.rooms.touching.story import Retold, retell, story_of
from plinko.app.settings import TICK_RATE
from plinko.app.web.directory import listed
from plinko.app.web.drops import drop_command
from plinko.app.web.problems import HOPS
from plinko.app.web.routes.common import (
    OPTIONAL_TOKEN,
    Server,
    address_of,
    attended,
    body_of,
    compute,
    documented,
    is_current,
    limit_drops,
    next_page,
    read,
    reply,
    resolve_board,
)
from plinko.app.web.routes.queries import Whole
from plinko.app.web.routes.rooms.orders import is_operator
from plinko.app.web.routes.rooms.repeats import OWNER, Repeats, session_caller
from plinko.app.web.routes.rooms.sessions import RoomToken as Token
from plinko.app.web.routes.rooms.sessions import Token as SessionToken
from plinko.app.web.routes.rooms.sessions import own_session
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.rooms import (
    DrawForm,
    DrawView,
    RoomChange,
    RoomDrop,
    RoomDropRequest,
    RoomList,
    RoomLog,
    RoomOpened,
    RoomRequest,
    RoomView,
)
from plinko.app.web.services import Services
from plinko.engine import Board
from plinko.engine.parameters import Exact

router = operations("rooms", "/api/v1/rooms")

_log = logging.getLogger("plinko")


class StreamedAnswer(StreamingResponse):
    """A streamed body that closes the connection if a later piece cannot be computed.

    The status has been sent by then, so an incomplete body is the only way to report the failure.
    The log has the reason.
    """

    async def stream_response(self, send: Send) -> None:
        try:
            await super().stream_response(send)
        except AppError as error:
            _log.warning("answer cut short", extra={"why": str(error)})


WAIT_SECONDS = 30.0  # `?wait=1` waits at most this long for a landing

Id = Annotated[str | None, Query(alias="id", description="List only the room with this id.")]
Mode = Annotated[
    Literal["independent", "interacting", "draw", "scene"] | None,
    Query(description="List only rooms of this kind."),
]
After = Annotated[str, Query(description="The id after which the page begins.")]
Limit = Annotated[Whole, Query(ge=1, le=1000, description="At most this many rooms.")]
First = Annotated[Whole, Query(ge=0, description="The number of the first drop to return.")]
LogLimit = Annotated[
    Whole | None, Query(ge=1, description="At most this many drops; default: all.")
]


@router.get("", summary="List the rooms", responses=documented(RoomList))
async def list_rooms(
    request: Request,
    server: Server,
    only: Id = None,
    mode: Mode = None,
    after: After = "",
    limit: Limit = 1000,
) -> Response:
    """The open rooms, in pages: public rooms first, then players' rooms, each sorted by id.

    `main` is always open; every preset's name is a room too, which opens at the first request for
    it. With `id` the list has only that room, or is empty if it is not open.
    """
    found = await listed(server, here=request.headers.get(HOPS) is not None, only=only)
    public = server.rooms.public
    order = sorted(
        (name not in public, name) for name, room in found.items() if mode in (None, room.mode)
    )
    begin = bisect.bisect_right(order, (after not in public, after)) if after else 0
    names = [name for _, name in order[begin : begin + limit]]
    page = [found[name] for name in names]
    following = names[-1] if begin + limit < len(order) else None
    headers = {} if following is None else next_page(request, after=following)
    return reply(RoomList(page, following), headers=headers)


@router.post(
    "",
    status_code=201,
    summary="Open a room",
    responses=documented(RoomOpened, status=201, description="Opened"),
    openapi_extra=body_of(RoomRequest, {"board": "triangle-12-high"}),
)
async def open_room(request: Request, server: Server, repeats: Repeats) -> Response:
    """Open a room with a new id. Watch it at `/ws/rooms/{id}`.

    A room has one of these:

    - a `board`; `mode` says whether its balls touch each other. With the mode `draw`, `draw` gives
      the odds of the bins, and the server checks every seed in it.
    - a `scene`: its name, or `{"scene": name, ...}` with its parameters (`GET scenes`).
    - a `story`: a scene that was played elsewhere, for example on the sandbox page without a
      server. The room continues where it ends.

    With the response's `token` a client may change, reset and close the room. A request repeated
    with the same `Idempotency-Key` gets the same room. It gets the token again only if both
    requests have the same `Idempotency-Secret`; else `token` is null.
    """
    creator = server.tokens.mark_of(address_of(request))
    body = await read(request, RoomRequest)
    use = await asyncio.to_thread(repeats.use, "open", "", body)
    live = await server.rooms.opened_by(use)
    if live is None:
        live = await _open(request, server, body, creator, use)
    token = server.tokens.of(live.id) if use.is_new or repeats.caller.proven else None
    opened = RoomOpened(**msgspec.structs.asdict(_view(server, live)), token=token)
    headers = {"location": f"/api/v1/rooms/{live.id}", "cache-control": "no-store"}
    return reply(opened, 201, headers)


async def _open(
    request: Request, server: Services, body: RoomRequest, creator: str, use: KeyUse
) -> LiveRoom:
    rooms, stored = server.rooms, server.rooms.stored
    has, left = await stored.made_by(creator), await stored.free()
    with server.creators.place(address_of(request), has=has, left=left):
        if body.story is None:
            basis, mode = await _basis(request, server, body)
            return await rooms.create(basis, mode, creator, use)
        retold = await _retold(request, server, body)
        return await rooms.create(retold.scene, SCENE, creator, use, retold)


@router.get("/{room}", summary="Get a room", responses=documented(RoomView))
async def get_room(room: str, server: Server) -> Response:
    """The room's tick, the starts of its balls in flight, and statistics of the landed ones."""
    return reply(_view(server, await server.rooms.seek(room)))


@router.get("/{room}/draw", summary="Get a room's draw", responses=documented(DrawView, 304))
async def get_draw(room: str, request: Request, server: Server) -> Response:
    """The odds of its bins, and the seeds whose balls land in each: the content of its digest."""
    draw = (await server.rooms.seek(room)).room.draw
    if draw is None:
        raise NotFoundError(f"room {room!r} has no draw", field="room")
    headers = {"etag": f'"{draw.digest}"', "cache-control": "no-cache"}
    if is_current(request, draw.digest):
        return Response(status_code=304, headers=headers)
    return reply(draw.to_json(), headers=headers)


@router.patch(
    "/{room}",
    summary="Change a room",
    responses=documented(RoomView),
    openapi_extra=body_of(RoomChange, {"board": "triangle-8"}),
    dependencies=[Token],
)
async def change_room(room: str, request: Request, server: Server, repeats: Repeats) -> Response:
    """Give a room another board. This resets it for everyone in it. Only for its owner."""
    found = await own_room(room, request, server)
    body = await read(request, RoomChange)
    board = await _board_of_room(request, server, body.board)
    await server.rooms.reset(found, board, repeats.use("change", found.id, body, OWNER))
    return reply(_view(server, found))


@router.post(
    "/{room}/reset",
    summary="Reset a room",
    responses=documented(RoomView),
    dependencies=[Token],
)
async def reset_room(room: str, request: Request, server: Server, repeats: Repeats) -> Response:
    """Remove all balls and count from zero. Only for the room's owner."""
    found = await own_room(room, request, server)
    await server.rooms.reset(found, use=repeats.use("reset", found.id, None, OWNER))
    return reply(_view(server, found))


@router.delete(
    "/{room}",
    status_code=204,
    summary="Close a room",
    responses={204: {"description": "Closed"}},
    dependencies=[Token],
)
async def close_room(room: str, request: Request, server: Server) -> Response:
    """Close a room for good and disconnect everyone in it. For its owner and the operator."""
    if is_operator(request, server) and (live := await server.rooms.seek(room)).owned:
        await server.rooms.orders.give("close", live.id)
        await server.rooms.delete(live, "the operator")
    else:
        await server.rooms.delete(await own_room(room, request, server))
    return Response(status_code=204)


@router.get(
    "/{room}/log",
    summary="Read a room's log",
    responses=documented(RoomLog, 304),
    openapi_extra=OPTIONAL_TOKEN,
    dependencies=[Token],
)
async def get_room_log(
    room: str, request: Request, server: Server, first: First = 0, limit: LogLimit = None
) -> Response:
    """All drops since the room was opened or reset, with their ticks and results.

    A closed room still has its log. `plinko verify` replays it and compares every digest. With
    `first` or `limit` the response is part of the log: `next` is where the next part begins, and
    `digest`, which covers the whole log, is null. `who` is null unless the request has the room's
    token.
    """
    session, found = await _logged(server, room)
    shown = request.headers.get("authorization")
    if shown is not None:
        server.tokens.check(found.id, shown)
    part, marks = LogPart(first, limit), shown is not None
    etag = f"{session}.{found.log_tick}.{found.input_count}.{first}.{limit}.{marks:d}"
    headers = {"etag": f'"{etag}"', "cache-control": "private, no-cache"}
    if is_current(request, etag):
        return Response(status_code=304, headers=headers)
    number = int(session.partition("-")[0])
    reading = server.logs.read(found, address_of(request), marks=marks, part=part, run=number)
    body = await attended(request, reading)
    if limit is not None and first + limit < found.input_count:
        headers |= next_page(request, first=first + limit)
    return StreamedAnswer(body, media_type="application/json", headers=headers)


@router.post(
    "/{room}/drops",
    status_code=202,
    summary="Drop a ball into a room",
    responses={
        **documented(RoomDrop, 409, status=202, description="In flight"),
        **documented(RoomDrop, status=200, description="Landed, with `wait=1`"),
    },
    openapi_extra=OPTIONAL_TOKEN | body_of(RoomDropRequest, {"seed": "42"}, required=False),
    dependencies=[SessionToken, Token],
)
async def drop_into_room(
    room: str,
    request: Request,
    server: Server,
    repeats: Repeats,
    wait: Annotated[bool, Query(description="Respond only after the ball has landed.")] = False,
) -> Response:
    """Drop a ball; everyone in the room sees it fall.

    A stake needs an open `session` and its token: nobody can choose such a drop's start. A drop
    with a `seed` or `x` is practice. `name` and `colour` are shown at the ball; in a room with an
    owner they need the room's token, or the token of a session that was begun with it. A room with
    a draw accepts only drops of sessions.

    With `wait=1` the response comes after the landing and has the result; if that takes too long,
    the response is 202 without it. If the response was `undecided`, or never came, send the request
    again with the same `Idempotency-Key`: the ball is dropped only once, and the response has its
    outcome. The key belongs to the session, or else to the `Idempotency-Secret` or the client's
    address; with another body it is refused.
    """
    found = await server.rooms.seek(room)  # first: the server that has the room counts the drop
    limit_drops(request, server)
    body = await read(request, RoomDropRequest, empty=RoomDropRequest())
    command = drop_command(body, server.rooms.draw)
    shown = request.headers.get("authorization")
    owners = body.session is not None and server.session_tokens.is_owners(body.session, shown)
    if found.owned and command.tag != NO_TAG and not owners:
        server.tokens.check(found.id, shown)
    session = None if body.session is None else await own_session(body.session, request, server)
    caller = None if body.session is None else session_caller(body.session)
    use = repeats.use("drop", found.id, body, caller)
    outcome = await found.drop(command, Player(idempotency_key=use.key), session)
    accepted, landed = outcome.accepted, outcome.landed if wait else None
    if wait and landed is None:
        landed = await found.landings.wait(accepted.ball, WAIT_SECONDS)
    fields = msgspec.structs.asdict(accepted) | {"room": found.id, "landed": landed}
    given = {name: fields[name] for name in RoomDrop.__struct_fields__ if fields[name] is not UNSET}
    return reply(RoomDrop(**given), 202 if landed is None else 200)


async def _basis(request: Request, server: Services, body: RoomRequest) -> tuple[Basis, str]:
    """The basis of a requested room (its board, draw or scene), and its mode."""
    if (body.mode == DRAW) != (body.draw is not None):
        raise InvalidValueError(
            "give a `draw` and the mode `draw` together, or neither", field="draw"
        )
    if body.draw is not None:
        return await _draw(request, server, body, body.draw), DRAW
    if body.scene is None:
        return await _board_of_room(request, server, body.board), body.mode
    if body.has("board"):
        raise InvalidValueError("a room has either a board or a scene, not both", field="board")
    named = {"scene": body.scene} if isinstance(body.scene, str) else body.scene
    return server.rooms.scene(named), SCENE


async def _draw(request: Request, server: Services, body: RoomRequest, form: DrawForm) -> Draw:
    """The draw of a requested room, after a worker has checked the bin of every seed."""
    if body.scene is not None:
        raise InvalidValueError("a draw needs a board, not a scene", field="scene")
    board = await _board_of_room(request, server, body.board)
    lists = form.seeds if isinstance(form.seeds, list) else []
    count = sum(len(listed) for listed in lists if isinstance(listed, list))
    price = prices.many_drops(board, min(count, MAX_SEEDS), Exact())
    return await compute(request, price, Draw.checked, board, form.weights, form.seeds)


async def _retold(request: Request, server: Services, body: RoomRequest) -> Retold:
    """The state at the end of a story, computed by a worker and charged to the client."""
    assert body.story is not None
    for name in ("board", "scene", "draw"):
        if body.has(name):
            raise InvalidValueError(
                f"a story contains its own scene; leave out `{name}`", field=name
            )
    rate, most = TICK_RATE, server.rooms.persistence.limits.touching
    story = story_of(body.story, tick_rate=rate, max_balls=most)
    price = prices.story(story.ball_substeps(rate))
    replay = functools.partial(retell, story, tick_rate=rate, max_balls=most)
    return await compute(request, price, replay)


async def _logged(server: Services, room_id: str) -> tuple[str, Room]:
    """A room, open or closed, and a text that names its run: a number and a time.

    The number alone would not do: without a database, runs are counted from one again after a
    restart.
    """
    persistence = server.rooms.persistence
    try:
        live = await server.rooms.seek(room_id)
    except UnknownRoomError:
        closed = await persistence.recovery.closed(room_id)
        if closed is None:
            raise
        return f"{closed[0]}-closed", closed[1]
    record = persistence.runs.of(live.room)
    return f"{record.number}-{record.opened:.6f}", live.room


async def own_room(room_id: str, request: Request, server: Services) -> LiveRoom:
    """The room, if the request has its token; raises UnknownRoomError, TokenError, NoTokenError."""
    live = await server.rooms.seek(room_id)
    if not live.owned:
        raise TokenError(f"room {live.id!r} has no owner and cannot be changed", field="room")
    server.tokens.check(live.id, request.headers.get("authorization"))
    return live


def _view(server: Services, live: LiveRoom) -> RoomView:
    room = live.room
    return RoomView(
        id=room.id,
        board_name=room.origin.name,
        board_digest=room.origin.digest,
        mode=room.mode,
        solver=room.solver,
        tick=room.world.tick,
        tick_rate=room.tick_rate,
        awake=room.awake,
        clients=server.hub.count(room.id),
        owned=live.owned,
        extent=room.extent,
        balls=room.balls,
        stats=room.stats(),
        scene=room.origin.to_dict() if isinstance(room.origin, Scene) else None,
        draw=None if room.draw is None else room.draw.odds,
    )


async def _board_of_room(request: Request, server: Services, form: msgspec.Raw) -> Board:
    """The board for a room, registered so that clients can use its digest."""
    board = await resolve_board(request, form)
    server.boards.register(board)
    return board
