"""Rooms over REST: list, open, look at, drop a ball into; change, reset, close; read the log."""

import bisect
import contextlib
import logging
import time
from collections.abc import Iterator
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Header, Query, Request, Response
from fastapi.responses import StreamingResponse
from starlette.types import Send

from app.computing import prices
from app.errors import (
    AppError,
    BusyError,
    InvalidValueError,
    LedgerError,
    NotFoundError,
    TokenError,
    UnknownRoomError,
)
from app.live.broadcast.audience import Player
from app.live.live_room import LiveRoom
from app.persistence.room_log import LogPart
from app.protocol.visitors import NO_TAG
from app.rooms.draw import MAX_SEEDS, Draw
from app.rooms.kinds import DRAW, SCENE
from app.rooms.outcome import Outcome
from app.rooms.pending import again_of
from app.rooms.room import Basis, Room
from app.rooms.touching.scene import Scene
from app.rooms.touching.story import Retold, Story, retell, story_of
from app.web.directory import listed
from app.web.drops import drop_command
from app.web.problems import HOPS
from app.web.routes.common import (
    Server,
    address_of,
    attended,
    body_of,
    charged,
    compute,
    documented,
    documented_failures,
    is_current,
    limit_drops,
    next_page,
    read,
    reply,
    resolve_board,
)
from app.web.routes.queries import Whole
from app.web.routes.rooms.sessions import RoomToken as Token
from app.web.routes.rooms.sessions import Token as SessionToken
from app.web.routes.rooms.sessions import own_session
from app.web.schemas.rooms import (
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
from app.web.services import Services
from engine import Board
from engine.parameters import Exact

router = APIRouter(prefix="/api/v1/rooms", tags=["rooms"])

_log = logging.getLogger("plinko")


class StreamedAnswer(StreamingResponse):
    """Pieces of a body; where the next cannot be had, the connection is closed in the middle.

    Its status has been told by then, so that only a body without an end says that something is
    missing. The log says what.
    """

    async def stream_response(self, send: Send) -> None:
        try:
            await super().stream_response(send)
        except AppError as error:
            _log.warning("answer cut short", extra={"why": str(error)})


WAIT_SECONDS = 30.0  # that `?wait=1` waits for a landing

Id = Annotated[str | None, Query(alias="id", description="The room of this id alone.")]
Mode = Annotated[
    Literal["independent", "interacting", "draw", "scene"] | None,
    Query(description="Rooms of one kind."),
]
After = Annotated[str, Query(description="The id after which the page begins.")]
Limit = Annotated[Whole, Query(ge=1, le=1000, description="How many rooms, at most.")]
First = Annotated[Whole, Query(ge=0, description="The number of the first drop told.")]
LogLimit = Annotated[Whole | None, Query(ge=1, description="How many drops, at most; else all.")]

Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=255,
        description="A text of your own, by which the same is asked for again and done once.",
    ),
]


@router.get("", summary="List the rooms", responses=documented(RoomList, 422))
async def list_rooms(
    request: Request,
    server: Server,
    only: Id = None,
    mode: Mode = None,
    after: After = "",
    limit: Limit = 1000,
) -> Response:
    """The open rooms, a page at a time: those of nobody, then players' own, each by their ids.

    `main` is always there; every preset's name is a room too, once asked for. `next` is the `after`
    of the following page, null on the last. With `id` the list has that room, or none if it is not
    open.
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
    responses=documented(
        RoomOpened, 400, 404, 413, 422, 429, 503, status=201, description="Opened"
    ),
    openapi_extra=body_of(RoomRequest, {"board": "triangle-12-high"}),
)
async def open_room(request: Request, server: Server, key: Key = None) -> Response:
    """Open a room with an id of its own; watch it at `/ws/rooms/{id}`.

    Over any board, `mode` says whether its balls touch each other; with a `draw` its bins have the
    odds that this says, and every seed of it is tried. Instead of a board a `scene` may be asked
    for: its name, or `{"scene": name, ...}` with its parameters (`GET scenes`). A `story` is a
    scene that was played elsewhere, as by the sandbox page without a server: the room goes on where
    it ends.

    The reply's `token` lets its holder change, reset and close the room.
    """
    address = address_of(request)
    creator = server.tokens.mark_of(address)
    again = None if key is None else again_of("open", creator, key)
    if again is not None and (found := await server.rooms.begun_by(again)) is not None:
        return _opened(server, found)
    held = await server.rooms.made_by(creator)
    with server.creators.place(address, server.rooms.free, held) as take:
        body = await read(request, RoomRequest)
        if body.story is None:
            basis, mode = await _basis(request, server, body)
            room = await server.rooms.create(basis, mode, creator, again)
        else:
            retold = await _retold(request, server, body)
            room = await server.rooms.create_retold(retold, creator, again)
        take(room.id)
    return _opened(server, room)


def _opened(server: Services, live: LiveRoom) -> Response:
    view = msgspec.structs.asdict(_view(server, live))
    opened = RoomOpened(**view, token=server.tokens.of(live.id))
    headers = {"location": f"/api/v1/rooms/{live.id}", "cache-control": "no-store"}
    return reply(opened, 201, headers)


@router.get("/{room}", summary="Look at a room", responses=documented(RoomView, 404, 429, 503))
async def get_room(room: str, server: Server) -> Response:
    """The room's clock, its balls in flight by their starts, and what came of the others."""
    return reply(_view(server, await server.rooms.seek(room)))


@router.get(
    "/{room}/draw",
    summary="Look at a room's draw",
    responses=documented(DrawView, 304, 404, 429, 503),
)
async def get_draw(room: str, request: Request, server: Server) -> Response:
    """The odds of its bins, and the seeds whose balls fall into each: all that its digest is of."""
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
    responses=documented(RoomView, 400, 401, 403, 404, 413, 422, 429, 503),
    openapi_extra=body_of(RoomChange, {"board": "triangle-8"}),
    dependencies=[Token],
)
async def change_room(room: str, request: Request, server: Server, key: Key = None) -> Response:
    """Give a room another board. It begins anew, for everyone in it; for its creator alone."""
    found = await own_room(room, request, server)
    body = await read(request, RoomChange)
    board = await _board_of_room(request, server, body.board)
    with _ending(request, server, found):
        await server.rooms.reset(found, board, _again(room, key))
    return reply(_view(server, found))


@router.post(
    "/{room}/reset",
    summary="Begin a room anew",
    responses=documented(RoomView, 401, 403, 404, 422, 429, 503),
    dependencies=[Token],
)
async def reset_room(room: str, request: Request, server: Server, key: Key = None) -> Response:
    """Take all balls out and count from zero; for its creator alone."""
    found = await own_room(room, request, server)
    with _ending(request, server, found):
        await server.rooms.reset(found, key=_again(room, key))
    return reply(_view(server, found))


@contextlib.contextmanager
def _ending(request: Request, server: Services, live: LiveRoom) -> Iterator[None]:
    """Charge the client's address where it was too long to compute how what falls here ends.

    Raises BudgetError before that for an address that has nothing left.
    """
    address = address_of(request)
    if live.room.awake:
        server.budgets.charge(address, time.monotonic(), 0.0, "what falls in the room")
    try:
        yield
    except BusyError:
        server.budgets.settle(address, time.monotonic(), prices.UNSETTLED)
        raise


def _again(room: str, key: str | None) -> str | None:
    return None if key is None else again_of("anew", room, key)


@router.delete(
    "/{room}",
    status_code=204,
    summary="Close a room",
    responses={204: {"description": "Closed"}, **documented_failures(401, 403, 404, 429, 503)},
    dependencies=[Token],
)
async def close_room(room: str, request: Request, server: Server) -> Response:
    """Close a room for good and send everyone away; for its creator alone."""
    found = await own_room(room, request, server)
    with _ending(request, server, found):
        await server.rooms.delete(found)
    return Response(status_code=204)


@router.get(
    "/{room}/log",
    summary="Read a room's log",
    responses=documented(RoomLog, 304, 401, 403, 404, 422, 429, 503),
    dependencies=[Token],
)
async def get_room_log(
    room: str, request: Request, server: Server, first: First = 0, limit: LogLimit = None
) -> Response:
    """All drops since the room began, at their ticks, with their results; of a closed room, too.

    `plinko verify` replays it and compares every digest. With `first` or `limit` it is a part:
    `next` is where the following one begins, and `digest`, which covers all, is null. Players'
    marks (`who`) are null but for who shows the room's token.
    """
    session, found = await _logged(server, room)
    shown = request.headers.get("authorization")
    if shown is not None:
        server.tokens.check(found.id, shown)
    part, marks = LogPart(first, limit), shown is not None
    etag = f"{session}.{found.world.tick}.{found.taken}.{first}.{limit}.{marks:d}"
    headers = {"etag": f'"{etag}"', "cache-control": "private, no-cache"}
    if is_current(request, etag):
        return Response(status_code=304, headers=headers)
    number = int(session.partition("-")[0])
    reading = server.logs.read(found, address_of(request), marks=marks, part=part, run=number)
    body = await attended(request, reading)
    if limit is not None and first + limit < found.taken:
        headers |= next_page(request, first=first + limit)
    return StreamedAnswer(body, media_type="application/json", headers=headers)


@router.post(
    "/{room}/drops",
    status_code=202,
    summary="Drop a ball into a room",
    responses={
        **documented(
            RoomDrop,
            400,
            401,
            403,
            404,
            409,
            413,
            422,
            429,
            503,
            status=202,
            description="In flight",
        ),
        **documented(RoomDrop, status=200, description="Landed, with `wait=1`"),
    },
    openapi_extra=body_of(RoomDropRequest, {"seed": "42"}, required=False),
    dependencies=[SessionToken],
)
async def drop_into_room(
    room: str,
    request: Request,
    server: Server,
    wait: Annotated[bool, Query(description="Reply only once the ball has landed.")] = False,
    key: Key = None,
) -> Response:
    """Put a ball in; everyone who watches sees it fall.

    A stake needs an open `session`, whose token is shown: nobody can choose such a drop's start.
    With a `seed` or `x` a drop is practice. A `name` and a `colour` are shown at the ball to all
    who watch; in a room that has an owner they need the room's token, or that of a session which
    was begun with it. A room with a draw takes drops of sessions only.
    With `wait=1` the reply comes with the landing, or as 202 without it should that take too long.
    Where the answer was `undecided`, or never came, ask again with the same `Idempotency-Key`: the
    ball is dropped once, and the reply is what came of it.
    """
    found = await server.rooms.seek(room)  # first: a drop counts where its room is
    limit_drops(request, server)
    body = await read(request, RoomDropRequest, empty=RoomDropRequest())
    command = drop_command(body, server.rooms.draw)
    shown = request.headers.get("authorization")
    owners = body.session is not None and server.session_tokens.is_owners(body.session, shown)
    if found.owned and command.tag != NO_TAG and not owners:
        server.tokens.check(found.id, shown)
    session = None if body.session is None else await own_session(body.session, request, server)
    if key is None:
        outcome = Outcome(await found.drop(command, session=session))
    else:
        player = Player(again=again_of("rest", key, *command.tag.marks))
        outcome = await found.drop_once(command, player, session)
    accepted, landed = outcome.accepted, outcome.landed if wait else None
    if wait and landed is None:
        landed = await found.landings.wait(accepted.ball, WAIT_SECONDS)
    drop = RoomDrop(
        found.id,
        accepted.ball,
        accepted.seed,
        accepted.x,
        accepted.tick,
        landed,
        practice=accepted.practice is True,
        receipt=accepted.receipt or None,
        name=accepted.name or None,
        colour=accepted.colour or None,
    )
    return reply(drop, 202 if landed is None else 200)


async def _basis(request: Request, server: Services, body: RoomRequest) -> tuple[Basis, str]:
    """What a room is asked for with, and its mode."""
    if (body.mode == DRAW) != (body.draw is not None):
        raise InvalidValueError("a `draw` and the mode `draw` need each other", field="draw")
    if body.draw is not None:
        return await _draw(request, server, body, body.draw), DRAW
    if body.scene is None:
        return await _board_of_room(request, server, body.board), body.mode
    if body.has("board"):
        raise InvalidValueError("a room has either a board or a scene", field="board")
    named = {"scene": body.scene} if isinstance(body.scene, str) else body.scene
    return server.rooms.scene(named), SCENE


async def _draw(request: Request, server: Services, body: RoomRequest, form: DrawForm) -> Draw:
    """A draw of which every seed was dropped by a worker, and landed in its bin."""
    if body.scene is not None:
        raise InvalidValueError("a draw is over a board, not a scene", field="scene")
    if not server.ledger.keeps:
        raise LedgerError("this server keeps no ledger, and so no sessions, which a draw needs")
    board = await _board_of_room(request, server, body.board)
    lists = form.seeds if isinstance(form.seeds, list) else []
    count = sum(len(listed) for listed in lists if isinstance(listed, list))
    price = prices.many_drops(board, min(count, MAX_SEEDS), Exact())
    return await compute(request, price, Draw.checked, board, form.weights, form.seeds)


async def _retold(request: Request, server: Services, body: RoomRequest) -> Retold:
    """What a story ends in, computed and charged as a worker's work."""
    assert body.story is not None
    for name in ("board", "scene", "draw"):
        if body.has(name):
            raise InvalidValueError(
                f"a story has its scene in itself, not beside: {name}", field=name
            )
    rate, most = server.settings.tick_rate, server.rooms.limits.touching
    story = story_of(body.story, tick_rate=rate, max_balls=most)
    price = prices.story(story.ball_substeps(rate))
    return await attended(
        request, charged(server, address_of(request), price, _retell, story, rate, most)
    )


def _retell(story: Story, tick_rate: int, max_balls: int) -> Retold:
    return retell(story, tick_rate=tick_rate, max_balls=max_balls)


async def _logged(server: Services, room_id: str) -> tuple[str, Room]:
    """A room whose log is asked for, open or closed, and its session: a number and its beginning.

    A ledger in memory counts from one again after a restart, hence the beginning.
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
    """The room, if the request bears its token; raises what stands in the way."""
    live = await server.rooms.seek(room_id)
    if not live.owned:
        raise TokenError(f"room {live.id!r} belongs to nobody and cannot be changed", field="room")
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
    """A board for a room, known from now on by its digest, by which all speak of its drops."""
    board = await resolve_board(request, form)
    server.boards.register(board)
    return board
