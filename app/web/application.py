"""The application: all routes as one table and the pages, behind one layer."""

from collections.abc import Callable, Sequence
from contextlib import AbstractAsyncContextManager
from typing import Any, Final

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from starlette.applications import Starlette
from starlette.routing import BaseRoute
from starlette.types import ASGIApp, Receive, Scope, Send

from plinko.app.settings import Settings, static_directory
from plinko.app.web.edge.addresses import one_client
from plinko.app.web.edge.front import Front
from plinko.app.web.problems import respond
from plinko.app.web.routes import api_docs, boards, health, page, payouts
from plinko.app.web.routes.common import components, documented_failures
from plinko.app.web.routes.drops import drops, pictures
from plinko.app.web.routes.rooms import (
    live,
    orders,
    players,
    queues,
    rooms,
    scenes,
    sessions,
    shows,
    ws,
)
from plinko.app.web.routes.table import RouteTable
from plinko.engine import __version__
from plinko.engine.json_text import JsonObject

_ROUTERS = (
    boards, pictures, drops, payouts, live, rooms, queues, scenes, shows,
    sessions, players, orders, health, api_docs, ws,
)  # fmt: skip


class Application(FastAPI):
    """FastAPI without its own layers; `surround` adds one around the routes.

    `Front` does the work of FastAPI's layers and of Starlette's, in one.
    """

    def __init__(
        self,
        settings: Settings,
        lifespan: Callable[[FastAPI], AbstractAsyncContextManager[None]],
        surround: Callable[[ASGIApp], ASGIApp] = lambda app: app,
    ) -> None:
        super().__init__(
            title="Plinko",
            version=__version__,
            summary="Seeded drops, replayable bit for bit",
            description=_DESCRIPTION,
            openapi_tags=_TAGS,
            # FastAPI's docs pages load their code from another site, which the content security
            # policy forbids; `api_docs` replaces them.
            docs_url=None,
            redoc_url=None,
            openapi_url=None,
            lifespan=lifespan,
        )
        self._settings = settings
        self._surround = surround
        routes = (route for each in _ROUTERS for route in each.router.routes)
        self._table = RouteTable(routes, settings.root_path, self.router)
        self.routes.append(self._table)
        self.state.document = None
        self.state.page = page.Page(static_directory())
        self.mount("/", self.state.page, name="page")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        await Starlette.__call__(self, scope, receive, send)  # without FastAPI's telemetry

    def build_middleware_stack(self) -> ASGIApp:
        return Front(self._surround(self._table), self._settings, respond, self._check_banned)

    def _check_banned(self, address: str) -> None:
        self.state.services.rooms.orders.check_banned(one_client(address))

    def openapi(self) -> dict[str, object]:
        return _document(self, self._table.routes)


_DESCRIPTION: Final = """\
A Plinko board with exact physics. The same board and seed give the same path, to the last bit,
here, in a live room, on the command line and on any other machine. Equal `digest`s prove it.

Lengths are in metres (x right, y down), times in seconds, angles in radians. Seeds are integers
0 <= seed < 2^64, written as decimal strings because JSON readers round large numbers. Errors are
RFC 9457 problem details whose `detail` names the bad value. Live play uses the WebSocket
`/ws/rooms/{id}`.
"""

_TAGS: Final = [
    {"name": "boards", "description": "Boards by name or by content."},
    {"name": "drops", "description": "Drops outside of rooms: computed, replayed, verified."},
    {"name": "pictures", "description": "Pictures of drops, and of the results of many drops."},
    {"name": "rooms", "description": "Live rooms that any number of people can watch."},
    {"name": "sessions", "description": "Fair sessions: staked drops that nobody can choose."},
    {"name": "health", "description": "For the server's operator."},
]


_LIMITED: Final = {
    "Retry-After": "Seconds to wait before the next try.",
    "RateLimit-Policy": "The limit: `q` at once, all of it again after `w` seconds.",
    "RateLimit": "What is left of the limit: `r` now, all of it in `t` seconds.",
}
"""Headers of a response that refuses a request because of a limit."""


def _failures(path: str, operation: JsonObject) -> dict[str, Any]:
    """The responses that follow from an operation's form: its path, body, parameters, token."""
    codes = [429, 503] if path.startswith("/api/") else [429]
    codes += [404] * ("{" in path) + [422] * ("parameters" in operation)
    codes += [400, 404, 413, 415, 422] * ("requestBody" in operation)
    codes += [401, 403] * ("security" in operation)
    found = {str(code): each for code, each in documented_failures(*codes).items()}
    text = {"schema": {"type": "string"}}
    headers = {name: {"description": what, **text} for name, what in _LIMITED.items()}
    found["429"]["headers"] = headers
    return found


def _document(app: FastAPI, routes: Sequence[BaseRoute]) -> dict[str, object]:
    """The OpenAPI document, made once."""
    if app.openapi_schema is None:
        made = get_openapi(
            title=app.title,
            version=app.version,
            summary=app.summary,
            description=app.description,
            tags=app.openapi_tags,
            routes=routes,
            servers=[{"url": app.state.services.settings.root_path or "/"}],
        )
        made.setdefault("components", {})["schemas"] = components()
        for path, operations in made["paths"].items():
            for operation in operations.values():
                # This server's 422 is a problem document, not the framework's own shape.
                responses = _failures(path, operation)
                for code, own in operation["responses"].items():
                    if "HTTPValidationError" not in str(own):
                        responses[code] = own
                operation["responses"] = responses
        app.openapi_schema = made
    return app.openapi_schema
