"""A QR code with the address of a room's page, for an audience with phones."""

import asyncio
import io
from urllib.parse import quote

from fastapi import Request, Response

from plinko.app.live.public_tables import MAIN
from plinko.app.web.routes.common import Server, documented
from plinko.app.web.routes.table import operations

router = operations("rooms", "/api/v1/rooms")

SVG = "image/svg+xml"


@router.get(
    "/{room}/qr.svg",
    summary="A room's address as a QR code",
    response_class=Response,
    responses=documented(None, 404, 503, description="The code", media_type=SVG),
)
async def get_room_code(room: str, request: Request, server: Server) -> Response:
    """The address of the room's page, with the host name of this request.

    If the request used a name that only this machine knows, such as `localhost`, phones cannot
    open the address.
    """
    found = await server.rooms.seek(room)
    query = "" if found.id == MAIN else f"?room={quote(found.id)}"
    picture = await asyncio.to_thread(_code, f"{request.base_url}{query}")
    return Response(picture, headers={"cache-control": "no-cache"}, media_type=SVG)


def _code(text: str) -> bytes:
    """An SVG without a fixed size, black on white, with the margin that the standard requires."""
    import segno  # noqa: PLC0415 - loaded only for the first code

    picture = io.BytesIO()
    code = segno.make(text, error="m", micro=False)
    code.save(picture, kind="svg", xmldecl=False, omitsize=True, light="white")
    return picture.getvalue()
