"""The map of a board's starts, each pixel proven at a bounded cost: tiles as JSON, a picture."""

from collections.abc import Callable
from fractions import Fraction
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from app.computing import prices, proofs
from app.web.routes.common import (
    Server,
    cache_headers,
    compute,
    documented,
    is_current,
    not_modified,
    reply,
)
from app.web.routes.drops.certificates import require_certifier
from app.web.routes.drops.pictures import (
    STILLS,
    ThemeName,
    add_routes,
    drawn_by_worker,
    picture_reply,
)
from app.web.routes.queries import Whole
from app.web.schemas.drops import MapTile
from engine import PHYSICS_VERSION

router = APIRouter(prefix="/api/v1", tags=["drops"])

STRIP_PIXELS = 160
"""Of a whole strip, of which tiles are parts."""

MOST_PIXELS = 32
"""Of a tile: a second of one thread, or less."""

X = Annotated[str, Query(max_length=400, description="Zoom in on this start in metres, exact.")]
Level = Annotated[Whole, Query(ge=0, le=40, description="Zooms by ten.")]


@router.get(
    "/boards/{board}/map",
    summary="A tile of the map of starts",
    responses=documented(MapTile, 304, 404, 422, 501, 503),
)
async def get_map_tile(
    board: str,
    request: Request,
    server: Server,
    x: X = "0",
    level: Level = 0,
    first: Annotated[Whole, Query(ge=0, lt=STRIP_PIXELS, description="Pixel of the strip.")] = 0,
    count: Annotated[Whole, Query(ge=1, le=MOST_PIXELS, description="How many.")] = MOST_PIXELS,
) -> Response:
    """Which bin the starts about x lead to: pixels of a strip of 160, zoomed 10^level times.

    -1 is a ball that stays on the board, -2 what is not decided, -3 what is no start.
    """
    require_certifier()
    found, middle = server.boards.find(board), _start(x)
    etag = f"{found.digest}.{PHYSICS_VERSION}.map.{middle}.{level}.{first}.{count}"
    if is_current(request, etag):
        return not_modified(etag)
    asked = (found, middle, level, STRIP_PIXELS, first, count)
    tile, in_time = await compute(request, prices.proofs(count), proofs.tile, *asked)
    # Only what another try would not change is kept by caches.
    return reply(tile, headers=cache_headers(etag) if in_time else None)


def _start(x: str) -> Fraction:
    from engine.certified.certify import exact_start  # noqa: PLC0415

    return exact_start(x)


def _map(fmt: str) -> Callable[..., object]:
    async def get_map(
        board: str,
        request: Request,
        server: Server,
        x: X = "0",
        levels: Annotated[Whole, Query(ge=1, le=41, description="Strips.")] = 8,
        pixels: Annotated[Whole, Query(ge=1, le=512, description="Of a strip.")] = 64,
        theme: ThemeName = "light",
    ) -> Response:
        """The bin as a function of the start, strip below strip, each a tenth of the one above."""
        require_certifier()
        price = prices.proofs(levels * pixels)
        found, middle = server.boards.find(board), _start(x)
        name = f"{found.digest}.{PHYSICS_VERSION}.map.{fmt}.{middle}.{levels}.{pixels}.{theme}"
        asked = (found, middle, levels, pixels, fmt, theme)
        make = drawn_by_worker(request, server, price, proofs.picture, *asked)
        return await picture_reply(request, server, name, make, STILLS[fmt])

    return get_map


add_routes(router, "/boards/{board}/map", STILLS, _map, "The map of starts", "get_map", 501)
