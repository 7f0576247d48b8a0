"""Connections whose clients send without end, slowly, nothing, or do not read: a clock of our own.

Bytes go into uvicorn's connection with our limits and come out of it, with no network in between.
"""

import asyncio
import heapq
import json
from collections import Counter
from collections.abc import Callable, Coroutine, Generator
from typing import Any, cast

import pytest
import uvicorn
from uvicorn.server import ServerState

from app.web.edge import choose
from app.web.edge.addresses import Connections, Proxies
from app.web.edge.guarded import Edge, GuardedProtocol, guarded

HEAD = b"GET /there HTTP/1.1\r\nHost: localhost\r\n"
POST = b"POST /slow HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\n"


class Loop:
    """An event loop with a clock that is set, and tasks that run when they can."""

    def __init__(self) -> None:
        self.now = 0.0
        self.timers: list[tuple[float, int, asyncio.TimerHandle]] = []
        self.count = 0
        self.ready: list[Coroutine[Any, Any, None]] = []
        self.waiting: list[Coroutine[Any, Any, None]] = []

    def time(self) -> float:
        return self.now

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
        """Keep a request until `run`."""
        self.ready.append(running)
        return self

    def add_done_callback(self, callback: Callable[..., None]) -> None:
        """As a task has it; nobody here counts them."""

    def run(self) -> None:
        """Run the requests that have come, as far as they go without waiting."""
        while self.ready:
            running = self.ready.pop(0)
            try:
                running.send(None)
            except StopIteration:
                continue
            self.waiting.append(running)

    def pass_(self, seconds: float) -> None:
        """Let so much time pass, and whatever is due in it happen."""
        end = self.now + seconds
        while self.timers and self.timers[0][0] <= end:
            self.now, _, handle = heapq.heappop(self.timers)
            if not handle.cancelled():
                handle._run()
        self.now = end


class Never:
    """What is waited for in vain."""

    def __await__(self) -> Generator[None, None, None]:
        yield


class Line:
    """A transport to a client that reads when it is told to."""

    def __init__(self, host: str) -> None:
        self.host = host
        self.written = b""
        self.unread = 0
        self.closed = self.aborted = False

    def write(self, data: bytes) -> None:
        self.written += data

    def close(self) -> None:
        self.closed = True

    def abort(self) -> None:
        self.closed = self.aborted = True

    def is_closing(self) -> bool:
        return self.closed

    def get_write_buffer_size(self) -> int:
        return self.unread

    def pause_reading(self) -> None:
        pass

    resume_reading = pause_reading

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return (self.host, 1234) if name == "peername" else default


class Server:
    """Connections of one server, which answers all requests but those for /slow."""

    def __init__(self, most: int = 100, **limits: Any) -> None:
        self.loop = Loop()
        self.refused: Counter[str] = Counter()
        self.taken: list[str] = []
        self.connections = Connections(most, Proxies(()))
        edge = Edge(
            **{"head_bytes": 1024, "head_seconds": 10.0, "body_seconds": 30.0,
               "unread_seconds": 20.0, **limits},
            connections=self.connections,
            refused=lambda code: self.refused.update([code]),
        )  # fmt: skip
        self.kind = guarded(edge)
        self.config = uvicorn.Config(lambda: None, interface="asgi3", log_config=None)
        self.config.loaded, self.config.loaded_app = True, self.app
        self.config.ws_protocol_class = None

    async def app(self, scope: Any, receive: Any, send: Any) -> None:
        self.taken.append(scope["path"])
        if scope["path"] == "/slow":
            await Never()
        headers = [(b"content-length", b"2")]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": b"ok"})

    def feed(self, connection: GuardedProtocol, data: bytes) -> None:
        """Let these bytes come, and requests that they complete be answered."""
        connection.data_received(data)
        self.loop.run()

    def dial(self, host: str = "192.0.2.7") -> tuple[GuardedProtocol, Line]:
        line = Line(host)
        loop = cast(asyncio.AbstractEventLoop, self.loop)
        connection = self.kind(self.config, ServerState(), {}, _loop=loop)
        connection.connection_made(cast(asyncio.Transport, line))
        return connection, line


def problem(line: Line) -> dict[str, Any]:
    """What the client was told; the connection must end with it."""
    assert line.closed
    head, _, body = line.written.partition(b"\r\n\r\n")
    assert b"\r\nconnection: close" in head
    found: dict[str, Any] = json.loads(body)
    assert head.startswith(b"HTTP/1.1 %d " % found["status"])
    return found


def test_a_request_is_carried_out() -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, HEAD + b"\r\n")
    assert server.taken == ["/there"]
    assert not line.closed


@pytest.mark.parametrize("pad", [b"a: b\r\n", b"a: " + b"b" * 500 + b"\r\n", b"a" * 64])
def test_a_head_without_end_is_refused_once_it_is_over_the_limit(pad: bytes) -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, HEAD)
    sent = 0
    while not line.closed:
        server.feed(connection, pad)
        sent += len(pad)
    assert sent <= 1024 + len(pad)
    found = problem(line)
    assert (found["status"], found["code"]) == (431, "head-too-large")
    assert "1024 bytes" in found["detail"]
    assert server.refused == {"head-too-large": 1}
    assert server.taken == []


@pytest.mark.parametrize("over", [b"a: " + b"b" * 2000 + b"\r\n", b"a: b\r\n" * 101])
def test_a_head_that_comes_at_once_is_bounded_too(over: bytes) -> None:
    server = Server(head_bytes=1900)
    connection, line = server.dial()
    server.feed(connection, HEAD + over + b"\r\n")
    assert problem(line)["status"] == 431
    assert server.taken == []


def test_a_long_line_counts_as_head() -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, b"GET /" + b"a" * 1100 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n")
    assert problem(line)["status"] == 431


def test_a_body_is_no_head_however_long() -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, POST.replace(b"10", b"5000"))
    for _ in range(5):
        server.feed(connection, b"x" * 1000)
    assert not line.closed
    assert server.taken == ["/slow"]


def test_who_says_nothing_is_gone_after_the_time_for_a_head_and_told_nothing() -> None:
    server = Server()
    _, line = server.dial()
    server.loop.pass_(9.9)
    assert not line.closed
    server.loop.pass_(0.2)
    assert (line.closed, line.written) == (True, b"")


def test_a_head_that_comes_byte_by_byte_is_given_up_in_time() -> None:
    server = Server()
    connection, line = server.dial()
    for byte in HEAD[:20]:
        server.feed(connection, bytes([byte]))
        server.loop.pass_(0.6)
    found = problem(line)
    assert (found["status"], found["code"]) == (408, "too-late")
    assert "head was not whole after 10 seconds" in found["detail"]


def test_a_body_that_stalls_is_given_up_in_time() -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, POST)
    for _ in range(9):
        assert not line.closed
        server.feed(connection, b"x")
        server.loop.pass_(3.4)
    found = problem(line)
    assert (found["status"], found["code"]) == (408, "too-late")
    assert "body was not whole after 30 seconds" in found["detail"]


def test_line_ends_between_requests_keep_nobody_connected() -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, HEAD + b"\r\n")
    for _ in range(30):
        server.feed(connection, b"\r\n")
        server.loop.pass_(1.0)
    assert line.closed


def test_each_request_of_a_connection_has_its_own_time() -> None:
    server = Server()
    connection, line = server.dial()
    for _ in range(10):
        server.feed(connection, HEAD)
        server.loop.pass_(4.0)
        server.feed(connection, b"\r\n")
    assert not line.closed
    assert len(server.taken) == 10


def test_who_waits_for_an_answer_has_time() -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, HEAD.replace(b"there", b"slow") + b"\r\n")
    server.feed(connection, b"\r\n")
    server.loop.pass_(1000.0)
    assert not line.closed


def test_who_reads_nothing_of_an_answer_is_cut_off() -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, HEAD.replace(b"there", b"slow") + b"\r\n")
    line.unread = 5000
    server.loop.pass_(45.0)
    assert line.aborted
    assert server.refused == {"unread": 1}


def test_who_reads_slowly_is_not() -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, HEAD.replace(b"there", b"slow") + b"\r\n")
    for left in range(5000, 0, -100):
        line.unread = left
        server.loop.pass_(15.0)
    for _ in range(20):  # a stream: what was read is replaced by more
        line.unread = 5000
        connection.resume_writing()
        server.loop.pass_(15.0)
    assert not line.closed


def test_one_address_has_so_many_connections_and_others_theirs() -> None:
    server = Server(most=3)
    held = [server.dial() for _ in range(3)]
    _, refused = server.dial()
    found = problem(refused)
    assert (found["status"], found["code"]) == (429, "too-many-connections")
    assert "3 connections" in found["detail"]
    assert not server.dial("192.0.2.8")[1].closed
    held[0][0].connection_lost(None)
    assert not server.dial()[1].closed


def test_a_refused_connection_is_not_counted_when_it_ends() -> None:
    server = Server(most=1)
    first, _ = server.dial()
    second, _ = server.dial()
    second.connection_lost(None)
    assert len(server.connections) == 1
    first.connection_lost(None)
    assert len(server.connections) == 0


def test_nonsense_is_answered_as_a_problem_and_logged_by_nobody(
    caplog: pytest.LogCaptureFixture,
) -> None:
    server = Server()
    connection, line = server.dial()
    server.feed(connection, b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03")
    found = problem(line)
    assert (found["status"], found["code"]) == (400, "not-http")


def test_where_uvicorn_is_not_as_known_another_parser_bounds_heads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    edge = Server().kind.edge
    assert choose.self_test() is None
    assert issubclass(choose.choose(edge)["http"], GuardedProtocol)
    monkeypatch.setattr(GuardedProtocol, "on_headers_complete", lambda _: None)
    assert choose.self_test() is not None
    assert choose.choose(edge) == {"http": "h11", "h11_max_incomplete_event_size": 1024}
