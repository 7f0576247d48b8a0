"""Which kinds of connections serve: the guarded ones, unless uvicorn is not as known.

Then the server speaks HTTP with h11, which bounds heads by itself, or takes as many WebSocket
frames as come, and does without the rest.
"""

import asyncio
import logging
from collections.abc import Callable
from typing import Any, cast

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from uvicorn.server import ServerState

from app.web.edge.addresses import Connections, Proxies
from app.web.edge.connection import Edge, connection
from app.web.edge.guarded import guarded
from app.web.edge.intake import Intake
from app.web.edge.sockets import guarded_socket

_log = logging.getLogger("plinko")


def choose(edge: Edge, socket: type[WebSocketsSansIOProtocol]) -> dict[str, Any]:
    """How uvicorn is to speak HTTP, and WebSocket with `socket`: options of its configuration."""
    options: dict[str, Any] = {"ws": guarded_socket(socket, edge)}
    if (fault := _fault(_sockets_fault)) is not None:
        _log.warning("frames have no limit, since uvicorn's WebSocket is not as known: %s", fault)
        options["ws"] = socket
    if (fault := _fault(_requests_fault)) is None:
        return options | {"http": connection(guarded(edge), edge)}
    _log.warning("requests have no time limits, since uvicorn's parser is not as known: %s", fault)
    options["h11_max_incomplete_event_size"] = edge.head_bytes
    return options | {"http": connection(H11Protocol, edge)}


def self_test() -> str | None:
    """Whether connections refuse what they must and take what they should; None, or what is amiss.

    Tried on connections without a network.
    """
    return _fault(_requests_fault) or _fault(_sockets_fault)


def _fault(trial: Callable[[], str | None]) -> str | None:
    try:
        return trial()
    except Exception as error:  # noqa: BLE001 - whatever has changed inside uvicorn
        return f"{type(error).__name__}: {error}"


def _requests_fault() -> str | None:
    if not _trial(b"GET / HTTP/1.1\r\nhost: x\r\n" + b"a: b\r\n" * 200).startswith(_TOO_LARGE):
        return "a head without end is taken"
    if not _trial(b"nonsense\r\n\r\n").startswith(b"HTTP/1.1 400 "):
        return "nonsense is taken"
    if _trial(b"GET / HTTP/1.1\r\nhost: x\r\n\r\n") != _Loop.STARTED:
        return "a request is not taken"
    return None


def _sockets_fault() -> str | None:
    connection, sink = _upgraded(b"content-length: 1\r\n")
    if not sink.written.startswith(b"HTTP/1.1 400 "):
        return "a handshake with a body is not answered"
    connection, sink = _upgraded(b"")
    connection.handshake_complete = True
    connection.conn.send_response(connection.response)
    connection.data_received(_PING * 100)
    if _FLOOD not in sink.written:
        return "pings are taken without end"
    return None


_TOO_LARGE = b"HTTP/1.1 431 "
_PING = b"\x89\x80\0\0\0\0"
_FLOOD = b"\x03\xf0"  # 1008


class _Loop:
    """An event loop that runs nothing: a request that would be carried out is noted."""

    STARTED = b"started"

    def __init__(self, sink: "_Sink") -> None:
        self._sink = sink

    def time(self) -> float:
        return 0.0

    def call_at(self, when: float, callback: Callable[[], None]) -> asyncio.TimerHandle:
        loop = cast(asyncio.AbstractEventLoop, self)
        return asyncio.TimerHandle(when, callback, (), loop)

    call_later = call_at

    def get_debug(self) -> bool:
        return False

    def create_task(self, running: Any, **options: Any) -> "_Loop":
        running.close()
        self._sink.write(self.STARTED)
        return self

    def add_done_callback(self, callback: Callable[..., None]) -> None:
        """As a task has it."""


class _Sink:
    """A transport that keeps what is written to it."""

    def __init__(self) -> None:
        self.written = b""
        self._closed = False

    def write(self, data: bytes) -> None:
        self.written += data

    def close(self) -> None:
        self._closed = True

    abort = pause_reading = close

    def is_closing(self) -> bool:
        return self._closed

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return default


_EDGE = Edge(
    head_bytes=256,
    head_seconds=1.0,
    body_seconds=1.0,
    unread_seconds=1.0,
    frame_rate=1.0,
    connections=Connections(1, Proxies(())),
    intake=Intake(),
)


def _trial(sent: bytes) -> bytes:
    """What a connection with a limit of 256 bytes answers to these."""
    connection, sink = _made(guarded(_EDGE))
    connection.logger = logging.Logger("trial", logging.CRITICAL)  # what fails here is meant to
    connection.data_received(sent)
    return sink.written


def _upgraded(more: bytes) -> tuple[Any, _Sink]:
    """A WebSocket and what it answered, after a handshake with these headers, too."""
    connection, sink = _made(guarded_socket(WebSocketsSansIOProtocol, _EDGE))
    connection.data_received(
        b"GET / HTTP/1.1\r\nupgrade: websocket\r\nconnection: upgrade\r\nsec-websocket-version: 13"
        b"\r\nsec-websocket-key: AAAAAAAAAAAAAAAAAAAAAA==\r\n" + more + b"\r\n"
    )
    return connection, sink


def _made(kind: type[Any]) -> tuple[Any, _Sink]:
    config = uvicorn.Config(lambda: None, interface="asgi3", log_config=None)
    config.loaded, config.loaded_app = True, None  # it is not going to run anything
    config.ws_protocol_class = None
    sink = _Sink()
    connection = kind(config, ServerState(), {}, _loop=cast(asyncio.AbstractEventLoop, _Loop(sink)))
    connection.connection_made(sink)
    return connection, sink
