"""A relay's application: the rooms' WebSockets, its health, and its metrics."""

import asyncio
import contextlib
import gc
import logging
import os
import socket
from collections.abc import AsyncIterator, Iterator

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from plinko.app.errors import AppError
from plinko.app.listening import config_over, listen, print_address, raise_files
from plinko.app.ops import logs
from plinko.app.ops.metrics import Metrics, Reading
from plinko.app.relay.bus import Bus, readings, redis_at
from plinko.app.relay.spectators import Spectators
from plinko.app.settings import Settings, not_settings
from plinko.app.web.edge.addresses import Connections, Proxies
from plinko.app.web.edge.front import Front
from plinko.app.web.problems import problem_response
from plinko.app.web.tokens import check_bearer
from plinko.engine import __version__


def create_relay(settings: Settings, bus: Bus, rooms: str) -> Starlette:
    """The application; raises SettingError if `rooms` is not a server's address."""
    here = Spectators(bus, rooms, settings)
    metrics = Metrics()
    metrics.read_from(lambda: (*_readings(here), *readings(bus)))

    async def watch(client: WebSocket) -> None:
        await here.serve(client, client.path_params["room"])

    async def healthz(_: Request) -> Response:
        return JSONResponse(
            {"status": "ok", "clients": here.hub.total, "rooms": here.replicas, "lines": here.lines}
        )

    async def measured(request: Request) -> Response:
        if settings.metrics_token:
            try:
                asked = request.headers.get("authorization")
                check_bearer(asked, settings.metrics_token, "of the metrics")
            except AppError as error:
                return problem_response(error)
        body, media_type = metrics.exposition(request.headers.get("accept", ""))
        return Response(body, media_type=media_type, headers={"cache-control": "no-store"})

    @contextlib.asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        tasks = [asyncio.create_task(work) for work in (here.tend(), bus.run())]
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    app = Starlette(
        routes=[
            WebSocketRoute("/ws/rooms/{room}", watch),
            Route("/healthz", healthz),
            Route("/metrics", measured),
        ],
        lifespan=lifespan,
    )
    app.add_middleware(Front, settings=settings)
    app.state.spectators = here
    app.state.refused = lambda code: metrics.errors.labels(code).inc()
    return app


def _readings(here: Spectators) -> Iterator[Reading]:
    traffic = here.hub.traffic
    yield "plinko_clients", "Clients connected to rooms.", here.hub.total, {}
    yield "plinko_frames_sent_total", "WebSocket messages sent.", traffic.frames, {}
    yield "plinko_sent_bytes_total", "Bytes of those messages.", traffic.bytes, {}
    text = "Clients closed because they did not read."
    yield "plinko_clients_too_slow_total", text, traffic.too_slow, {}


_log = logging.getLogger("plinko")


class RelayServer(uvicorn.Server):
    """uvicorn's server, which prints its address when it is ready."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, then exempt all long-lived objects from later garbage collections."""
        await super().startup(sockets)
        gc.collect()
        gc.freeze()
        for listener in sockets or ():
            print_address("A relay of Plinko is at", listener)
        _log.info("started", extra={"version": __version__})


def run(settings: Settings, redis: str, rooms: str) -> None:
    """Serve until SIGINT or SIGTERM; raises SettingError if it cannot listen."""
    logs.configure(settings.log_level, settings.log_format)
    for line in not_settings(os.environ):
        _log.warning(line)
    app = create_relay(settings, redis_at(redis), rooms)
    total = raise_files()
    # A relay stands behind a proxy, so all clients connect from the proxy's address. Trust every
    # proxy, and let one address open as many connections as all together.
    connections = Connections(total, Proxies(("0.0.0.0/0", "::/0")), total)
    config = config_over(app, settings, connections, app.state.refused)
    with listen(settings) as listener:
        RelayServer(config).run(sockets=[listener])
