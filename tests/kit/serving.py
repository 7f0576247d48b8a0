"""A real server in a thread of the tests' process, on a free port of the loopback."""

import asyncio
import contextlib
import functools
import socket
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any

import pytest
import uvicorn

from plinko.app.listening import Server, listen, server_over
from plinko.app.main import create_app
from plinko.app.settings import Settings
from plinko.app.web.routes.page import Release
from plinko.app.web.services import Services
from tests.kit.address import Address
from tests.kit.waiting import LIMIT, until


@dataclass(frozen=True)
class Running(Address):
    """A running server: its address, and its objects, whose counters tests read."""

    url: str
    services: Services
    uvicorn: Server

    @property
    def connections(self) -> int:
        """The number of open connections, HTTP and WebSocket."""
        return len(self.uvicorn.server_state.connections)


@functools.cache
def share_what_starts_read() -> None:
    """Let the servers in this process share results that depend only on the program's files.

    Bundling the pages takes most of a start: the first server does it, and later ones reuse the
    result. Servers in other processes do all of it.
    """
    patch = pytest.MonkeyPatch()
    patch.setattr(Release, "of", functools.cache(Release.of))


@contextlib.contextmanager
def in_thread(
    server: uvicorn.Server,
    listener: socket.socket,
    pause: Callable[[], object] | None = None,
) -> Iterator[str]:
    """Run a server in a thread until the block ends; gives its address, raises its error."""
    with ThreadPoolExecutor(1, "server") as thread:
        running = thread.submit(_run, server, listener)

        def is_up() -> bool:
            assert not running.done(), f"the server ended at its start: {running.exception()!r}"
            return server.started

        try:
            until(is_up, pause)
            yield f"http://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            server.should_exit = True
            wait([running])
            listener.close()  # a server that failed to start has left it open
            running.result()


def _run(server: uvicorn.Server, listener: socket.socket) -> None:
    runner = asyncio.Runner(loop_factory=server.config.get_loop_factory())
    try:
        runner.run(server.serve([listener]))
    finally:
        # uvloop warns of each open handle, then closes it. If the warning were an error, the handle
        # would stay open, and uvloop would wait forever.
        with warnings.catch_warnings(record=True, action="always") as left_open:
            runner.close()
    assert not left_open, [str(each.message) for each in left_open]


@contextlib.contextmanager
def serving(*, patience: Any = LIMIT, **settings: Any) -> Iterator[Running]:
    """Run a server with these settings until the block ends.

    patience: of its ledger, in s; a busy disk takes seconds for a commit.
    """
    chosen = Settings(**{"port": 0, "database_url": "sqlite://", **settings})
    share_what_starts_read()
    app = create_app(chosen)
    app.state.services.ledger.patience = patience
    server = server_over(app, chosen)
    with in_thread(server, listen(chosen), lambda: server.listening.wait(0.1)) as url:
        # It prints its address last: a test that reads what is printed must not find that.
        assert server.listening.wait(LIMIT)
        yield Running(url, app.state.services, server)


@contextlib.contextmanager
def constants(**values: Any) -> Iterator[None]:
    """Set modules' constants during the block: `{"plinko.app.listening.HEAD_SECONDS": 0.2}`."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in values.items():
            patch.setattr(name, value)
        yield
