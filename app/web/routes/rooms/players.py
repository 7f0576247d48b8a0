"""The history of a player or a room: past drops from the ledger, with links to their paths."""

import csv
import io
import re
import urllib.parse
from typing import Annotated, Any, Final, Literal

import msgspec
from fastapi import Query, Request, Response
from msgspec import Meta
from sqlalchemy import Row

from plinko.app.computing import tasks
from plinko.app.errors import InvalidValueError, UnknownBoardError
from plinko.app.persistence.statements import plays as ledger
from plinko.app.persistence.statements import store
from plinko.app.rooms.records import Erase
from plinko.app.rooms.stakes import parse_who
from plinko.app.web.edge.accepted import asks_for, whole
from plinko.app.web.routes.common import (
    Server,
    documented,
    limit_drops,
    next_page,
    parse_board,
    reply,
)
from plinko.app.web.routes.queries import Whole
from plinko.app.web.routes.rooms.orders import Token, check_operator
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.fields import Digest, PhysicsVersion, Seed
from plinko.app.web.services import Services
from plinko.engine import Board
from plinko.engine.errors import shorten


class PlayView(msgspec.Struct, frozen=True):
    """A past drop. Lengths in m, times in s, stake and payout in minor units."""

    play: Annotated[
        str, Meta(description="Its place in the history; as `before` it begins the next page.")
    ]
    room: str
    board: str
    board_digest: Digest
    physics_version: PhysicsVersion
    seed: Seed
    x: Annotated[float | None, Meta(description="The start, if the player chose it.")]
    aim: Annotated[
        float | None, Meta(description="Middle of the starts that seeds draw, if chosen.")
    ]
    stake: int
    practice: bool
    name: Annotated[str | None, Meta(description="The name that was shown at the ball.")]
    colour: Annotated[str | None, Meta(description="Of the ball, #rrggbb.")]
    session: Annotated[str | None, Meta(description="The id of its fair session.")]
    session_drop: Annotated[int | None, Meta(description="Its number in that session.")]
    time: Annotated[int | None, Meta(description="Of its receipt: Unix time, in ms.")]
    digest: Annotated[str | None, Meta(description="Of its whole path; null while the ball falls.")]
    bin: int | None
    label: Annotated[str | None, Meta(description="The prize: the text of its bin's label.")]
    score: Annotated[float | None, Meta(description="The multiplier.")]
    payout: int | None
    duration: float | None
    x_end: float | None
    unsettled: str | None
    path: Annotated[str, Meta(description="The URL of its record with every impact.")]


class PlayList(msgspec.Struct, frozen=True):
    """A page of past drops, the latest first."""

    plays: list[PlayView]
    next: Annotated[
        str | None, Meta(description="Send it as `before` for the next page; null on the last.")
    ]


class Erased(msgspec.Struct, frozen=True):
    """What was erased."""

    rows: Annotated[int, Meta(description="Number of drops and inputs that had the mark.")]


router = operations("rooms")

CSV = "text/csv"
DAY: Final = 24 * 3600  # s
BEST: Final = 5  # plays in the list of a day's best

Limit = Annotated[Whole, Query(ge=1, le=100, description="At most this many drops.")]
RoomLimit = Annotated[Whole, Query(ge=1, le=1000, description="At most this many drops.")]
Before = Annotated[
    str | None,
    Query(description="Only drops before this one, a page's `next`; default: from the latest."),
]
Format = Annotated[
    Literal["json", "csv"] | None, Query(description="Default: as the Accept header says.")
]

_READ_AS_OTHER: Final = re.compile(r"[=+@\t\r-].*|[0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?", re.S)
"""Texts that a spreadsheet takes for a formula or a number: it would round a seed of 20 digits."""
_PLACE = re.compile(r"(\d{1,15})\.(\d{1,15})", re.ASCII)


_ANSWERS = documented(PlayList)
_ANSWERS[200]["content"][CSV] = {"schema": {"type": "string"}}


@router.get("/players/{key}/plays", summary="Recall a player's plays", responses=_ANSWERS)
async def list_plays(
    key: str,
    request: Request,
    server: Server,
    before: Before = None,
    limit: Limit = 20,
    format: Format = None,  # noqa: A002 - the parameter's name
) -> Response:
    """The drops with `key` as their `who`, the latest first, each with its path's address.

    Anybody can list the drops of a `who` that they know, so choose one that is hard to guess. Rooms
    of touching balls are left out, because a ball there has no path that could be computed alone.
    The list is CSV with `format=csv` or `Accept: text/csv`. `Link` names the next page.
    """
    limit_drops(request, server)
    return await _page(request, server, str(parse_who(key)), before, limit, format)


@router.delete(
    "/players/{key}",
    summary="Erase a player",
    responses=documented(Erased),
    dependencies=[Token],
)
async def erase_player(key: str, request: Request, server: Server) -> Response:
    """Take `key`, names and colours from all drops that have `key` as their `who`.

    Only for the operator. Drops, results, sums and receipts stay: they say nothing of the player.
    The digest of a room's log that was sent with players' marks changes.
    """
    check_operator(request, server, "erasing a player")
    step, rows = Erase(str(parse_who(key))), 0
    while True:
        await server.ledger.commit(step)
        rows += step.rows
        if not step.rows:
            await server.rooms.orders.give("erase", text=f"{rows} rows")
            return reply(Erased(rows), headers={"cache-control": "no-store"})


@router.get("/rooms/{room}/plays", summary="Recall a room's plays", responses=_ANSWERS)
async def list_room_plays(
    room: str,
    request: Request,
    server: Server,
    before: Before = None,
    limit: RoomLimit = 20,
    format: Format = None,  # noqa: A002 - the parameter's name
) -> Response:
    """The drops of a room since it was opened or reset, the latest first.

    With `format=csv` a spreadsheet can open them: the results of a lesson, for example.
    """
    found = await server.rooms.seek(room)  # first: the server that has the room counts the request
    limit_drops(request, server)
    run = server.rooms.persistence.runs.of(found.room).number
    return await _page(request, server, run, before, limit, format)


@router.get(
    "/rooms/{room}/best",
    summary="Recall a room's best plays of a day",
    responses=documented(PlayList),
)
async def list_best_plays(room: str, request: Request, server: Server) -> Response:
    """The staked drops that paid most in the last 24 hours, at most five, the best first.

    Only those with a multiplier of at least 10, since the room was opened or reset.
    """
    found = await server.rooms.seek(room)
    limit_drops(request, server)
    runs = server.rooms.persistence.runs
    run = runs.of(found.room)
    runs.report([])  # write the latest landings first
    since = run.clock.tick - DAY * found.room.tick_rate
    read = ledger.best_plays
    best = await server.ledger.read(read, run=run.number, since=since, limit=BEST)
    boards = await _boards_of(request, server, {play.board_digest for play in best})
    views = [_view(play, boards[play.board_digest]) for play in best]
    return reply(PlayList(views, None), headers={"cache-control": "no-store"})


async def _page(
    request: Request,
    server: Services,
    of: str | int,
    before: str | None,
    limit: int,
    form: str | None,
) -> Response:
    """A page of the drops of a player (`of` is a text) or of a room run (`of` is its number)."""
    place = None if before is None else _place(before)
    server.rooms.persistence.runs.report([])  # write the latest landings first
    found = await server.ledger.read(ledger.plays, of=of, before=place, limit=limit + 1)
    boards = await _boards_of(request, server, {play.board_digest for play in found[:limit]})
    views = [_view(play, boards[play.board_digest]) for play in found[:limit]]
    page = PlayList(views, views[-1].play if len(found) > limit else None)
    headers = {"cache-control": "no-store", "vary": "accept"}
    if page.next is not None:
        headers |= next_page(request, before=page.next)
    if not _wants_csv(form, request):
        return reply(page, headers=headers)
    # Without a byte order mark Excel reads UTF-8 as another encoding.
    table = _table(views).encode("utf-8-sig")
    return Response(table, headers=headers, media_type=f"{CSV}; charset=utf-8")


def _place(text: str) -> tuple[int, int]:
    match = _PLACE.fullmatch(text)
    if match is None:
        raise InvalidValueError(
            f"before {shorten(text)} is not a drop's place; send the `next` of a page",
            field="before",
        )
    return int(match[1]), int(match[2])


async def _boards_of(request: Request, server: Services, digests: set[str]) -> dict[str, Board]:
    """These boards, registered if they were not, so that clients can get paths on them.

    Raises the errors of `compute`.
    """
    boards = {}
    for digest in sorted(digests):
        try:
            boards[digest] = server.boards.find(digest)
        except UnknownBoardError:
            text = await server.ledger.read(store.board, digest=digest)
            boards[digest] = await parse_board(request, (text or "{}").encode(), tasks.board_of)
            server.boards.register(boards[digest])
    return boards


def _view(play: Row[Any], board: Board) -> PlayView:
    columns = play._asdict()
    chosen = {name: columns[name] for name in ("x", "aim")}
    query = urllib.parse.urlencode({name: repr(v) for name, v in chosen.items() if v is not None})
    path = f"/api/v1/drops/{play.board_digest}/{play.seed}" + (f"?{query}" if query else "")
    place = f"{columns.pop('run')}.{columns.pop('ball')}"
    columns["seed"] = str(play.seed)
    label = board.bins.label_of(play.bin)
    return PlayView(play=place, path=path, label=label, **columns)


def _wants_csv(chosen: str | None, request: Request) -> bool:
    if chosen is not None:
        return chosen == "csv"
    return asks_for(whole(request.headers, "accept"), CSV, "application/json")


def _table(views: list[PlayView]) -> str:
    """A CSV table with one line for each drop, below the fields' names (RFC 4180).

    A text that a spreadsheet would take for something else gets an apostrophe in front, which makes
    it text there.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, PlayView.__struct_fields__)
    writer.writeheader()
    for view in views:
        writer.writerow({k: _cell(v) for k, v in msgspec.to_builtins(view).items()})
    return text.getvalue()


def _cell(value: object) -> object:
    if isinstance(value, bool):
        return "true" if value else "false"
    misread = isinstance(value, str) and _READ_AS_OTHER.fullmatch(value)
    return f"'{value}" if misread else value
