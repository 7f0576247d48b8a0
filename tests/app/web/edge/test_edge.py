"""Attacks on a real server: foreign host names, aborted requests, too many connections."""

import contextlib
import logging
import socket
import stat
from collections.abc import Iterator
from pathlib import Path

import httpx
import msgspec
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from plinko.app.errors import LedgerError, public_text
from plinko.app.persistence.ledger.database import Database
from plinko.app.web.problems import problem_of
from tests.kit.serving import Running, constants, serving
from tests.kit.waiting import until

TOKEN = "scrape" * 6


@pytest.fixture(scope="module")
def edge() -> Iterator[Running]:
    """A server with short time-outs, and a token for its metrics."""
    with (
        constants(**{"plinko.app.listening.HEAD_SECONDS": 2.0}),
        serving(address_connections=8, metrics_token=TOKEN, hosts=("plinko.example",)) as running,
    ):
        yield running


@pytest.fixture(scope="module")
def client(edge: Running) -> Iterator[httpx.Client]:
    with edge.client() as http:
        yield http


def dial(edge: Running) -> socket.socket:
    host, port = edge.url.removeprefix("http://").split(":")
    return socket.create_connection((host, int(port)), timeout=60.0)


def metrics(client: httpx.Client) -> str:
    return client.get("/metrics", headers={"authorization": f"Bearer {TOKEN}"}).text


@pytest.mark.parametrize("path", ["/", "/api/v1/rooms", "/metrics", "/nothing"])
def test_a_strangers_name_that_points_here_gets_nothing(client: httpx.Client, path: str) -> None:
    """DNS rebinding: the browser believes that the server belongs to the attacker's site."""
    port = client.base_url.port
    headers = {"host": f"evil.example:{port}", "origin": f"http://evil.example:{port}"}
    for method in ("GET", "HEAD", "POST", "OPTIONS"):
        refused = client.request(method, path, headers=headers)
        assert refused.status_code == 421
        assert refused.headers["content-security-policy"]
    assert client.get(path, headers=headers).json()["code"] == "unknown-host"


def test_nor_does_it_get_a_socket(edge: Running, client: httpx.Client) -> None:
    address = edge.socket().replace("127.0.0.1", "evil.example")
    with (
        dial(edge) as line,
        pytest.raises(InvalidStatus) as caught,
        connect(address, sock=line, additional_headers={"Origin": "http://evil.example"}),
    ):
        raise AssertionError("it was let in")
    assert caught.value.response.status_code == 421
    # A configured host name is accepted.
    headers = {"host": "plinko.example", "origin": "https://plinko.example"}
    assert client.post("/api/v1/rooms/main/drops", headers=headers).status_code == 202


def test_an_aborted_request_counts_as_no_failure(
    edge: Running, client: httpx.Client, caplog: pytest.LogCaptureFixture
) -> None:
    before = metrics(client)
    with caplog.at_level(logging.INFO, "plinko"):
        with dial(edge) as line:
            line.sendall(
                b"POST /api/v1/drops HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\n{"
            )
            until(lambda: edge.connections > 1)
        until(lambda: any(each.message == "client left" for each in caplog.records))
    (left,) = (each for each in caplog.records if each.message == "client left")
    assert left.levelname == "INFO"
    errors = [line for line in metrics(client).splitlines() if "server-error" in line]
    assert errors == [line for line in before.splitlines() if "server-error" in line]


def test_silent_connections_are_limited_and_soon_closed(
    edge: Running, client: httpx.Client
) -> None:
    with contextlib.ExitStack() as held:
        lines = [held.enter_context(dial(edge)) for _ in range(20)]
        received = [line.recv(1000) for line in lines]  # each is closed, with a reason or without
        assert sum(b"429 Too Many" in each for each in received) >= 12
        assert sum(not each for each in received) <= 8
    until(lambda: client.get("/healthz").status_code == 200)


def test_sockets_leave_the_count_when_they_end(edge: Running, client: httpx.Client) -> None:
    for _ in range(20):
        with connect(edge.socket()) as player:
            player.recv()
        until(lambda: edge.services.hub.count("main") == 0)
    assert client.get("/healthz").status_code == 200


def test_the_metrics_can_have_a_token(client: httpx.Client) -> None:
    for headers, status in (
        ({}, 401),
        ({"authorization": "Bearer guessed"}, 403),
        ({"authorization": f"Bearer {TOKEN}"}, 200),
    ):
        reply = client.get("/metrics", headers=headers)
        assert reply.status_code == status
        assert ("plinko_info" in reply.text) == (status == 200)
        assert TOKEN not in reply.text


@pytest.mark.parametrize(
    "cause",
    [
        "the ledger cannot be written: unable to open database file /var/lib/plinko/plinko.db",
        'connection to server at "10.0.0.7", port 5432 failed: Connection refused',
        "the ledger refuses it: UNIQUE constraint failed: drops.room, drops.ball",
    ],
)
def test_a_database_s_error_appears_only_in_the_log(cause: str) -> None:
    error = LedgerError(cause)
    told_outside = msgspec.json.encode(problem_of(error)).decode() + public_text(error)
    for secret in ("/var", "plinko.db", "10.0.0.7", "5432", "UNIQUE", "drops"):
        assert secret not in told_outside
    assert "the server's log has the reason" in told_outside


def test_only_their_owner_can_read_the_ledger_s_files(tmp_path: Path) -> None:
    file = tmp_path / "plinko.db"
    for old in ("plinko.db", "plinko.db-wal"):
        (tmp_path / old).touch(0o644)
    database = Database(f"sqlite:///{file}")
    database.open()
    try:
        found = {each.name: stat.S_IMODE(each.stat().st_mode) for each in tmp_path.iterdir()}
    finally:
        database.close()
    assert {"plinko.db", "plinko.db-wal", "plinko.db-shm", "plinko.db-lock"} <= found.keys()
    assert set(found.values()) == {0o600}
