"""Bodies over the limit are refused before they are read, whether the client reads or not."""

import http.client
import json
import socket

import httpx
import pytest

from tests.kit.serving import Running
from tests.kit.waiting import LIMIT

TEN_MEGABYTES = 10_000_000


def dial(server: Running) -> socket.socket:
    host, port = server.url.removeprefix("http://").split(":")
    connection = socket.create_connection((host, int(port)))
    connection.settimeout(60.0)
    return connection


def answer(connection: socket.socket) -> tuple[int, dict[str, object]]:
    response = http.client.HTTPResponse(connection, method="POST")
    response.begin()
    return response.status, json.loads(response.read(int(response.headers["content-length"])))


@pytest.mark.parametrize("path", ["drops", "boards", "verify", "rooms", "rooms/main/drops"])
def test_a_client_that_sends_it_all_still_sees_the_answer(http: httpx.Client, path: str) -> None:
    response = http.post(f"/api/v1/{path}", content=b"x" * TEN_MEGABYTES)
    assert response.status_code == 413
    assert response.headers["content-type"] == "application/problem+json"
    assert http.get("/healthz").json()["status"] == "ok"


def test_a_client_that_does_not_listen_gets_no_broken_pipe(
    server: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A busy machine takes long for ten megabytes.
    monkeypatch.setattr("plinko.app.web.edge.front._DISCARD_SECONDS", LIMIT)
    head = b"POST /api/v1/drops HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10000000\r\n\r\n"
    with dial(server) as connection:
        connection.sendall(head)
        for _ in range(100):
            connection.sendall(bytes(TEN_MEGABYTES // 100))
        assert answer(connection)[0] == 413
