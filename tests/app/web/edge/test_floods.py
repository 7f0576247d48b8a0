"""Floods of a real server: each attacker is refused with the reason, and no other client."""

import base64
import contextlib
import logging
import socket
import struct
import threading
from collections.abc import Iterator

import pytest

from tests.app.live.garbled import framed
from tests.kit.serving import Running, constants, serving

HANDSHAKE = (
    b"GET /ws/rooms/main HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
    b"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
    + base64.b64encode(bytes(16))
    + b"\r\n"
)


@pytest.fixture(scope="module")
def flooded() -> Iterator[Running]:
    with serving() as running:
        yield running


@contextlib.contextmanager
def dialled(running: Running) -> Iterator[socket.socket]:
    host, port = running.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=120.0) as line:
        yield line


def all_of(line: socket.socket) -> bytes:
    """Everything that the server sends until it closes the connection."""
    got = b""
    with contextlib.suppress(ConnectionError):  # the server leaves the rest unread
        while some := line.recv(1 << 16):
            got += some
    return got


def upgraded(line: socket.socket) -> None:
    line.sendall(HANDSHAKE + b"\r\n")
    got = b""
    while b"\r\n\r\n" not in got:
        got += line.recv(1)
    assert got.startswith(b"HTTP/1.1 101 ")


@pytest.mark.parametrize(
    "frame",
    [framed(9, b""), framed(1, b'{"type":"ping","t":1}'), framed(2, b"")],
    ids=["ping", "message", "binary"],
)
def test_a_flood_of_frames_is_closed_with_1008(flooded: Running, frame: bytes) -> None:
    with dialled(flooded) as line:
        upgraded(line)

        def flood() -> None:
            with contextlib.suppress(OSError):
                line.sendall(frame * 20_000)

        sender = threading.Thread(target=flood)
        sender.start()
        got = all_of(line)
        sender.join()
    assert b"\x88" in got
    close = got[got.rindex(b"\x88") :]
    assert struct.unpack("!H", close[2:4])[0] == 1008


def test_pipelined_requests_cut_off_count_as_no_failure(
    flooded: Running, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        for _ in range(20):
            with dialled(flooded) as line:
                line.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n" * 500)
        assert flooded.get("/healthz").status_code == 200
    assert [each.getMessage() for each in caplog.records] == []


def test_no_connection_keeps_a_server_from_an_orderly_end() -> None:
    with contextlib.ExitStack() as held:
        held.enter_context(constants(**{"plinko.app.listening.SHUTDOWN_SECONDS": 1}))
        with serving() as running:
            for sent in (
                HANDSHAKE + b"Content-Length: 5\r\n\r\nhello",
                HANDSHAKE + b"Cookie: " + b"c" * 9000 + b"\r\n\r\n",
                b"POST /api/v1/drops HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n",
            ):
                held.enter_context(dialled(running)).sendall(sent)
            running.get("/healthz")
        # A failure on the server's thread would fail this test, too.
        assert running.services.ticking is not None
        assert running.services.ticking.done()
