"""The last plays of a player or of a room, recalled from the ledger with their paths."""

import csv
import io
import re
import urllib.parse
from typing import Annotated, Final, Literal

import msgspec
from fastapi import APIRouter, Query, Request, Response
from msgspec import Meta

from app.errors import InvalidValueError, UnknownBoardError, shorten
from app.persistence.statements import plays as ledger
from app.persistence.statements import store
from app.persistence.statements.plays import Play
from app.rooms.stakes import parse_who
from app.web.routes.common import Server, checked_board, documented, limit_drops, next_page, reply
from app.web.routes.queries import Whole
from app.web.schemas.fields import Digest, PhysicsVersion, Seed
from app.web.services import Services
from engine import Board


class PlayView(msgspec.Struct, frozen=True):
    """A drop as it was played. Lengths in m, times in s, stake and payout in minor units."""

    play: Annotated[str, Meta(description="Its place; `before` of the page that follows it.")]
    room: str
    board: str
    board_digest: Digest
    physics_version: PhysicsVersion
    seed: Seed
    x: Annotated[float | None, Meta(description="The start, where the player chose it.")]
    aim: Annotated[float | None, Meta(description="Middle of what the seed drew, if chosen.")]
    stake: int
    practice: bool
    name: Annotated[str | None, Meta(description="Whose ball it was, as those who watched saw.")]
    colour: Annotated[str | None, Meta(description="Of the ball, #rrggbb.")]
    session: Annotated[str | None, Meta(description="The fair session that it was in.")]
    session_drop: Annotated[int | None, Meta(description="Its number there.")]
    time: Annotated[int | None, Meta(description="Of its receipt: Unix time, in ms.")]
    digest: Annotated[str | None, Meta(description="Of its whole path; null while it falls.")]
    bin: int | None
    label: Annotated[str | None, Meta(description="The prize: text of its bin's label.")]
    score: Annotated[float | None, Meta(description="The multiplier.")]
    payout: int | None
    duration: float | None
    x_end: float | None
    unsettled: str | None
    path: Annotated[str, Meta(description="Where its path is told, impact by impact.")]


class PlayList(msgspec.Struct, frozen=True):
    """A page of a player's plays, the last one first."""

    plays: list[PlayView]
    next: Annotated[str | None, Meta(description="`before` of the following page; null: no more.")]


router = APIRouter(prefix="/api/v1", tags=["rooms"])

CSV = "text/csv"

Limit = Annotated[Whole, Query(ge=1, le=100, description="How many plays, at most.")]
RoomLimit = Annotated[Whole, Query(ge=1, le=1000, description="How many plays, at most.")]
Before = Annotated[
    str | None, Query(description="The play before which the page begins; without, the last one.")
]
Format = Annotated[
    Literal["json", "csv"] | None, Query(description="Else what the Accept header prefers.")
]

_FORMULA: Final = ("=", "+", "-", "@", "\t", "\r")
_PLACE = re.compile(r"(\d{1,15})\.(\d{1,15})", re.ASCII)


_ANSWERS = documented(PlayList, 404, 422, 429, 503)
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
    """The drops that had `key` as their `who`, the last first, each with its path's address.

    Whoever knows a mark may ask for its plays: one that nobody guesses keeps them to oneself. Those
    of rooms whose balls touch each other are not among them, as no ball there has a path of its
    own. As CSV with `format=csv` or `Accept: text/csv`. `Link` names the following page.
    """
    limit_drops(request, server)
    return await _page(request, server, str(parse_who(key)), before, limit, format)


@router.get("/rooms/{room}/plays", summary="Recall a room's plays", responses=_ANSWERS)
async def list_room_plays(
    room: str,
    request: Request,
    server: Server,
    before: Before = None,
    limit: RoomLimit = 20,
    format: Format = None,  # noqa: A002 - the parameter's name
) -> Response:
    """The drops of a room since it was opened or reset, the last first, as those of a player.

    With `format=csv` a lesson's results for a spreadsheet.
    """
    found = await server.rooms.seek(room)  # first: it counts where its room is
    limit_drops(request, server)
    run = server.rooms.persistence.runs.of(found.room).number
    return await _page(request, server, run, before, limit, format)


async def _page(
    request: Request,
    server: Services,
    of: str | int,
    before: str | None,
    limit: int,
    form: str | None,
) -> Response:
    """A page of the plays of a player's mark, or of a room's run."""
    place = None if before is None else _place(before)
    server.rooms.persistence.runs.report([])  # what has landed just now is among them
    found = await server.ledger.read(ledger.plays, of=of, before=place, limit=limit + 1)
    boards = await _boards_of(request, server, {play.board_digest for play in found[:limit]})
    views = [_view(play, boards[play.board_digest]) for play in found[:limit]]
    page = PlayList(views, views[-1].play if len(found) > limit else None)
    headers = {"cache-control": "no-store", "vary": "accept"}
    if page.next is not None:
        headers |= next_page(request, before=page.next)
    if not _wants_csv(form, request):
        return reply(page, headers=headers)
    return Response(_table(views), headers=headers, media_type=f"{CSV}; charset=utf-8")


def _place(text: str) -> tuple[int, int]:
    match = _PLACE.fullmatch(text)
    if match is None:
        raise InvalidValueError(
            f"before {shorten(text)} is no play: it is the `next` of a page", field="before"
        )
    return int(match[1]), int(match[2])


async def _boards_of(request: Request, server: Services, digests: set[str]) -> dict[str, Board]:
    """These boards, so that paths on them can be asked for; raises what `compute` raises."""
    boards = {}
    for digest in sorted(digests):
        try:
            boards[digest] = server.boards.find(digest)
        except UnknownBoardError:
            text = await server.ledger.read(store.board, digest=digest)
            boards[digest] = await checked_board(request, (text or "{}").encode())
            server.boards.register(boards[digest])
    return boards


def _view(play: Play, board: Board) -> PlayView:
    chosen = {name: getattr(play, name) for name in ("x", "aim")}
    query = urllib.parse.urlencode({name: repr(v) for name, v in chosen.items() if v is not None})
    path = f"/api/v1/drops/{play.board_digest}/{play.seed}" + (f"?{query}" if query else "")
    own = ("play", "path", "label")
    shared = [name for name in PlayView.__struct_fields__ if name not in own]
    fields = {name: getattr(play, name) for name in shared}
    label = board.bins.label_of(play.bin)
    return PlayView(play="{}.{}".format(*play.place), path=path, label=label, **fields)


def _wants_csv(chosen: str | None, request: Request) -> bool:
    return chosen == "csv" or (chosen is None and CSV in request.headers.get("accept", ""))


def _table(views: list[PlayView]) -> str:
    """One line a play, below the fields' names (RFC 4180).

    A text that a spreadsheet would take for a formula has an apostrophe before it, which makes it
    text there.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, PlayView.__struct_fields__)
    writer.writeheader()
    for view in views:
        writer.writerow({k: _as_text(v) for k, v in msgspec.to_builtins(view).items()})
    return text.getvalue()


def _as_text(value: object) -> object:
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value
