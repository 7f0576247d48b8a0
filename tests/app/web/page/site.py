"""The pages alone, as a site that a test asks."""

from pathlib import Path
from typing import Any

import httpx
from starlette.applications import Starlette

from plinko.app.web.routes.page import Page

STATIC = Path(__file__).parents[4] / "static"


def site(**options: Any) -> httpx.AsyncClient:
    app = Starlette()
    app.mount("/", Page(STATIC, **options))
    return httpx.AsyncClient(transport=httpx.ASGITransport(app=app), base_url="http://site")
