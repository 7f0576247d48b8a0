"""Which kind of connection serves HTTP: the guarded one, unless uvicorn is not as known.

Then the server speaks HTTP with h11, which bounds heads by itself, and does without the rest.
"""

import asyncio
import logging
from collections.abc import Callable
from typing import Any, cast

import uvicorn
from uvicorn.server import ServerState

from app.web.edge.addresses import Connections, Proxies
from app.web.edge.guarded import Edge, guarded

_log = logging.getLogger("plinko")


def counted(kind: type[Any], connections: Connections) -> type[Any]:
    """A kind of WebSocket connection that leaves the count when it ends.

    It entered as the HTTP connection that asked for the upgrade.
    """

    class Counted(kind):  # type: ignore[misc]
        def connection_lost(self, exc: Exception | None) -> None:
            if self.client is not None:
                connections.leave(self.client[0])
            super().connection_lost(exc)

    return Counted


def choose(edge: Edge) -> dict[str, Any]:
    """How uvicorn is to speak HTTP: options of its configuration."""
    fault = self_test()
    if fault is None:
        return {"http": guarded(edge)}
    _log.warning("requests have no time limits, since uvicorn's parser is not as known: %s", fault)
    return {"http": "h11", "h11_max_incomplete_event_size": edge.head_bytes}


def self_test() -> str | None:
    """Whether a connection refuses what it must and takes what it should; None, or what is amiss.

    Tried on a connection without a network.
    """
    try:
        if not _trial(b"GET / HTTP/1.1\r\nhost: x\r\n" + b"a: b\r\n" * 200).startswith(_TOO_LARGE):
            return "a head without end is taken"
        if not _trial(b"nonsense\r\n\r\n").startswith(b"HTTP/1.1 400 "):
            return "nonsense is taken"
        if _trial(b"GET / HTTP/1.1\r\nhost: x\r\n\r\n") != _Loop.STARTED:
            return "a request is not taken"
    except Exception as error:  # noqa: BLE001 - whatever has changed inside uvicorn
        return f"{type(error).__name__}: {error}"
    return None


_TOO_LARGE = b"HTTP/1.1 431 "


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

    def is_closing(self) -> bool:
        return self._closed

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return default


def _trial(sent: bytes) -> bytes:
    """What a connection with a limit of 256 bytes answers to these."""
    config = uvicorn.Config(lambda: None, interface="asgi3", log_config=None)
    config.loaded, config.loaded_app = True, None  # it is not going to run anything
    config.ws_protocol_class = None
    edge = Edge(
        head_bytes=256,
        head_seconds=1.0,
        body_seconds=1.0,
        unread_seconds=1.0,
        connections=Connections(1, Proxies(())),
    )
    sink = _Sink()
    loop = cast(asyncio.AbstractEventLoop, _Loop(sink))
    connection = guarded(edge)(config, ServerState(), {}, _loop=loop)
    connection.logger = logging.Logger("trial", logging.CRITICAL)  # what fails here is meant to
    connection.connection_made(cast(asyncio.Transport, sink))
    connection.data_received(sent)
    return sink.written
