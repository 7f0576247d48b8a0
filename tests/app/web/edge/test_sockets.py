"""Hostile WebSocket clients: each is answered, limited and closed without harm to others."""

import base64
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.app.live.garbled import framed
from tests.app.web.edge.lines import Line, Server, dialled, problem

PING, PONG, CONTINUATION, TEXT, CLOSE = 9, 10, 0, 1, 8

HANDSHAKE = (
    b"GET /watch HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: " + base64.b64encode(bytes(16)) + b"\r\n"
)


def upgraded(max_message: int = 1 << 16, **limits: Any) -> tuple[Server, Line]:
    """A new server, and a WebSocket connection to it."""
    server, line = dialled(**limits)
    server.config.ws_max_size = max_message
    server.feed(line, HANDSHAKE + b"\r\n")
    assert line.written.startswith(b"HTTP/1.1 101 ")
    line.written = b""
    return server, line


def closing(line: Line) -> tuple[int, str]:
    """Code and reason of the last close frame."""
    start = line.written.rindex(b"\x88")
    size = line.written[start + 1]
    payload = line.written[start + 2 :]
    assert len(payload) == size
    return struct.unpack("!H", payload[:2])[0], payload[2:].decode()


@pytest.mark.parametrize(
    ("opcode", "payload"), [(PING, b""), (PING, b"x" * 125), (PONG, b""), (CONTINUATION, b"")]
)
def test_a_flood_of_frames_without_a_message_is_closed_with_1008(
    opcode: int, payload: bytes
) -> None:
    server, line = upgraded(frame_rate=100.0)
    start = framed(TEXT, b"", fin=False) if opcode == CONTINUATION else b""
    server.feed(line, start + framed(opcode, payload, fin=opcode != CONTINUATION) * 10_000)
    assert closing(line)[0] == 1008
    assert server.refused == {"too-many-messages": 1}
    assert len(line.arriving) > 9_000 * 6, "the rest is not read"
    assert not line.closed, "so that it can read why"
    server.loop.go_on()
    server.loop.pass_(1.0)
    assert line.aborted


def test_frames_within_the_limit_go_on_for_ever() -> None:
    server, line = upgraded(frame_rate=100.0)
    for _ in range(100):
        server.feed(line, framed(PING, b"") * 100)
        server.loop.pass_(1.0)
    assert not line.closed
    assert line.written == b"\x8a\x00" * 10_000


def test_a_message_s_fragments_are_limited() -> None:
    server, line = upgraded()
    whole = framed(TEXT, b"a", fin=False) + framed(CONTINUATION, b"a", fin=False) * 63
    server.feed(line, whole)
    assert not line.closed
    server.feed(line, framed(CONTINUATION, b"a"))
    assert closing(line) == (1008, "a message has more than 64 fragments")


def test_a_client_that_does_not_read_gets_no_pongs() -> None:
    server, line = upgraded(frame_rate=1e6)
    line.connection.pause_writing()
    server.feed(line, framed(PING, b"x" * 125) * 1000)
    assert line.written == b""
    assert not line.closed
    line.connection.resume_writing()
    server.feed(line, framed(PING, b"y"))
    assert line.written == b"\x8a\x01y"
    # Its close is answered all the same.
    server, line = upgraded()
    line.connection.pause_writing()
    server.feed(line, framed(PING, b"x") + framed(CLOSE, struct.pack("!H", 1000)))
    assert line.written == b"\x88\x02\x03\xe8"
    assert line.closed


def test_a_message_over_the_limit_is_refused_before_it_is_whole() -> None:
    server, line = upgraded(max_message=4096)
    server.feed(line, framed(TEXT, b"x" * 100_000) * 3)
    assert closing(line)[0] == 1009
    assert line.written.count(b"\x88") == 1
    assert (line.arriving, line.closed) == (b"", False)
    server.loop.pass_(1.0)
    assert line.aborted


@pytest.mark.parametrize(
    ("more", "status", "said"),
    [
        (b"Content-Length: 5\r\n\r\nhello", 400, "no body"),
        (b"Content-Length: 5\r\n\r\n", 400, "no body"),
        (b"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400, "no body"),
        (b"Cookie: " + b"c" * 9000 + b"\r\n\r\n", 431, "a line of the handshake is too long"),
        (b"Content-Length: 00\r\n\r\n", 400, "not a WebSocket handshake"),
        (b"Content-Length: 0\r\n\r\n", 101, ""),
        (b"\r\n", 431, ""),
    ],
)
def test_a_handshake_that_cannot_be_read_is_answered(more: bytes, status: int, said: str) -> None:
    server, line = dialled(head_bytes=1 << 14)
    long_path = HANDSHAKE.replace(b"/watch", b"/" + b"w" * 9000)
    server.feed(line, (long_path if more == b"\r\n" else HANDSHAKE) + more)
    if status == 101:
        assert line.written.startswith(b"HTTP/1.1 101 ")
        return
    found = problem(line)
    assert found["status"] == status
    assert said in found["detail"]
    assert server.taken == []
    server.stop()
    line.lose()
    assert not server.state.connections


def test_a_handshake_after_an_unanswered_request_is_refused() -> None:
    server, line = dialled()
    server.feed(line, b"GET /slow HTTP/1.1\r\nHost: localhost\r\n\r\n" + HANDSHAKE + b"\r\n")
    assert line.closed
    server.loop.go_on()
    assert line.written == b""


def test_a_handshake_that_the_application_leaves_open_times_out() -> None:
    server, line = dialled()
    server.feed(line, HANDSHAKE.replace(b"/watch", b"/slow") + b"\r\n")
    server.loop.pass_(29.0)
    assert not line.closed
    server.loop.pass_(2.0)
    assert problem(line)["status"] == 503
    # A watcher outlasts that time.
    server, line = upgraded()
    server.loop.pass_(1000.0)
    assert (line.closed, line.written) == (False, b"")


def test_a_failure_before_a_handshake_gets_500_and_headers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def failing(*_: Any) -> None:
        raise RuntimeError("secret")

    server = Server()
    server.config.loaded_app = failing
    line = server.dial()
    server.feed(line, HANDSHAKE + b"\r\n")
    found = problem(line)
    assert found["status"] == 500
    assert "secret" not in found["detail"]


def test_a_stop_answers_waiting_handshakes_and_tells_watchers_to_come_back() -> None:
    server, waiting = dialled()
    server.feed(waiting, HANDSHAKE.replace(b"/watch", b"/slow") + b"\r\n")
    watching, leaving = server.dial(), server.dial()
    for line in (watching, leaving):
        server.feed(line, HANDSHAKE + b"\r\n")
        line.written = b""
    server.feed(leaving, framed(CLOSE, b""))
    assert leaving.closed, "it is flushing, and the stop does not wait for that"
    server.stop()
    assert problem(waiting)["detail"] == "the server is stopping"
    assert closing(watching)[0] == 1012


FRAMES = st.builds(
    framed,
    st.sampled_from([0, 1, 2, 3, 8, 9, 10]),
    st.sampled_from([b"", b"x", b"\xff", struct.pack("!H", 1000), b"x" * 200, b"x" * 5000]),
    mask=st.booleans(),
    fin=st.booleans(),
)
HEADS = st.sampled_from(
    [
        b"",
        b"GET ",
        b"nonsense\r\n\r\n",
        b"GET /slow HTTP/1.1\r\n\r\n",
        b"POST / HTTP/1.1\r\nContent-Length: 100\r\n\r\n",
        HANDSHAKE,
        HANDSHAKE + b"\r\n",
        HANDSHAKE.replace(b"/watch", b"/slow") + b"\r\n",
        HANDSHAKE + b"Content-Length: 1\r\n\r\n",
        HANDSHAKE + b"Cookie: " + b"c" * 9000 + b"\r\n\r\n",
        HANDSHAKE.replace(b"13", b"12") + b"\r\n",
    ]
)


@given(HEADS, HEADS, st.lists(FRAMES, max_size=5), st.booleans())
def test_whatever_a_client_has_sent_a_stop_ends_its_connection(
    first: bytes, second: bytes, frames: list[bytes], unread: bool
) -> None:
    server, line = dialled(head_bytes=1 << 14)
    server.feed(line, first + second)
    if unread and line.written.startswith(b"HTTP/1.1 101 "):
        line.connection.pause_writing()
    server.feed(line, b"".join(frames))
    server.stop()
    server.loop.go_on()
    server.loop.pass_(1.0)
    assert line.closed
