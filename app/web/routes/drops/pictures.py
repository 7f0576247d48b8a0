"""Pictures of drops: stills, animations, and pictures of many drops."""

import functools
import re
from collections.abc import Callable, Coroutine
from typing import Annotated, Final, Literal, TypeVarTuple

from fastapi import Depends, Path, Query, Request, Response
from starlette.convertors import StringConvertor, register_url_convertor

from plinko.app.computing import prices, tasks
from plinko.app.computing.prices import Price
from plinko.app.computing.tasks import Ask, Many
from plinko.app.errors import InvalidValueError, RangeError
from plinko.app.pictures.cache import drawing_version
from plinko.app.render.parts.view import LEAST_WIDTH, MOST_WIDTH, lay_out
from plinko.app.web.computing import Computing
from plinko.app.web.problems import problem_response
from plinko.app.web.routes.common import (
    Responses,
    Server,
    address_of,
    attended,
    cache_headers,
    check_count,
    documented_failures,
    is_current,
    not_modified,
    services,
)
from plinko.app.web.routes.drops.drops import Asked
from plinko.app.web.routes.queries import Number, Whole
from plinko.app.web.routes.table import operations
from plinko.app.web.services import Services
from plinko.engine import PHYSICS_VERSION, Board
from plinko.engine.errors import shorten
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
    Query(
        description="Seconds after the start: show this moment instead of the whole drop. Only for "
        "png and jpg."
    ),
]
Fps = Annotated[
    Whole | None,
    Query(ge=1, le=MOST_FPS, description="Frames a second, not for png and jpg. Default: 30."),
]

MEDIA_TYPES: Final = {
    "png": "image/png",
    "jpg": "image/jpeg",
    "gif": "image/gif",
    "webp": "image/webp",
    "apng": "image/apng",
    "mp4": "video/mp4",
}
STILLS: Final = ("png", "jpg")
"""Formats of a drop's stills; the others are animations."""


class _Format(StringConvertor):
    """Matches the formats only: what follows another dot belongs to the seed."""

    regex = "|".join(MEDIA_TYPES)


register_url_convertor("picture", _Format())

_FORMAT = Path(alias="format")
StillFormat = Annotated[Literal["png", "jpg"], _FORMAT]
ManyFormat = Annotated[Literal["png", "jpg", "webp"], _FORMAT]
DropFormat = Annotated[Literal["png", "jpg", "gif", "webp", "apng", "mp4"], _FORMAT]

DEFAULT_DROPS = 10_000
_MOST_SHEET = 1 << 23  # pixels, about, of the largest sheet of drops


def documented_picture(*formats: str, failures: tuple[int, ...] = ()) -> Responses:
    """OpenAPI's `responses` of a picture in these formats; `failures` beyond the usual ones."""
    schema = {"schema": {"type": "string", "format": "binary"}}
    content = {MEDIA_TYPES[each]: schema for each in formats}
    return {
        200: {"description": "The picture", "content": content},
        206: {"description": "A part", "content": content},
        **documented_failures(304, 416, *failures),
    }


async def picture_reply(
    request: Request,
    name: str,
    fmt: str,
    price: Price,
    task: Callable[[*Ts], bytes],
    *values: *Ts,
) -> Response:
    """The picture called `name`, a part of it, or 304; `task(*values)` draws it if needed.

    `name` must contain everything that decides the picture, except its format and the drawing code,
    which are added here. Raises the errors of `Computing.compute`.
    """
    compute = services(request).computing.compute
    draw = functools.partial(compute, address_of(request), price, task, *values)
    return await _reply(request, name, fmt, draw)


async def _reply(
    request: Request, name: str, fmt: str, draw: Callable[[], Coroutine[None, None, bytes]]
) -> Response:
    etag = f"{name}.{fmt}.{drawing_version()}"
    if is_current(request, etag):
        return not_modified(etag)
    picture = await attended(request, services(request).computing.pictures.get(etag, draw))
    return in_part(request, picture, cache_headers(etag), MEDIA_TYPES[fmt])


def pixels_of(board: Board, width: int) -> int:
    view = lay_out(board, width)
    return view.width * view.height


@router.get(
    "/drops/{board}/{seed}.{format:picture}",
    summary="A picture of a drop, or of its fall",
    response_class=Response,
    responses=documented_picture(*MEDIA_TYPES, failures=(501,)),
)
async def get_drop_picture(
    request: Request,
    ask: Asked,
    fmt: DropFormat,
    width: Width = 760,
    theme: ThemeName = "light",
    t: Moment = None,
    fps: Fps = None,
) -> Response:
    """As png or jpg, the ball's whole path with contacts and end, or one moment of it.

    In the other formats, the ball as it falls, at real speed, then the whole drop for two seconds.
    """
    if fmt in STILLS:
        _refuse("fps", fps, fmt)
        price = prices.still(pixels_of(ask.board, width))
        name = f"{ask.name}.{width}.{theme}.{t!r}"
        return await picture_reply(
            request, name, fmt, price, tasks.still, ask, fmt, width, theme, t
        )
    _refuse("t", t, fmt)
    film = (ask, fmt, width, 30 if fps is None else fps, theme)
    name = ".".join(map(str, (ask.name, *film[2:])))
    animate = functools.partial(_animation, services(request).computing, address_of(request), *film)
    return await _reply(request, name, fmt, animate)


def _refuse(name: str, value: object, fmt: str) -> None:
    if value is not None:
        raise InvalidValueError(f"{name} {value!r} has no meaning for {fmt}", field=name)


async def _animation(
    computing: Computing, address: str, ask: Ask, fmt: str, width: int, fps: int, theme: str
) -> bytes:
    """Draw an animation; count its frames first, because the price depends on them."""
    price = prices.one_drop(ask.board, ask.solver)
    frames = await computing.compute(address, price, tasks.frame_count, ask, fmt, fps)
    price = prices.animation(pixels_of(ask.board, width), frames)
    return await computing.compute(address, price, tasks.animation, ask, fmt, width, fps, theme)


async def _many(
    board: str,
    server: Server,
    drops: Annotated[Whole | None, Query(description="How many; at most 10,000.")] = None,
    seed: Annotated[str, Query(description="Of the first drop; each next one adds 1.")] = "0",
) -> Many:
    """The drops of a request; raises the errors of unknown boards and invalid values."""
    count = min(DEFAULT_DROPS, prices.MAX_DROPS) if drops is None else drops
    check_count(count, "plinko render")
    return _drops(server, board, count, seed)


def _drops(server: Services, board: str, count: int, seed: str) -> Many:
    first = parse_seed(seed)
    parse_seed(first + count - 1)
    return Many(server.boards.find(board), count, first)


ManyAsked = Annotated[Many, Depends(_many)]


@router.get(
    "/boards/{board}/density.{format:picture}",
    summary="The density of many drops",
    response_class=Response,
    responses=documented_picture("png", "jpg", "webp"),
)
async def get_density(
    request: Request,
    many: ManyAsked,
    fmt: ManyFormat,
    width: Width = 760,
    theme: ThemeName = "light",
) -> Response:
    """How much time the balls of many drops spend at each place, as light on the board."""
    return await _picture_of_many(request, "density", tasks.density, many, fmt, width, theme)


@router.get(
    "/boards/{board}/histogram.{format:picture}",
    summary="The histogram of many drops",
    response_class=Response,
    responses=documented_picture("png", "jpg", "webp"),
)
async def get_histogram(
    request: Request,
    many: ManyAsked,
    fmt: ManyFormat,
    width: Width = 760,
    theme: ThemeName = "light",
) -> Response:
    """How many balls land in each bin, next to the expected numbers."""
    return await _picture_of_many(request, "histogram", tasks.histogram, many, fmt, width, theme)


async def _picture_of_many(
    request: Request,
    what: str,
    draw: Callable[[Many, str, int, str], bytes],
    many: Many,
    fmt: str,
    width: int,
    theme: str,
) -> Response:
    prices.many_drops(many.board, many.drops, Exact()).check()
    price = prices.still(pixels_of(many.board, width), many.drops)
    name = f"{_name_of(many)}.{what}.{width}.{theme}"
    return await picture_reply(request, name, fmt, price, draw, many, fmt, width, theme)


@router.get(
    "/boards/{board}/sheet.{format:picture}",
    summary="Many drops side by side",
    response_class=Response,
    responses=documented_picture("png", "jpg", "webp"),
)
async def get_sheet(
    board: str,
    request: Request,
    server: Server,
    fmt: ManyFormat,
    drops: Annotated[Whole, Query(ge=1, le=256, description="How many.")] = 25,
    seed: Annotated[str, Query(description="Of the first drop; each next one adds 1.")] = "0",
    columns: Annotated[
        Whole | None, Query(description="Default: as many as rows, if they fit.")
    ] = None,
    width: Annotated[Whole, Query(ge=1, le=MOST_WIDTH, description="Width in pixels.")] = 1140,
    theme: ThemeName = "light",
) -> Response:
    """The whole paths of many drops side by side, each with its seed and its result."""
    many = _drops(server, board, drops, seed)
    name = f"{_name_of(many)}.sheet.{columns}.{width}.{theme}"
    price = prices.still(_MOST_SHEET, drops)
    asked = (many, fmt, width, theme, columns)
    return await picture_reply(request, name, fmt, price, tasks.sheet, *asked)


def _name_of(many: Many) -> str:
    """A name with everything that decides these drops."""
    return f"{many.board.digest}.{PHYSICS_VERSION}.{many.drops}.{many.first}"


_RANGE: Final = re.compile(r"bytes\s*=\s*(\d*)-(\d*)", re.ASCII | re.IGNORECASE)
_DIGITS: Final = 18  # more than any size has


def in_part(request: Request, body: bytes, headers: dict[str, str], media_type: str) -> Response:
    """The whole body, or the part that the request asks for: 206, or 416 if it has no such part.

    `headers` include the ETag. The body is sent whole if several parts are asked for, if Range is
    malformed, or if the client has a part of another version (If-Range).
    """
    headers = {**headers, "accept-ranges": "bytes"}
    known = request.headers.get("if-range", headers["etag"])
    part = _part(request.headers.get("range", ""), len(body)) if known == headers["etag"] else None
    if part is None:
        return Response(body, headers=headers, media_type=media_type)
    if not part:
        error = RangeError(
            f"range {shorten(request.headers['range'], 60)}: there are {len(body)} bytes, 0 to "
            f"{len(body) - 1}",
            field="range",
        )
        response = problem_response(error, request.url.path)
        response.headers["content-range"] = f"bytes */{len(body)}"
        return response
    headers["content-range"] = f"bytes {part[0]}-{part[-1]}/{len(body)}"
    return Response(body[part.start : part.stop], 206, headers, media_type)


def _part(header: str, size: int) -> range | None:
    """The places of the bytes that the header names, of `size`; None if it names no single part."""
    match = _RANGE.fullmatch(header.strip())
    if match is None:
        return None
    begin, end = (int(text[:_DIGITS]) if text else None for text in match.groups())
    if begin is not None:
        if end is not None and end < begin:
            return None
        return range(begin, size if end is None else min(end + 1, size))
    return None if end is None else range(max(0, size - end), size)
