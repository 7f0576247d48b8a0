"""Clients that send without end, slowly or too much at once, or do not read."""

import pytest

from tests.app.web.edge.lines import Server, dialled, problem

HEAD = b"GET /there HTTP/1.1\r\nHost: localhost\r\n"
SLOW = b"GET /slow HTTP/1.1\r\nHost: localhost\r\n"
POST = b"POST /slow HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\n"


@pytest.mark.parametrize("pad", [b"a: b\r\n", b"a: " + b"b" * 500 + b"\r\n", b"a" * 64])
def test_a_head_without_end_is_refused_once_it_is_over_the_limit(pad: bytes) -> None:
    server, line = dialled()
    server.feed(line, HEAD)
    sent = 0
    while not line.closed:
        server.feed(line, pad)
        sent += len(pad)
    assert sent <= 1024 + len(pad)
    found = problem(line)
    assert (found["status"], found["code"]) == (431, "head-too-large")
    assert "1024 bytes" in found["detail"]
    assert server.refused == {"head-too-large": 1}
    assert server.taken == []


@pytest.mark.parametrize(
    "head",
    [
        HEAD + b"a: " + b"b" * 2000 + b"\r\n",
        HEAD + b"a: b\r\n" * 101,
        b"GET /" + b"a" * 1900 + b" HTTP/1.1\r\nHost: localhost\r\n",
    ],
)
def test_a_head_that_comes_at_once_is_bounded_too(head: bytes) -> None:
    server, line = dialled(head_bytes=1900)
    server.feed(line, head + b"\r\n")
    assert problem(line)["status"] == 431
    assert server.taken == []


def test_a_body_is_no_head_however_long() -> None:
    server, line = dialled()
    server.feed(line, POST.replace(b"10", b"5000"))
    for _ in range(5):
        server.feed(line, b"x" * 1000)
    assert not line.closed
    assert server.taken == ["/slow"]


def test_a_silent_client_and_a_head_that_comes_byte_by_byte_are_given_up_in_time() -> None:
    server, line = dialled()
    server.loop.pass_(9.9)
    assert not line.closed
    server.loop.pass_(0.2)
    assert (line.closed, line.written) == (True, b"")
    line = server.dial()
    for byte in HEAD[:20]:
        server.feed(line, bytes([byte]))
        server.loop.pass_(0.6)
    found = problem(line)
    assert (found["status"], found["code"]) == (408, "too-late")
    assert "head was not complete after 10 seconds" in found["detail"]


def test_a_body_that_stalls_is_given_up_in_time() -> None:
    server, line = dialled()
    server.feed(line, POST)
    for _ in range(9):
        assert not line.closed
        server.feed(line, b"x")
        server.loop.pass_(3.4)
    found = problem(line)
    assert (found["status"], found["code"]) == (408, "too-late")
    assert "body was not complete after 30 seconds" in found["detail"]


def test_line_ends_between_requests_keep_no_connection_open() -> None:
    server, line = dialled()
    server.feed(line, HEAD + b"\r\n")
    for _ in range(30):
        server.feed(line, b"\r\n")
        server.loop.pass_(1.0)
    assert line.closed


def test_each_request_of_a_connection_has_its_own_time() -> None:
    server, line = dialled()
    for _ in range(10):
        server.feed(line, HEAD)
        server.loop.pass_(4.0)
        server.feed(line, b"\r\n")
    assert not line.closed
    assert len(server.taken) == 10


def test_a_client_that_waits_for_an_answer_is_not_cut_off() -> None:
    server, line = dialled()
    server.feed(line, SLOW + b"\r\n")
    server.feed(line, b"\r\n")
    server.loop.pass_(1000.0)
    assert not line.closed


def test_a_client_that_does_not_read_is_cut_off_one_that_reads_slowly_is_not() -> None:
    server, line = dialled()
    server.feed(line, SLOW + b"\r\n")
    line.unread = 5000
    server.loop.pass_(45.0)
    assert line.aborted
    assert server.refused == {"unread": 1}
    server, line = dialled()
    server.feed(line, SLOW + b"\r\n")
    for left in range(5000, 0, -100):
        line.unread = left
        server.loop.pass_(15.0)
    for _ in range(20):  # a stream: new data replaces the data read
        line.unread = 5000
        line.connection.write(b"more")
        server.loop.pass_(15.0)
    assert not line.closed


def test_each_address_has_its_own_limit_of_connections_and_a_refused_one_is_not_counted() -> None:
    server = Server(most=3)
    held = [server.dial() for _ in range(3)]
    refused = server.dial()
    found = problem(refused)
    assert (found["status"], found["code"]) == (429, "too-many-connections")
    assert "3 connections" in found["detail"]
    assert not server.dial("192.0.2.8").closed
    refused.lose()
    assert len(server.connections) == 4
    held[0].lose()
    assert len(server.connections) == 3
    assert not server.dial().closed


def test_nonsense_is_answered_as_a_problem() -> None:
    server, line = dialled()
    server.feed(line, b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03")
    found = problem(line)
    assert (found["status"], found["code"]) == (400, "not-http")


def test_requests_sent_at_once_are_read_in_turn_and_all_answered() -> None:
    server, line = dialled()
    server.feed(line, (SLOW + b"\r\n") * 500)
    assert server.taken == ["/slow"]
    assert len(line.arriving) > 450 * len(SLOW), "the rest stays in the system"
    for _ in range(500):
        assert len(server.loop.waiting) == 1
        server.loop.go_on()
    assert line.written.count(b"HTTP/1.1 200 OK") == 500
    assert not line.closed


def test_no_request_writes_to_a_client_that_is_gone(caplog: pytest.LogCaptureFixture) -> None:
    server, line = dialled()
    server.feed(line, (SLOW + b"\r\n") * 10)
    line.lose()
    server.loop.go_on()
    assert server.taken == ["/slow"], "the others do not begin"
    assert line.written == b""
    assert not caplog.records


def test_a_refusal_does_not_answer_an_earlier_request() -> None:
    server, line = dialled()
    server.feed(line, SLOW + b"\r\nnonsense\r\n\r\n")
    server.loop.go_on()
    assert (line.written, line.closed) == (b"", True)
    assert server.refused == {"not-http": 1}


H2C = b"Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\n"


def test_an_unknown_upgrade_is_ignored_and_its_connection_ends() -> None:
    server, line = dialled()
    server.feed(line, HEAD + H2C + b"\r\n" + HEAD)
    assert server.taken == ["/there"]
    assert line.written.startswith(b"HTTP/1.1 200 OK")
    assert b"\r\nconnection: close" in line.written
    assert line.closed
    # An upgrade to something else with a body is refused.
    server, line = dialled()
    server.feed(line, POST.replace(b"\r\n\r\n", b"\r\n" + H2C + b"\r\n") + b"x" * 10)
    assert problem(line)["detail"] == "a request to upgrade must have no body"
