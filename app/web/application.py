"""The application: all routes as one table and the pages, behind one layer."""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from fastapi import FastAPI
from starlette.applications import Starlette
from starlette.types import ASGIApp, Receive, Scope, Send

from plinko.app.settings import Settings, static_directory
from plinko.app.web import openapi
from plinko.app.web.edge.addresses import one_client
from plinko.app.web.edge.front import Front
from plinko.app.web.problems import respond
from plinko.app.web.routes import api_docs, boards, health, page, payouts
from plinko.app.web.routes.drops import drops, many, pictures
from plinko.app.web.routes.rooms import (
    invitations,
    live,
    moves,
    orders,
    players,
    queues,
    rooms,
    scenes,
    sessions,
    ws,
)
from plinko.app.web.routes.table import RouteTable
from plinko.engine import __version__

_ROUTERS = (
    boards, pictures, drops, many, payouts, live, invitations, rooms, moves, queues, scenes,
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
            description=openapi.DESCRIPTION,
            openapi_tags=openapi.TAGS,
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
        orders = self.state.services.rooms.orders
        if orders.bans:
            orders.check_banned(one_client(address))

    def openapi(self) -> dict[str, object]:
        return openapi.document(self, self._table.routes)
