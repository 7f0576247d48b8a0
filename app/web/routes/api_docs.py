"""The OpenAPI document, and `/docs`: Swagger UI, served from an installed package."""

import asyncio
import importlib.resources
from typing import Final

import msgspec
from fastapi import Request, Response

from plinko.app.errors import NotFoundError
from plinko.app.web.routes.table import unlisted

router = unlisted(include_in_schema=False)

_PAGE: Final = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Plinko: the HTTP interface</title>
<link rel="stylesheet" href="/docs/swagger-ui.css">
<link rel="icon" href="data:,">
</head>
<body>
<div id="interface"></div>
<script src="/docs/swagger-ui-bundle.js"></script>
<script src="/docs/start.js"></script>
</body>
</html>
"""

_START: Final = """\
SwaggerUIBundle({
  url: "/openapi.json",
  dom_id: "#interface",
  deepLinking: true,
  validatorUrl: null,
  presets: [SwaggerUIBundle.presets.apis],
});
"""

_PARTS: Final = {"swagger-ui.css": "text/css", "swagger-ui-bundle.js": "text/javascript"}
"""The only files that the server uses of the package `fastapi-swagger`."""

_HEADERS: Final = {"cache-control": "public, max-age=86400"}


@router.get("/openapi.json")
async def openapi(request: Request) -> Response:
    """Encoded once, on a thread: that takes longer than ten ticks."""
    state = request.app.state
    if state.document is None:
        state.document = await asyncio.to_thread(lambda: msgspec.json.encode(request.app.openapi()))
    return Response(state.document, media_type="application/json")


@router.get("/docs")
async def docs() -> Response:
    return Response(_PAGE, media_type="text/html")


@router.get("/docs/start.js")
async def start() -> Response:
    """The script that starts Swagger UI; the security policy forbids inline scripts."""
    return Response(_START, headers=_HEADERS, media_type="text/javascript")


@router.get("/docs/{name}")
def part(name: str) -> Response:
    """A file of Swagger UI. Not async, so that FastAPI reads the file on another thread."""
    if name not in _PARTS:
        raise NotFoundError(f"/docs has no file {name!r}", field="name")
    file = importlib.resources.files("fastapi_swagger") / "resources" / name
    return Response(file.read_bytes(), headers=_HEADERS, media_type=_PARTS[name])
