"""Where the server listens: the socket, the connections' limits, and uvicorn over them."""

import asyncio
import gc
import socket
import threading
from collections.abc import Callable
from typing import Any, cast

import uvicorn
from fastapi import FastAPI
from starlette.types import ASGIApp
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from app.errors import SettingError
from app.live.broadcast.transport import DirectProtocol
from app.protocol.messages import MESSAGE_BYTES
from app.settings import Settings
from app.web.edge.addresses import Connections, Proxies
from app.web.edge.connection import Edge, connection
from app.web.edge.ending import Ending
from app.web.edge.guarded import guarded
from app.web.edge.intake import Intake
from app.web.edge.middleware import ForwardedCheck, SecurityHeaders
from app.web.edge.sockets import guarded_socket
from app.web.services import Services

HEAD_BYTES = 1 << 14  # of a request's line and its headers
HEAD_SECONDS = 10.0  # in which a request's head must arrive, a WebSocket's handshake too
BODY_SECONDS = 30.0  # in which a request's body must arrive after its head
UNREAD_SECONDS = 30.0  # after which a client that reads nothing of its answer is cut off
SEND_BUFFER = 1 << 16  # bytes that the kernel holds for a connection

MAX_CONNECTIONS = 10_000  # open at once, of all addresses; one may have a tenth of those left
_OWN_FILES = 100  # that the server opens besides connections: its ledger, workers, the page's
_FRAMES = 2.0  # WebSocket frames of every kind to a message: pings, pongs and fragments are few

SHUTDOWN_SECONDS = 3
"""that open requests have once the server stops. Longer, and clients wait for the next server; what
is computed rarely takes longer. Service managers wait longer than this before they kill."""

_ENDS_WORK = 0.7  # of these, for which what is computed may go on


class Server(uvicorn.Server):
    """uvicorn's server, which says where it is once it can be used."""

    def __init__(self, services: Services, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.services = services
        self.listening = threading.Event()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, then leave what lives for good out of every later garbage collection."""
        await super().startup(sockets)
        gc.collect()
        gc.freeze()
        for listener in sockets or ():
            print(f"Plinko is at {address_of(listener)}", flush=True)  # noqa: T201 - it says where
        self.listening.set()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop; streams have no end of their own and are ended before requests are waited for."""
        server = self.services
        if server.others is not None:
            # Before anything is closed: whoever comes meanwhile is brought to where the room is.
            await server.others.leave()
        server.cameras.close()
        # What is still waited for shortly before the grace ends is ended, and its client told so.
        patience = _ENDS_WORK * SHUTDOWN_SECONDS
        ending = asyncio.get_running_loop().call_later(patience, _end_work, server)
        await super().shutdown(sockets)
        ending.cancel()


def _end_work(server: Services) -> None:
    """Let those go who wait for what is computed, or for a ball to land."""
    server.workers.close()
    server.readers.close()
    server.rooms.stop_waiting()


def server_over(app: FastAPI, settings: Settings) -> Server:
    """uvicorn with the application, ready to run."""
    services: Services = app.state.services
    return Server(services, _config(app, services, settings))


def _config(app: FastAPI, server: Services, settings: Settings) -> uvicorn.Config:
    proxies = Proxies(settings.trusted_proxies)
    connections = Connections(settings.address_connections, proxies, raise_files())

    def refused(code: str) -> None:
        server.metrics.errors.labels(code).inc()

    return config_over(app, settings, connections, refused)


def config_over(
    app: ASGIApp,
    settings: Settings,
    connections: Connections,
    refused: Callable[[str], None],
) -> uvicorn.Config:
    """uvicorn with a fast parser and loop, no compression and no log line a request.

    `refused` hears the code of each refusal by the limits of the edge.
    """
    proxies = Proxies(settings.trusted_proxies)
    edge = Edge(
        head_bytes=HEAD_BYTES,
        head_seconds=HEAD_SECONDS,
        body_seconds=BODY_SECONDS,
        unread_seconds=UNREAD_SECONDS,
        frame_rate=_FRAMES * settings.message_rate,
        connections=connections,
        intake=Intake(),
        refused=refused,
    )
    served: ASGIApp = SecurityHeaders(Ending(app))
    if proxies.names:
        # uvicorn's own types of ASGI, which are Starlette's with every message spelt out
        served = ProxyHeadersMiddleware(cast(Any, served), proxies.names)  # type: ignore[assignment]
    return uvicorn.Config(
        ForwardedCheck(served, proxies),
        host=settings.host,
        port=settings.port,
        loop="uvloop",
        http=cast(Any, connection(guarded(edge), edge)),
        ws=guarded_socket(DirectProtocol, edge),
        ws_per_message_deflate=False,  # costs five to eight times the frame
        ws_max_size=MESSAGE_BYTES,
        access_log=False,
        log_config=None,  # app.ops.logs has it
        server_header=False,
        proxy_headers=False,  # done above, where who forwards is still known
        timeout_graceful_shutdown=SHUTDOWN_SECONDS,
    )


def raise_files() -> int:
    """Connections that there may be, having raised what the system allows as far as it lets us."""
    try:
        import resource  # noqa: PLC0415 - not on every system
    except ImportError:
        return MAX_CONNECTIONS
    wanted, endless = MAX_CONNECTIONS + _OWN_FILES, resource.RLIM_INFINITY
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != endless and soft < wanted:
        soft = wanted if hard == endless else min(wanted, hard)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    files = wanted if soft == endless else min(wanted, soft)
    return max(1, files - _OWN_FILES)


def listen(settings: Settings) -> socket.socket:
    """A listening socket; raises SettingError naming the address that cannot be had."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # Connections inherit it. What the kernel holds for a client is as stale as it is long.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        listener.bind((settings.host, settings.port))
        listener.listen(2048)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        raise SettingError(
            f"cannot listen on {settings.host} port {settings.port}: {error.strerror or error}",
            field="port",
        ) from error
    return listener


def address_of(listener: socket.socket) -> str:
    """The address to open in a browser; the wildcard is this machine too."""
    host, port = listener.getsockname()[:2]
    host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"
