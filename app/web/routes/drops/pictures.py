"""Pictures of drops: stills, animations, and pictures of many drops, each format with a route."""

from collections.abc import Callable, Coroutine
from typing import Annotated, Literal, TypeVarTuple

from fastapi import APIRouter, Depends, Query, Request, Response

from plinko.app.computing import prices, tasks
from plinko.app.computing.prices import Price
from plinko.app.computing.tasks import Many
from plinko.app.pictures.cache import look
from plinko.app.render.parts.view import LEAST_WIDTH, MOST_WIDTH, lay_out
from plinko.app.web.ranges import in_part
from plinko.app.web.routes.common import (
    Server,
    address_of,
    attended,
    cache_headers,
    charged,
    check_count,
    documented,
    documented_failures,
    is_current,
    not_modified,
)
from plinko.app.web.routes.drops.asked import Asked
from plinko.app.web.routes.queries import Number, Whole
from plinko.app.web.routes.table import operations
from plinko.app.web.services import Services
from plinko.engine import PHYSICS_VERSION, Board
from plinko.engine.parameters import Exact
from plinko.engine.seeding import parse_seed

router = operations("pictures")

Ts = TypeVarTuple("Ts")

MOST_FPS = 60

Width = Annotated[
    Whole, Query(ge=LEAST_WIDTH, le=MOST_WIDTH, description="Width of the picture in pixels.")
]
ThemeName = Annotated[Literal["light", "dark"], Query(description="One of the page's themes.")]
Moment = Annotated[
    Number | None,
    Query(description="Seconds after the start: show this moment instead of the whole drop."),
]
Fps = Annotated[Whole, Query(ge=1, le=MOST_FPS, description="Frames a second.")]

STILLS = {"png": "image/png", "jpg": "image/jpeg"}
"""Media types of still pictures by format. A drop's `.webp` is an animation."""

MANY = {**STILLS, "webp": "image/webp"}
"""Media types of pictures of many drops by format."""

DEFAULT_DROPS = 10_000
_MOST_SHEET = 1 << 23  # pixels, about, of the largest sheet of drops

ANIMATIONS = {"gif": "image/gif", "webp": "image/webp", "apng": "image/apng"}
VIDEOS = {"mp4": "video/mp4"}
"""Videos need a library that may not be installed."""


async def picture_reply(
    request: Request,
    server: Services,
    name: str,
    make: Callable[[], Coroutine[None, None, bytes]],
    media_type: str,
) -> Response:
    """The picture called `name`, a part of it, or 304; `make` draws it if it is not cached.

    `name` must contain everything that decides the picture, except the drawing code, which this
    function adds. Raises the errors of `make`.
    """
    etag = f"{name}.{look()}"
    if is_current(request, etag):
        return not_modified(etag)
    picture = await attended(request, server.pictures.get(etag, make))
    return in_part(request, picture, cache_headers(etag), media_type)


def drawn_by_worker(
    request: Request, server: Services, price: Price, draw: Callable[[*Ts], bytes], *values: *Ts
) -> Callable[[], Coroutine[None, None, bytes]]:
    """A function that has a worker draw a picture, charged to the client of this request."""
    return lambda: charged(server, address_of(request), price, draw, *values)


def pixels_of(board: Board, width: int) -> int:
    """The number of pixels of a board's picture."""
    view = lay_out(board, width)
    return view.width * view.height


def add_routes(
    routes: APIRouter,
    path: str,
    formats: dict[str, str],
    endpoint: Callable[[str], Callable[..., object]],
    title: str,
    name: str,
    *failures: int,
    description: str = "The picture",
) -> None:
    """Add a GET route for each format; the format is a suffix of `path` and `name`.

    `failures` are the statuses of failures that OpenAPI lists in addition to the usual ones.
    """
    for fmt, media_type in formats.items():
        routes.add_api_route(
            f"{path}.{fmt}",
            endpoint(fmt),
            summary=f"{title} as {fmt.upper()}",
            response_class=Response,
            name=f"{name}_{fmt}",
            responses={
                **documented(None, status=206, description="A part", media_type=media_type),
                **documented(None, description=description, media_type=media_type),
                **documented_failures(304, 404, 416, 422, 503, *failures),
            },
        )


def _still(fmt: str) -> Callable[..., object]:
    async def get_still(
        request: Request,
        server: Server,
        ask: Asked,
        width: Width = 760,
        theme: ThemeName = "light",
        t: Moment = None,
    ) -> Response:
        """The ball's whole path over the board with contacts and end, or one moment of it."""
        name = f"{ask.name}.{fmt}.{width}.{theme}.{t!r}"
        price = prices.still(pixels_of(ask.board, width))
        make = drawn_by_worker(request, server, price, tasks.still, ask, fmt, width, theme, t)
        return await picture_reply(request, server, name, make, STILLS[fmt])

    return get_still


def _animation(fmt: str) -> Callable[..., object]:
    async def get_animation(
        request: Request,
        server: Server,
        ask: Asked,
        width: Width = 760,
        theme: ThemeName = "light",
        fps: Fps = 30,
    ) -> Response:
        """The ball as it falls, at real speed, then the whole drop for two seconds."""

        async def make() -> bytes:
            """Count the frames first: the price of the animation depends on them."""
            address, price = address_of(request), prices.one_drop(ask.board, ask.solver)
            count = tasks.frame_count
            frames = await charged(server, address, price, count, ask, fmt, fps, quick=True)
            price = prices.animation(pixels_of(ask.board, width), frames)
            asked = (ask, fmt, width, fps, theme)
            return await charged(server, address, price, tasks.animation, *asked)

        name = f"{ask.name}.{fmt}.{width}.{theme}.{fps}"
        return await picture_reply(request, server, name, make, {**ANIMATIONS, **VIDEOS}[fmt])

    return get_animation


def _name_of(many: Many) -> str:
    """A name with everything that decides these drops."""
    return f"{many.board.digest}.{PHYSICS_VERSION}.{many.drops}.{many.first}"


async def _many(
    board: str,
    server: Server,
    drops: Annotated[Whole | None, Query(description="How many; at most 10,000.")] = None,
    seed: Annotated[str, Query(description="Of the first drop; each next one adds 1.")] = "0",
) -> Many:
    """The drops of a request; raises the errors of unknown boards and invalid values."""
    count = min(DEFAULT_DROPS, prices.MAX_DROPS) if drops is None else drops
    check_count(count, "plinko render")
    first = parse_seed(seed)
    parse_seed(first + count - 1)
    return Many(server.boards.find(board), count, first)


ManyAsked = Annotated[Many, Depends(_many)]


def _of_many(
    what: str, draw: Callable[[Many, str, int, str], bytes], about: str
) -> Callable[[str], Callable[..., object]]:
    """A function that makes the endpoint of a picture of many drops for a format."""

    def endpoint(fmt: str) -> Callable[..., object]:
        async def get_picture(
            request: Request,
            server: Server,
            many: ManyAsked,
            width: Width = 760,
            theme: ThemeName = "light",
        ) -> Response:
            name = f"{_name_of(many)}.{what}.{fmt}.{width}.{theme}"
            prices.many_drops(many.board, many.drops, Exact()).check()
            price = prices.still(pixels_of(many.board, width), many.drops)
            make = drawn_by_worker(request, server, price, draw, many, fmt, width, theme)
            return await picture_reply(request, server, name, make, MANY[fmt])

        get_picture.__doc__ = about
        return get_picture

    return endpoint


def _sheet(fmt: str) -> Callable[..., object]:
    async def get_sheet(
        board: str,
        request: Request,
        server: Server,
        drops: Annotated[Whole, Query(ge=1, le=256, description="How many.")] = 25,
        seed: Annotated[str, Query(description="Of the first drop; each next one adds 1.")] = "0",
        columns: Annotated[
            Whole | None, Query(description="Default: as many as rows, if they fit.")
        ] = None,
        width: Annotated[Whole, Query(ge=1, le=MOST_WIDTH, description="Width in pixels.")] = 1140,
        theme: ThemeName = "light",
    ) -> Response:
        """The whole paths of many drops side by side, each with its seed and its result."""
        first = parse_seed(seed)
        parse_seed(first + drops - 1)
        many = Many(server.boards.find(board), drops, first)
        name = f"{_name_of(many)}.sheet.{fmt}.{columns}.{width}.{theme}"
        price = prices.still(_MOST_SHEET, drops)
        asked = (many, fmt, width, theme, columns)
        make = drawn_by_worker(request, server, price, tasks.sheet, *asked)
        return await picture_reply(request, server, name, make, MANY[fmt])

    return get_sheet


density = _of_many(
    "density",
    tasks.density,
    "How much time the balls of many drops spend at each place, as light on the board.",
)
histogram = _of_many(
    "histogram", tasks.histogram, "How many balls land in each bin, next to the expected numbers."
)

add_routes(router, "/drops/{board}/{seed}", STILLS, _still, "A drop", "get_drop")
add_routes(router, "/drops/{board}/{seed}", ANIMATIONS, _animation, "A drop's fall", "get_drop")
add_routes(router, "/drops/{board}/{seed}", VIDEOS, _animation, "A drop's fall", "get_drop", 501)
add_routes(
    router, "/boards/{board}/density", MANY, density, "The density of many drops", "get_density"
)
add_routes(
    router,
    "/boards/{board}/histogram",
    MANY,
    histogram,
    "The histogram of many drops",
    "get_histogram",
)
add_routes(router, "/boards/{board}/sheet", MANY, _sheet, "Many drops", "get_sheet")
