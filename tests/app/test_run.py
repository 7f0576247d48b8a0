"""The server as a process prints its address, listens on the loopback, stops in order."""

import contextlib
import inspect
import re
import signal
import subprocess
from typing import Any

import anyio
import httpx
import pytest
from fastapi import FastAPI
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from plinko.app.errors import SettingError
from plinko.app.listening import listen
from plinko.app.main import create_app
from plinko.app.settings import Settings
from tests.kit.process import ServerProcess
from tests.kit.python import run_python


def process(**environ: str) -> ServerProcess:
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return ServerProcess(options=pipes, environment=environ)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_it_prints_its_address_and_stops_in_order(number: signal.Signals) -> None:
    with process() as running:
        assert running.get("/readyz").status_code == 200
        with connect(running.socket()) as socket:
            socket.recv()
            socket.send('{"type":"drop","seed":1}')
            socket.recv()
            running.send(number)
            with contextlib.suppress(ConnectionClosed):
                while True:
                    socket.recv()  # read what was still on its way
            assert socket.close_code in (1001, 1012)
        assert (running.ended(), running.said) == (0, ("", ""))


def test_sighup_does_not_end_it_and_a_misspelt_variable_is_named() -> None:
    with process(PLINKO_SECRETS="x", PLINKO_DATABASE_URL="sqlite://") as running:
        running.send(signal.SIGHUP)
        assert running.get("/healthz").status_code == 200
        assert running.end(signal.SIGTERM) == 0
        assert "PLINKO_SECRETS in the environment is not a setting: did you mean" in running.said[1]


def test_an_unknown_host_is_named() -> None:
    with pytest.raises(SettingError, match=r"no\.such\.host\.invalid"):
        listen(Settings(host="no.such.host.invalid", port=0))


def test_a_server_without_temporary_files_says_so_at_start() -> None:
    # In a process of its own, because `run` limits calls and forbids native code for good.
    program = (
        "import tempfile\n"
        "from plinko.app.errors import SettingError\n"
        "from plinko.app.main import run\n"
        "from plinko.app.settings import Settings\n"
        "def refuse(): raise FileNotFoundError\n"
        "tempfile.gettempdir = refuse\n"
        "try: run(Settings(port=0))\n"
        "except SettingError as error: print(error)\n"
    )
    said = run_python(program)
    assert re.search(r"no directory for temporary files .* TMPDIR", said)


def asking(app: FastAPI) -> httpx.AsyncClient:
    plain = {"Accept-Encoding": "identity"}  # a long list is compressed on a thread
    transport = httpx.ASGITransport(app)
    return httpx.AsyncClient(transport=transport, base_url="http://localhost", headers=plain)


async def test_the_first_request_waits_for_no_route_to_be_worked_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    app = create_app(Settings(database_url="sqlite://"))
    looked_at: list[object] = []
    signature = inspect.signature

    def watched(function: Any, **options: Any) -> inspect.Signature:
        looked_at.append(function)
        return signature(function, **options)

    monkeypatch.setattr(inspect, "signature", watched)
    async with asking(app) as client:
        assert (await client.get("/api/v1/boards")).status_code == 200
        assert (await client.get("/nowhere")).status_code == 404
    assert looked_at == []


async def test_a_request_that_computes_nothing_needs_no_thread_and_documents_are_made_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def refuse(function: Any, *_: Any, **__: Any) -> None:
        raise AssertionError(f"{function} is for another thread")

    def again(*_: object) -> None:
        raise AssertionError("it was made already")

    documents = ("/openapi.json", "/asyncapi.json")
    app = create_app(Settings(database_url="sqlite://"))
    async with asking(app) as client:
        first = [(await client.get(path)).content for path in documents]
        monkeypatch.setattr(anyio.to_thread, "run_sync", refuse)
        for path in ("/api/v1/boards", "/api/v1/boards/triangle-8", "/api/v1/scenes", "/healthz"):
            assert (await client.get(path)).status_code == 200
        monkeypatch.setattr(app, "openapi", again)
        monkeypatch.setattr("plinko.app.protocol.asyncapi.document", again)
        assert [(await client.get(path)).content for path in documents] == first
