"""`/docs`: the HTTP interface to read and to try out, by Swagger UI, served from the package."""

import importlib.resources
from typing import Final

from fastapi import APIRouter, Response

from app.errors import NotFoundError

router = APIRouter(include_in_schema=False)

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
"""Files of the package `fastapi-swagger`, of which nothing else is used."""

_HEADERS: Final = {"cache-control": "public, max-age=86400"}


@router.get("/docs")
async def docs() -> Response:
    """The page."""
    return Response(_PAGE, media_type="text/html")


@router.get("/docs/start.js")
async def start() -> Response:
    """What starts it: the security policy allows no script within the page."""
    return Response(_START, headers=_HEADERS, media_type="text/javascript")


@router.get("/docs/{name}")
def part(name: str) -> Response:
    """A file of Swagger UI. FastAPI reads it on another thread."""
    if name not in _PARTS:
        raise NotFoundError(f"the docs have no file {name!r}", field="name")
    file = importlib.resources.files("fastapi_swagger") / "resources" / name
    return Response(file.read_bytes(), headers=_HEADERS, media_type=_PARTS[name])
