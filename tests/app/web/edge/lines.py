"""Connections of a server without a network: tests put bytes in and read bytes out.

The test sets the clock, and runs each iteration of the event loop.
"""

import asyncio
import heapq
import json
from collections import Counter
from collections.abc import Callable, Coroutine, Generator
from typing import Any, cast

import uvicorn
from uvicorn.server import ServerState

from plinko.app.live.broadcast.transport import DirectProtocol
from plinko.app.web.edge.addresses import Connections, Proxies
from plinko.app.web.edge.connection import Connection, Edge, connection
from plinko.app.web.edge.guarded import guarded
from plinko.app.web.edge.intake import Intake
from plinko.app.web.edge.sockets import guarded_socket

_LOOPS: list["Loop"] = []


def finish() -> None:
    """Close all connections of all servers, and let their waiting requests end."""
    while _LOOPS:
        loop = _LOOPS.pop()
        for line in loop.lines:
            if not line.lost:
                line.lose()
        while loop.waiting:
            loop.go_on()


class Loop:
    """An event loop whose clock and iterations the test controls."""

    def __init__(self) -> None:
        self.now = 0.0
        self.timers: list[tuple[float, int, asyncio.TimerHandle]] = []
        self.count = 0
        self.soon: list[Callable[[], None]] = []
        self.ready: list[Coroutine[Any, Any, None]] = []
        self.waiting: list[Coroutine[Any, Any, None]] = []
        self.lines: list[Line] = []
        _LOOPS.append(self)

    def time(self) -> float:
        return self.now

    def call_soon(self, callback: Callable[[], None]) -> None:
        self.soon.append(callback)

    def call_at(self, when: float, callback: Callable[[], None]) -> asyncio.TimerHandle:
        handle = asyncio.TimerHandle(when, callback, (), cast(asyncio.AbstractEventLoop, self))
        self.count += 1
        heapq.heappush(self.timers, (when, self.count, handle))
        return handle

    def call_later(self, delay: float, callback: Callable[[], None]) -> asyncio.TimerHandle:
        return self.call_at(self.now + delay, callback)

    def get_debug(self) -> bool:
        return False

    def _timer_handle_cancelled(self, handle: asyncio.TimerHandle) -> None:
        pass

    def call_exception_handler(self, context: dict[str, Any]) -> None:
        raise context["exception"]

    def create_task(self, running: Coroutine[Any, Any, None], **_: Any) -> Any:
        """Keep a request for the next iteration."""
        self.ready.append(running)
        return self

    def add_done_callback(self, callback: Callable[..., None]) -> None:
        """Part of a task's interface; uvicorn counts its tasks with it."""

    def turn(self) -> bool:
        """Run one iteration: callbacks, tasks, arrived bytes; returns whether there were any."""
        soon, self.soon = self.soon, []
        for callback in soon:
            callback()
        ready, self.ready = self.ready, []
        for running in ready:
            try:
                running.send(None)
            except StopIteration:
                continue
            self.waiting.append(running)
        arrived = [line for line in self.lines if line.deliver()]
        return bool(soon or ready or arrived)

    def run(self) -> None:
        """Run iterations until there is nothing to do."""
        while self.turn():
            pass

    def go_on(self) -> None:
        """Continue the waiting requests, and run."""
        self.ready, self.waiting = self.ready + self.waiting, []
        self.run()

    def pass_(self, seconds: float) -> None:
        """Advance the clock, and run the timers that become due."""
        end = self.now + seconds
        while self.timers and self.timers[0][0] <= end:
            self.now, _, handle = heapq.heappop(self.timers)
            if not handle.cancelled():
                handle._run()
        self.now = end


class Waiting:
    """An awaitable that suspends a request until `go_on`."""

    def __await__(self) -> Generator[None, None, None]:
        yield


class Line:
    """The transport of one connection: bytes from the client, bytes written to it."""

    def __init__(self, host: str) -> None:
        self.host = host
        self.connection: Connection
        self.arriving = b""
        self.written = b""
        self.unread = 0
        self.reading = True
        self.closed = self.aborted = self.lost = False

    def deliver(self) -> bool:
        """Give arrived bytes to the protocol in up to 32 pieces, as libuv does; whether any."""
        some = False
        for _ in range(32):
            if self.arriving and self.reading and not self.closed:
                some = True
                buffer = self.connection.get_buffer(1 << 18)
                size = min(len(self.arriving), len(buffer))
                buffer[:size], self.arriving = self.arriving[:size], self.arriving[size:]
                self.connection.buffer_updated(size)
        return some

    def lose(self) -> None:
        """Lose the connection, as when the client has left."""
        self.lost = self.closed = True
        self.connection.connection_lost(None)

    def write(self, data: bytes) -> None:
        assert not self.lost, "the connection is gone"
        self.written += data

    def close(self) -> None:
        self.closed = True

    def abort(self) -> None:
        self.closed = self.aborted = True

    def is_closing(self) -> bool:
        return self.closed

    def get_write_buffer_size(self) -> int:
        return self.unread

    def set_write_buffer_limits(self, high: int | None = None) -> None:
        pass

    def pause_reading(self) -> None:
        assert self.reading, "it is paused already"
        self.reading = False

    def resume_reading(self) -> None:
        assert not self.reading, "it is not paused"
        self.reading = True

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return (self.host, 1234) if name == "peername" else default


class Server:
    """One server's connections; it answers /slow only after `go_on`, and accepts WebSockets."""

    def __init__(self, most: int = 100, **limits: Any) -> None:
        self.loop = Loop()
        self.refused: Counter[str] = Counter()
        self.taken: list[str] = []
        self.messages: list[Any] = []
        self.connections = Connections(most, Proxies(()))
        self.edge = Edge(
            **{"head_bytes": 1024, "head_seconds": 10.0, "body_seconds": 30.0,
               "unread_seconds": 20.0, "frame_rate": 120.0, **limits},
            connections=self.connections,
            intake=Intake(self.loop.call_soon),
            refused=lambda code: self.refused.update([code]),
        )  # fmt: skip
        self.config = uvicorn.Config(
            lambda: None, interface="asgi3", log_config=None, ws_ping_interval=None
        )
        self.config.loaded, self.config.loaded_app = True, self.app
        self.config.ws_protocol_class = self.socket  # type: ignore[assignment]
        self.state = ServerState()

    def socket(self, **options: Any) -> Any:
        return guarded_socket(DirectProtocol, self.edge)(**options, _loop=self.loop)

    async def app(self, scope: Any, receive: Any, send: Any) -> None:
        self.taken.append(scope["path"])
        if scope["path"] == "/slow":
            await Waiting()
        if scope["type"] == "websocket":
            await send({"type": "websocket.accept"})
            await Waiting()
            return
        headers = [(b"content-length", b"2")]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": b"ok"})

    def feed(self, line: Line, data: bytes) -> None:
        """Receive these bytes, and run until everything is done."""
        line.arriving += data
        self.loop.run()

    def dial(self, host: str = "192.0.2.7") -> Line:
        line = Line(host)
        made = connection(guarded(self.edge), self.edge)
        line.connection = made(
            config=self.config, server_state=self.state, app_state={}, _loop=self.loop
        )
        self.loop.lines.append(line)
        line.connection.connection_made(cast(asyncio.Transport, line))
        return line

    def stop(self) -> None:
        """Shut down all connections, as uvicorn's server does."""
        for each in list(self.state.connections):
            each.shutdown()


def dialled(**limits: Any) -> tuple[Server, Line]:
    """A new server, and a connection to it."""
    server = Server(**limits)
    return server, server.dial()


def problem(line: Line) -> dict[str, Any]:
    """The problem in the response; the response must close the connection."""
    assert line.closed
    head, _, body = line.written.partition(b"\r\n\r\n")
    assert b"\r\nconnection: close" in head
    assert b"\r\ncontent-security-policy: " in head
    found: dict[str, Any] = json.loads(body)
    assert head.startswith(b"HTTP/1.1 %d " % found["status"])
    return found
