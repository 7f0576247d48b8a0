"""Boards: list, look up, register."""

from typing import Annotated

import msgspec
from fastapi import Query, Request, Response

from plinko.app.computing import tasks
from plinko.app.web.routes.common import (
    Server,
    board_task,
    body_of,
    cache_headers,
    documented,
    is_current,
    json_body,
    not_modified,
    reply,
)
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.board_form import BoardForm
from plinko.app.web.schemas.boards import BoardList, BoardOdds, BoardSummary, BoardView, Odds
from plinko.engine import Board, preset_names
from plinko.engine.payouts.listing import Listed, listed
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


@router.get("", summary="List the boards", responses=documented(BoardList))
async def list_boards(server: Server, digest: Digest = None) -> Response:
    """Every preset with its payout table and return, then the registered boards.

    Drops may have a stake only where `stakes` is true.

    With `digest` the list has only that board, or is empty if the server does not know it.
    """
    presets = [listed(name) for name in preset_names()]
    boards: list[Listed | Board] = [*presets, *server.boards.registered()]
    if digest is not None:
        boards = [board for board in boards if board.digest == digest]
    return reply(BoardList([_summary(board) for board in boards]))


@router.get("/{board}", summary="Get a board", responses=documented(BoardView, 304, 404))
async def get_board(board: str, request: Request, server: Server) -> Response:
    """The whole board with this preset's name or digest. The ETag is its digest."""
    found = server.boards.find(board)
    if is_current(request, found.digest):
        return not_modified(found.digest)
    return reply(_view(found), headers=cache_headers(found.digest))


@router.post(
    "",
    summary="Register a board",
    responses={
        **documented(BoardView, 400, 413, 422, 503, description="The board was known already"),
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
    board, view = await board_task(request, await json_body(request), tasks.board_and_view)
    new = server.boards.register(board)
    headers = {"location": f"/api/v1/boards/{board.digest}"}
    return reply(view, 201 if new else 200, headers)


@router.post(
    "/check",
    summary="Check a board",
    responses=documented(BoardView, 400, 413, 422, 503, description="The board can be played"),
    openapi_extra=body_of(BoardForm, _EXAMPLE),
)
async def check_board(request: Request) -> Response:
    """Check a board without storing it. The response has its digest and all defaults filled in."""
    return reply(await board_task(request, await json_body(request), tasks.board_view))


@router.get("/{board}/odds", summary="Get a board's odds", responses=documented(BoardOdds, 404))
async def get_odds(board: str, server: Server) -> Response:
    """A preset's return, hit rate, volatility and awards for each aim, from counted landings.

    On a symmetric board the list has the aims of one side, which hold for both. For a board that is
    not a preset the list is empty; `plinko payouts` counts its landings.
    """
    found = server.boards.find(board)
    aims = [msgspec.convert(each.to_dict(), Odds) for each in odds_of_record(found)]
    return reply(BoardOdds(found.digest, aims))


def _summary(board: Listed | Board) -> BoardSummary:
    if isinstance(board, Board):
        pays = list(board.bins.multipliers)
        return BoardSummary(
            name=board.name,
            digest=board.digest,
            preset=False,
            stakes=False,
            world=None,
            bins=board.bins.count,
            pegs=len(board.pegs),
            rows=None,
            risk=None,
            multipliers=pays,
            returned=None,
            top_multiplier=max(pays),
        )
    return BoardSummary(
        name=board.name,
        digest=board.digest,
        preset=True,
        stakes=board.stakes,
        world=board.world,
        bins=board.bins,
        pegs=board.pegs,
        rows=board.rows,
        risk=board.risk,
        multipliers=list(board.multipliers),
        returned=board.returned,
        top_multiplier=max(board.multipliers),
    )


def _view(board: Board) -> BoardView:
    return BoardView(board.name, board.digest, board.to_dict())
