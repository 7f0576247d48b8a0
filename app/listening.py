"""The listening socket, the limits of connections, and uvicorn configured with both."""

import asyncio
import errno
import gc
import logging
import os
import socket
import threading
from collections.abc import Callable
from typing import Any, cast

import uvicorn
from fastapi import FastAPI
from starlette.types import ASGIApp, Receive, Scope, Send

from plinko.app.errors import LedgerError, SettingError, StartError
from plinko.app.live.broadcast.transport import DirectProtocol
from plinko.app.ops import logs, stalls
from plinko.app.protocol.messages import MESSAGE_BYTES
from plinko.app.settings import Settings
from plinko.app.web.edge.addresses import Connections, Proxies
from plinko.app.web.edge.connection import Edge, connection
from plinko.app.web.edge.guarded import guarded
from plinko.app.web.edge.intake import Intake
from plinko.app.web.edge.sockets import guarded_socket
from plinko.app.web.problems import problem_response
from plinko.app.web.routes.common import reply
from plinko.app.web.routes.health import Readiness, RoomsBack
from plinko.app.web.services import Services

_log = logging.getLogger("plinko")

HEAD_BYTES = 1 << 14  # of a request's line and headers together
HEAD_SECONDS = 10.0  # in which a head must arrive, also that of a WebSocket's handshake
BODY_SECONDS = 30.0  # in which a request's body must arrive after its head
UNREAD_SECONDS = 30.0  # after which a client that does not read its response is cut off
SEND_BUFFER = 1 << 16  # bytes that the kernel buffers for a connection

MAX_CONNECTIONS = 10_000  # open at once, of all addresses; one may have a tenth of those left
_OWN_FILES = 100  # files that the server opens besides connections: ledger, workers, pages
_FRAMES = 2.0  # WebSocket frames allowed for each message: pings, pongs and fragments are few

SHUTDOWN_SECONDS = 3
"""Seconds that open requests have when the server stops. Few requests take longer, clients must
wait for the next server meanwhile, and service managers kill a process only after more than this.
"""

_NEXT_TRIAL = 1.0  # s until a missing database is tried again

_ENDS_WORK = 0.7  # share of SHUTDOWN_SECONDS in which workers may finish


def notify(state: str) -> None:
    """Send `state`, such as READY=1, to systemd (sd_notify); does nothing without it."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if address:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
            # An address that begins with @ is abstract: its first byte is 0.
            sender.sendto(state.encode(), f"\0{address[1:]}" if address[0] == "@" else address)


async def keep_alive() -> None:
    """Tell the watchdog of this process twice in its time that the event loop runs."""
    if os.environ.get("WATCHDOG_PID", "") not in ("", str(os.getpid())):
        return
    seconds = int(os.environ.get("WATCHDOG_USEC", "0")) / 2e6
    while seconds:
        notify("WATCHDOG=1")
        await asyncio.sleep(seconds)


class Server(uvicorn.Server):
    """uvicorn's server, which prints its address when it accepts connections."""

    def __init__(self, services: Services, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.services = services
        self.listening = threading.Event()
        self._watching: list[asyncio.Task[None]] = []

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, then exclude all present objects from garbage collection, which delays ticks."""
        await super().startup(sockets)
        gc.collect()
        gc.freeze()
        for listener in sockets or ():
            print_address("Plinko is at", listener)
        self.listening.set()
        settings, ledger = self.services.settings, self.services.ledger.database.name
        about = {"version": self.services.version, "ledger": ledger, "settings": settings.changed}
        _log.info("started", extra=about)
        self._watching = [
            asyncio.create_task(keep_alive(), name="watchdog"),
            asyncio.create_task(stalls.watch(), name="stalls"),
        ]
        notify("READY=1")

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop in this order: give rooms away, end streams, wait for requests, then cancel work."""
        notify("STOPPING=1")
        server = self.services
        server.rooms.tell_leaving()
        if server.others is not None:
            # First of all, while this server can still forward clients to their rooms.
            await server.others.leave()
        server.computing.cameras.close()  # else their streams never end, and uvicorn waits
        # Cancel work shortly before the grace period ends, in time for a proper error response.
        patience = _ENDS_WORK * SHUTDOWN_SECONDS
        ending = asyncio.get_running_loop().call_later(patience, _end_work, server)
        await super().shutdown(sockets)
        ending.cancel()
        _log.info("stopped")


def _end_work(server: Services) -> None:
    """Release the requests that wait for a worker, or for a ball to land."""
    server.computing.release()
    server.rooms.stop_waiting()


async def _not_yet(scope: Scope, receive: Receive, send: Send) -> None:
    """The application while the ledger's database is missing: alive, but not ready."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1013})
        return
    path = scope["path"]
    if path == "/healthz":
        response = reply({"status": "ok"})
    elif path == "/readyz":
        response = reply(Readiness(False, {"ledger": False}, RoomsBack([]), "unknown"), 503)
    else:
        response = problem_response(LedgerError("the ledger's database does not answer yet"), path)
    await response(scope, receive, send)


def wait_for(missing: Callable[[], str | None], listener: socket.socket) -> None:
    """Return when `missing` returns None; it says why the ledger's database does not answer yet.

    Until then it is called again and again, and every request gets 503. A signal ends the process.
    """
    if missing() is not None:
        asyncio.run(_wait_for(missing, listener))


async def _wait_for(missing: Callable[[], str | None], listener: socket.socket) -> None:
    config = uvicorn.Config(
        _not_yet,
        lifespan="off",
        log_config=None,
        access_log=False,
        server_header=False,
        timeout_keep_alive=1,
        timeout_graceful_shutdown=1,
    )
    server = uvicorn.Server(config)
    serving = asyncio.create_task(server.serve([listener.dup()]))
    said = None
    while (why := await asyncio.to_thread(missing)) and not serving.done():
        if why != said:
            _log.warning("waiting for the ledger", extra={"reason": why})
            notify("STATUS=waiting for the ledger")
            said = why
        await asyncio.wait([serving], timeout=_NEXT_TRIAL)
    server.should_exit = True
    await serving
    notify("STATUS=")


def server_over(app: FastAPI, settings: Settings) -> Server:
    """A uvicorn server with the application and all limits, ready to run."""
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
    """uvicorn's configuration for `app`, with a fast parser and event loop, and no access log.

    `refused` is called with the code of each refusal by the limits in `app/web/edge/`.
    """
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
    return uvicorn.Config(
        app,
        host=settings.host,
        port=settings.port,
        loop="uvloop",
        http=cast(Any, connection(guarded(edge), edge)),
        ws=guarded_socket(DirectProtocol, edge),
        ws_per_message_deflate=False,  # compressing costs five to eight times as much as sending
        ws_max_size=MESSAGE_BYTES,
        access_log=False,
        log_config=None,  # app.ops.logs configures logging
        server_header=False,
        proxy_headers=False,  # `Front` reads them
        timeout_graceful_shutdown=SHUTDOWN_SECONDS,
    )


def raise_files() -> int:
    """Raise the process's limit of open files if needed; return how many connections it allows."""
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
    """A listening socket; raises SettingError if the address is not available."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # Connections inherit the size. It is small because a slow client reads everything in the
        # kernel's buffer before it gets a newer snapshot.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        listener.bind((settings.host, settings.port))
        listener.listen(2048)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        raise (StartError if error.errno == errno.EADDRINUSE else SettingError)(
            f"cannot listen on {settings.host} port {settings.port}: {error.strerror or error}",
            field="port",
        ) from error
    return listener


def print_address(text: str, listener: socket.socket) -> None:
    """Print the address on standard output, where the log is JSON as JSON."""
    address = address_of(listener)
    line = logs.json_line("listening", address=address) if logs.in_json() else f"{text} {address}"
    print(line, flush=True)  # noqa: T201 - programs wait for it


def address_of(listener: socket.socket) -> str:
    """The address to open in a browser; for a wildcard, the loopback address."""
    host, port = listener.getsockname()[:2]
    host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"
