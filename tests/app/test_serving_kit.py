"""The server in a thread of the tests' process: its failures are the test's, at once."""

import socket
from collections.abc import Iterator
from typing import Any

import pytest
import uvicorn

from tests.kit.serving import in_thread
from tests.kit.waiting import until


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as made:
        yield made


async def app(scope: Any, receive: Any, send: Any) -> None:
    """Answers nothing."""


class Failing(uvicorn.Server):
    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        raise LookupError("a bug in shutdown")


class Leaking(uvicorn.Server):
    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Leaves the connections open."""
        for server in self.servers:
            server.close()


@pytest.mark.parametrize(
    ("kind", "failure"),
    [
        (Failing, pytest.raises(LookupError, match="a bug in shutdown")),
        (Leaking, pytest.raises(AssertionError, match="unclosed resource <TCPTransport")),
    ],
)
def test_a_server_that_stops_badly_fails_its_test_at_once(
    listener: socket.socket, kind: type[uvicorn.Server], failure: "pytest.RaisesExc[Exception]"
) -> None:
    server = kind(uvicorn.Config(app, loop="uvloop", lifespan="off", log_config=None))
    with socket.socket() as client, failure, in_thread(server, listener):
        client.connect(listener.getsockname())
        until(lambda: server.server_state.connections)
