"""Live rooms as pictures: a frame, a stream of frames for any `<img>`, a QR code for phones."""

import asyncio
import functools
import io
from typing import Annotated, Literal
from urllib.parse import quote

from fastapi import Query, Request, Response
from starlette.types import Receive, Scope, Send

from plinko.app.computing import prices
from plinko.app.live.public_tables import MAIN
from plinko.app.pictures.cache import drawing_version
from plinko.app.pictures.film import BOUNDARY, PART_HEAD, Camera, Cameras, Shot
from plinko.app.pictures.frame import draw, moment_of, pixels_of, still_of
from plinko.app.web.routes.common import (
    Server,
    address_of,
    attended,
    documented,
    is_current,
    left,
)
from plinko.app.web.routes.drops.pictures import (
    MEDIA_TYPES,
    STILLS,
    StillFormat,
    ThemeName,
    Width,
    documented_picture,
)
from plinko.app.web.routes.queries import Whole
from plinko.app.web.routes.table import operations

router = operations("rooms", "/api/v1/rooms")

STREAM = f"multipart/x-mixed-replace; boundary={BOUNDARY}"

Fps = Annotated[Whole, Query(ge=1, le=60, description="Frames a second, at most.")]


@router.get(
    "/{room}/frame.{format:picture}",
    summary="A picture of a room",
    response_class=Response,
    responses=documented_picture(*STILLS),
)
async def get_room_frame(
    room: str,
    request: Request,
    server: Server,
    fmt: StillFormat,
    width: Width = 760,
    theme: ThemeName = "light",
) -> Response:
    """A picture of the room as it is now. The ETag changes when something moves."""
    found = await server.rooms.seek(room)
    etag = f"{moment_of(found.room)}.{fmt}.{width}.{theme}.{drawing_version()}"
    headers = {"etag": f'"{etag}"', "cache-control": "no-cache"}
    if is_current(request, etag):
        return Response(status_code=304, headers=headers)
    price = prices.still(pixels_of(found.room, width), 0)
    asked = (still_of(found.room), fmt, width, theme)
    drawing = functools.partial(server.computing.compute, address_of(request), price, draw, *asked)
    picture = await attended(request, server.computing.moments.get(etag, drawing))
    return Response(picture, headers=headers, media_type=MEDIA_TYPES[fmt])


@router.get(
    "/{room}/stream.mjpg",
    summary="A room as a stream of JPEGs",
    response_class=Response,
    responses=documented(None, description="A part for each frame, endless", media_type=STREAM),
)
async def get_room_stream(
    room: str,
    request: Request,
    server: Server,
    width: Width = 760,
    theme: ThemeName = "light",
    fps: Fps = 25,
) -> Response:
    """The room as it moves, for `<img src=…>`. While nothing moves, nothing is sent.

    All viewers of a room with the same size, theme and rate get the same bytes. A slow reader
    gets fewer frames.
    """
    found = await server.rooms.seek(room)
    shot = Shot(found.id, width, theme, fps)
    address = address_of(request)
    camera, seen, part = await server.computing.cameras.open(found.room, shot, address)
    found.wake()
    return _Stream(server.computing.cameras, camera, address, seen, part)


class _Stream(Response):
    """A response that continues until its viewer leaves."""

    def __init__(
        self, cameras: Cameras, camera: Camera, address: str, seen: int, part: bytes
    ) -> None:
        super().__init__(media_type=STREAM, headers={"cache-control": "no-store"})
        del self.headers["content-length"]
        self._cameras = cameras
        self._camera = camera
        self._address = address
        self._seen = seen
        self._part = part

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send frames until the viewer leaves or the camera stops."""
        tasks = [asyncio.create_task(self._send(send)), asyncio.create_task(left(receive))]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._cameras.leave(self._camera, self._address)
            for task in tasks:
                task.cancel()
            ended = await asyncio.gather(*tasks, return_exceptions=True)
        for outcome in ended:
            if isinstance(outcome, Exception):
                raise outcome

    async def _send(self, send: Send) -> None:
        start = {"status": self.status_code, "headers": self.raw_headers}
        await send({"type": "http.response.start", **start})
        part = PART_HEAD + self._part
        while True:
            await send({"type": "http.response.body", "body": part, "more_body": True})
            self._seen, part = await self._camera.newest(self._seen)
            if not part:
                await send({"type": "http.response.body", "body": b"", "more_body": False})
                return


SVG = "image/svg+xml"


@router.get(
    "/{room}/qr.svg",
    summary="A room's address as a QR code",
    response_class=Response,
    responses=documented(None, description="The code", media_type=SVG),
)
async def get_room_code(
    room: str, request: Request, server: Server, page: Literal["table", "pupil"] = "table"
) -> Response:
    """The address of the room's page, or of the page for a class's pupils, with this host's name.

    If the request used a name that only this machine knows, such as `localhost`, phones cannot
    open the address.
    """
    found = await server.rooms.seek(room)
    query = "" if found.id == MAIN else f"?room={quote(found.id)}"
    path = "pupil.html" if page == "pupil" else ""
    picture = await asyncio.to_thread(_code, f"{request.base_url}{path}{query}")
    return Response(picture, headers={"cache-control": "no-cache"}, media_type=SVG)


def _code(text: str) -> bytes:
    """An SVG without a fixed size, black on white, with the margin that the standard requires."""
    import segno  # noqa: PLC0415 - loaded only for the first code

    picture = io.BytesIO()
    code = segno.make(text, error="m", micro=False)
    code.save(picture, kind="svg", xmldecl=False, omitsize=True, light="white")
    return picture.getvalue()
