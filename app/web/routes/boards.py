"""Boards: list, look up, register."""

import hashlib
from collections.abc import Iterable
from typing import Annotated

import msgspec
from fastapi import Query, Request, Response

from plinko.app.computing import tasks
from plinko.app.web.routes.common import (
    Server,
    body_of,
    cache_headers,
    documented,
    is_current,
    json_body,
    not_modified,
    parse_board,
    reply,
)
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.board_form import BoardForm
from plinko.app.web.schemas.boards import BoardList, BoardOdds, BoardSummary, BoardView, Odds
from plinko.engine import Board, preset_names
from plinko.engine.payouts.listing import Listed, listed, row_of
from plinko.engine.payouts.record import odds_of_record

router = operations("boards", "/api/v1/boards")

Digest = Annotated[str | None, Query(description="List only the board with this digest.")]

_EXAMPLE = {
    "name": "three bins",
    "ball": {"radius": 0.08, "restitution": 0.6},
    "pegs": [{"x": 0.0, "y": 1.0, "radius": 0.05}],
    "walls": [
        {"x1": -1.5, "y1": -1.0, "x2": -1.5, "y2": 2.0},
        {"x1": 1.5, "y1": -1.0, "x2": 1.5, "y2": 2.0},
    ],
    "bins": {"y": 2.0, "edges": [-1.5, -0.5, 0.5, 1.5], "multipliers": [2.0, 0.5, 2.0]},
    "drop": {"x": 0.0, "y": 0.0, "jitter": 0.5},
}


@router.get("", summary="List the boards", responses=documented(BoardList, 304))
async def list_boards(request: Request, server: Server, digest: Digest = None) -> Response:
    """Every preset with its payout table and return, then the registered boards.

    Drops may have a stake only where `stakes` is true.

    With `digest` the list has only that board, or is empty if the server does not know it.
    """
    rows = [*map(listed, preset_names()), *map(row_of, server.boards.registered())]
    body = list_of(row for row in rows if digest is None or row.digest == digest)
    etag = hashlib.sha256(body).hexdigest()
    headers = {"etag": f'"{etag}"', "cache-control": "no-cache"}
    if is_current(request, etag):
        return Response(status_code=304, headers=headers)
    return reply(body, headers=headers)


@router.get("/{board}", summary="Get a board", responses=documented(BoardView, 304))
async def get_board(board: str, request: Request, server: Server) -> Response:
    """The whole board with this preset's name or digest. The ETag is its digest."""
    found = server.boards.find(board)
    if is_current(request, found.digest):
        return not_modified(found.digest)
    return reply(view_of(found), headers=cache_headers(found.digest))


@router.post(
    "",
    summary="Register a board",
    responses={
        **documented(BoardView, description="The board was known already"),
        **documented(BoardView, status=201, description="Registered"),
    },
    openapi_extra=body_of(BoardForm, _EXAMPLE),
)
async def register_board(request: Request, server: Server) -> Response:
    """Check a board and store it under its digest.

    The same content has the same digest, so registering a board again changes nothing. The server
    stores a limited number of boards. It forgets the least recently used one first; you can
    register that one again.
    """
    board, view = await parse_board(request, await json_body(request), tasks.board_and_view)
    new = server.boards.register(board)
    headers = {"location": f"/api/v1/boards/{board.digest}"}
    return reply(view, 201 if new else 200, headers)


@router.post(
    "/check",
    summary="Check a board",
    responses=documented(BoardView, description="The board can be played"),
    openapi_extra=body_of(BoardForm, _EXAMPLE),
)
async def check_board(request: Request) -> Response:
    """Check a board without storing it. The response has its digest and all defaults filled in."""
    return reply(await parse_board(request, await json_body(request), tasks.board_view))


@router.get("/{board}/odds", summary="Get a board's odds", responses=documented(BoardOdds))
async def get_odds(board: str, server: Server) -> Response:
    """A preset's return, hit rate, volatility and awards for each aim, from counted landings.

    On a symmetric board the list has the aims of one side, which hold for both. For a board that is
    not a preset the list is empty; `plinko payouts` counts its landings.
    """
    return reply(odds_of(server.boards.find(board)))


def list_of(rows: Iterable[Listed]) -> bytes:
    """The list of these boards, as JSON."""
    return msgspec.json.encode(BoardList([_summary(row) for row in rows]))


def odds_of(board: Board) -> BoardOdds:
    aims = [msgspec.convert(each.to_dict(), Odds) for each in odds_of_record(board)]
    return BoardOdds(board.digest, aims)


def _summary(row: Listed) -> BoardSummary:
    return BoardSummary(
        name=row.name,
        digest=row.digest,
        preset=row.world is not None,
        stakes=row.stakes,
        world=row.world,
        bins=row.bins,
        pegs=row.pegs,
        rows=row.rows,
        risk=row.risk,
        multipliers=list(row.multipliers),
        returned=row.returned,
        top_multiplier=max(row.multipliers),
    )


def view_of(board: Board) -> BoardView:
    return BoardView(board.name, board.digest, board.to_dict())
