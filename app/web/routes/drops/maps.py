"""The map from a board's starts to bins, every pixel proven: as JSON tiles and as a picture."""

import functools
from fractions import Fraction
from typing import Annotated

from fastapi import Query, Request, Response

from plinko.app.computing import prices, proofs
from plinko.app.web.routes.common import (
    Server,
    address_of,
    cache_headers,
    charged,
    compute,
    documented,
    is_current,
    not_modified,
    reply,
)
from plinko.app.web.routes.drops.certificates import require_certifier
from plinko.app.web.routes.drops.pictures import (
    STILLS,
    StillFormat,
    ThemeName,
    documented_picture,
    picture_reply,
)
from plinko.app.web.routes.queries import Whole
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.drops import MapTile
from plinko.engine import PHYSICS_VERSION

router = operations("drops")

STRIP_PIXELS = 160
"""Of a whole strip; a tile is part of a strip."""

MOST_PIXELS = 32
"""Of a tile, which then takes at most a second of one thread."""

X = Annotated[str, Query(max_length=400, description="Zoom in on this exact start, in metres.")]
Level = Annotated[Whole, Query(ge=0, le=40, description="Number of zooms by ten.")]


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
    """The bins that the starts around x lead to: pixels of a strip of 160, zoomed 10^level times.

    -1: the ball stays on the board, -2: not decided, -3: not a valid start.
    """
    require_certifier()
    found, middle = server.boards.find(board), _start(x)
    etag = f"{found.digest}.{PHYSICS_VERSION}.map.{middle}.{level}.{first}.{count}"
    if is_current(request, etag):
        return not_modified(etag)
    asked = (found, middle, level, STRIP_PIXELS, first, count)
    tile, in_time = await compute(request, prices.proofs(count), proofs.tile, *asked)
    # A tile that ran out of time has undecided pixels, which another try may decide: not cached.
    return reply(tile, headers=cache_headers(etag) if in_time else None)


def _start(x: str) -> Fraction:
    from plinko.engine.certified.certify import exact_start  # noqa: PLC0415

    return exact_start(x)


@router.get(
    "/boards/{board}/map.{format:picture}",
    summary="The map of starts",
    response_class=Response,
    responses=documented_picture(*STILLS, failures=(501,)),
)
async def get_map(
    board: str,
    request: Request,
    server: Server,
    fmt: StillFormat,
    x: X = "0",
    levels: Annotated[Whole, Query(ge=1, le=41, description="Number of strips.")] = 8,
    pixels: Annotated[Whole, Query(ge=1, le=512, description="Pixels of each strip.")] = 64,
    theme: ThemeName = "light",
) -> Response:
    """The bin as a function of the start, in strips; each zooms tenfold into the one above."""
    require_certifier()
    price = prices.proofs(levels * pixels)
    found, middle = server.boards.find(board), _start(x)
    name = f"{found.digest}.{PHYSICS_VERSION}.map.{middle}.{levels}.{pixels}.{theme}"
    asked = (found, middle, levels, pixels, fmt, theme)
    draw = functools.partial(charged, server, address_of(request), price, proofs.picture, *asked)
    return await picture_reply(request, name, fmt, draw)
