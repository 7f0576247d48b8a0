"""Drops as pictures: stills, moments, animations, and many drops in one; an address a format."""

import functools
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response

from app.errors import InvalidValueError
from app.pictures.cache import look
from app.web.routes.asked import Asked
from app.web.routes.common import Server, cache_headers, documented, is_current, not_modified
from app.web.routes.simulate import MAX_SECONDS, tally_of
from app.web.services import Services
from engine import PHYSICS_VERSION, Board, Drop
from engine.parameters import Exact
from engine.seeding import parse_seed

router = APIRouter(prefix="/api/v1", tags=["pictures"])

Width = Annotated[int, Query(description="Width of the picture in pixels, 240 to 2048.")]
ThemeName = Annotated[str, Query(description="`light` or `dark`, the page's themes.")]
Moment = Annotated[
    float | None,
    Query(description="Seconds from the start: the picture of that moment, not of the whole drop."),
]
Fps = Annotated[int, Query(description="Frames a second, 1 to 60.")]

STILLS = {"png": "image/png", "jpg": "image/jpeg"}
"""Format and media type of still pictures. A drop's `.webp` is an animation."""

MANY = {**STILLS, "webp": "image/webp"}
"""The same of pictures of many drops."""

DEFAULT_DROPS = 10_000

ANIMATIONS = {"gif": "image/gif", "webp": "image/webp", "apng": "image/apng"}


async def picture_reply(
    request: Request, server: Services, name: str, draw: Callable[[], bytes], media_type: str
) -> Response:
    """The picture called `name`, or 304; drawn in a worker if nobody asked for it lately."""
    etag = f"{name}.{look()}"
    if is_current(request, etag):
        return not_modified(etag)
    picture = await server.pictures.get(etag, draw)
    return Response(picture, headers=cache_headers(etag), media_type=media_type)


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
    """One GET route a format, `path` and `name` followed by it; and how each may fail besides."""
    for fmt, media_type in formats.items():
        routes.add_api_route(
            f"{path}.{fmt}",
            endpoint(fmt),
            summary=f"{title} as {fmt.upper()}",
            response_class=Response,
            name=f"{name}_{fmt}",
            responses=documented(
                None,
                304,
                404,
                422,
                503,
                *failures,
                description=description,
                media_type=media_type,
            ),
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
        """The whole path of the ball over the board with its contacts and its end; or a moment."""
        done = await server.workers.run(ask.drop)
        name = f"{done.digest}.{fmt}.{width}.{theme}.{t!r}"
        draw = functools.partial(_draw_still, done, fmt, width, theme, t)
        return await picture_reply(request, server, name, draw, STILLS[fmt])

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
        done = await server.workers.run(ask.drop)
        name = f"{done.digest}.{fmt}.{width}.{theme}.{fps}"
        draw = functools.partial(_draw_animation, done, fmt, width, fps, theme)
        return await picture_reply(request, server, name, draw, ANIMATIONS[fmt])

    return get_animation


class _Patience:
    """Called with the drops done so far; raises InvalidValueError when they take too long."""

    def __init__(self, drops: int) -> None:
        self._drops = drops
        self._started = time.monotonic()

    def __call__(self, done: int) -> None:
        if done < self._drops and time.monotonic() - self._started > MAX_SECONDS:
            raise InvalidValueError(
                f"drops {self._drops} take too long on this board: {done} were done after "
                f"{MAX_SECONDS:g} s; plinko render takes its time",
                field="drops",
            )


@dataclass(frozen=True, slots=True)
class _Many:
    """The drops of a picture of many: `drops` seeds from `first` on."""

    board: Board
    drops: int
    first: int

    @property
    def name(self) -> str:
        """All that decides what they do."""
        return f"{self.board.digest}.{PHYSICS_VERSION}.{self.drops}.{self.first}"

    @property
    def seeds(self) -> range:
        """All of them."""
        return range(self.first, self.first + self.drops)


async def _many(
    board: str,
    server: Server,
    drops: Annotated[int | None, Query(description="How many; at most `--max-simulation`.")] = None,
    seed: Annotated[str, Query(description="Of the first drop; then one more each.")] = "0",
) -> _Many:
    """The drops of a request; raises the errors of what cannot be."""
    most = server.settings.max_simulation
    count = min(DEFAULT_DROPS, most) if drops is None else drops
    if not 1 <= count <= most:
        raise InvalidValueError(
            f"drops {count} is not from 1 to {most}; plinko render takes more", field="drops"
        )
    first = parse_seed(seed)
    parse_seed(first + count - 1)
    return _Many(server.boards.find(board), count, first)


Many = Annotated[_Many, Depends(_many)]


def _of_many(
    what: str, draw: Callable[[_Many, str, int, str], bytes], about: str
) -> Callable[[str], Callable[..., object]]:
    """For each format the endpoint of a picture of many drops, called `what`."""

    def endpoint(fmt: str) -> Callable[..., object]:
        async def get_picture(
            request: Request,
            server: Server,
            many: Many,
            width: Width = 760,
            theme: ThemeName = "light",
        ) -> Response:
            name = f"{many.name}.{what}.{fmt}.{width}.{theme}"
            work = functools.partial(draw, many, fmt, width, theme)
            return await picture_reply(request, server, name, work, MANY[fmt])

        get_picture.__doc__ = about
        return get_picture

    return endpoint


def _sheet(fmt: str) -> Callable[..., object]:
    async def get_sheet(
        board: str,
        request: Request,
        server: Server,
        drops: Annotated[int, Query(ge=1, le=256, description="How many.")] = 25,
        seed: Annotated[str, Query(description="Of the first drop; then one more each.")] = "0",
        columns: Annotated[
            int | None, Query(description="By default as many as rows, if they fit.")
        ] = None,
        width: Annotated[int, Query(description="Width in pixels, at most 2048.")] = 1140,
        theme: ThemeName = "light",
    ) -> Response:
        """The whole paths of many drops side by side, each with its seed and what it paid."""
        first = parse_seed(seed)
        parse_seed(first + drops - 1)
        many = _Many(server.boards.find(board), drops, first)
        name = f"{many.name}.sheet.{fmt}.{columns}.{width}.{theme}"
        draw = functools.partial(_draw_sheet, many, fmt, width, theme, columns)
        return await picture_reply(request, server, name, draw, MANY[fmt])

    return get_sheet


# Imported when the first picture is asked for: without one, Pillow is never loaded.


def _draw_still(d: Drop, fmt: str, width: int, theme: str, t: float | None) -> bytes:
    from app.render import drop_picture  # noqa: PLC0415

    return drop_picture(d, fmt, width, theme, t)


def _draw_animation(d: Drop, fmt: str, width: int, fps: int, theme: str) -> bytes:
    from app.render import drop_animation  # noqa: PLC0415

    return drop_animation(d, fmt, width, fps, theme)


def _draw_density(many: _Many, fmt: str, width: int, theme: str) -> bytes:
    from app.render import density_picture  # noqa: PLC0415

    patience = _Patience(many.drops)
    return density_picture(many.board, many.seeds, fmt, width, theme, 1, patience)


def _draw_histogram(many: _Many, fmt: str, width: int, theme: str) -> bytes:
    from app.render import histogram_picture  # noqa: PLC0415

    found = tally_of(many.board, many.first, many.drops, Exact()).summary()
    landed, unsettled = found["histogram"], found["unsettled"]
    return histogram_picture(many.board, landed, fmt, width, theme, unsettled)


def _draw_sheet(many: _Many, fmt: str, width: int, theme: str, columns: int | None) -> bytes:
    from app.render import contact_sheet  # noqa: PLC0415

    patience = _Patience(many.drops)
    return contact_sheet(many.board, many.seeds, fmt, width, theme, columns, patience)


density = _of_many(
    "density",
    _draw_density,
    "Where the balls of many drops spend their time, as light on the board.",
)
histogram = _of_many(
    "histogram", _draw_histogram, "How many balls land in each bin, beside what is expected."
)

add_routes(router, "/drops/{board}/{seed}", STILLS, _still, "A drop", "get_drop")
add_routes(router, "/drops/{board}/{seed}", ANIMATIONS, _animation, "A drop's fall", "get_drop")
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
