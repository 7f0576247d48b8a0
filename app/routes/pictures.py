"""Drops as pictures: stills, moments and animations, one address for each format."""

import functools
from collections.abc import Callable
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from app.pictures import look
from app.routes.asked import Asked
from app.routes.common import Server, cache_headers, documented, is_current, not_modified
from app.services import Services
from engine import Drop

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
    path: str, formats: dict[str, str], endpoint: Callable[[str], Callable[..., object]], title: str
) -> None:
    """One GET route for each format, `path` followed by its name."""
    for fmt, media_type in formats.items():
        router.add_api_route(
            f"{path}.{fmt}",
            endpoint(fmt),
            summary=f"{title} as {fmt.upper()}",
            response_class=Response,
            name=f"{title} {fmt}",
            responses=documented(
                None, 304, 404, 422, 503, description="The picture", media_type=media_type
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


add_routes("/drops/{board}/{seed}", STILLS, _still, "A drop")
add_routes("/drops/{board}/{seed}", ANIMATIONS, _animation, "A drop's fall")


# Imported when the first picture is asked for: without one, Pillow is never loaded.


def _draw_still(d: Drop, fmt: str, width: int, theme: str, t: float | None) -> bytes:
    from app.render import drop_picture  # noqa: PLC0415

    return drop_picture(d, fmt, width, theme, t)


def _draw_animation(d: Drop, fmt: str, width: int, fps: int, theme: str) -> bytes:
    from app.render import drop_animation  # noqa: PLC0415

    return drop_animation(d, fmt, width, fps, theme)
