"""Distinct replays per second over REST, compared with `/healthz` and with a bare route.

`python -m benchmarks.serving.replays BYTES` serves the bare route: FastAPI and uvicorn answer each
request with BYTES bytes and do nothing else.
"""

import asyncio
import contextlib
import functools
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Final

from benchmarks.harness.clock import Job, in_turns
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.serving.process import OPTIONS, Served, core_for_server, pinned, serving, stop

BOARD: Final = "triangle-16"
CONNECTIONS: Final = 16
LEAST: Final = 0.55
"""Aim for replays, relative to `/healthz`'s requests per second."""

REPLAYS, HEALTH, BARE = "replays of distinct seeds", "`/healthz`", "a bare FastAPI route"


def run(effort: Effort) -> Section:
    """Measure requests per second of each route, in turns."""
    section = Section("replays")
    window = 2.0 if not effort.quick else 0.2
    seeds = count()
    with contextlib.ExitStack() as stack:
        loop = stack.enter_context(contextlib.closing(asyncio.new_event_loop()))
        server = stack.enter_context(serving(OPTIONS))
        replay = f"/api/v1/drops/{BOARD}/"
        with urllib.request.urlopen(f"{server.address}{replay}0") as answer:
            size = len(answer.read())
        bare = stack.enter_context(_bare(size))
        for each in (server, bare):
            pinned(each.process, core_for_server())
        paths = {
            REPLAYS: (server, (f"{replay}{seed}" for seed in seeds)),
            HEALTH: (server, _always("/healthz")),
            BARE: (bare, _always("/")),
        }
        jobs: dict[str, Job] = {
            name: functools.partial(_rate, loop, who.address, asked, window)
            for name, (who, asked) in paths.items()
        }
        rates = in_turns(jobs, effort.rounds, lambda: effort.step("replays"))
    section.data["replays"] = {name: sample.to_dict() for name, sample in rates.items()}
    section.tables.append(
        Table(
            "Replays over REST",
            ["what is asked for", "requests/s", "to `/healthz`"],
            [
                [name, spread(sample, "{:,.0f}"), spread(sample.over(rates[HEALTH]), "{:.2f}")]
                for name, sample in rates.items()
            ],
            [
                f"One server on one core, {CONNECTIONS} clients that each ask for the next thing "
                f"when they have the last, on another. A replay is `GET drops/{BOARD}/SEED`, "
                "each of a seed that was not asked for before; the bare route returns as many "
                f"bytes as seed 0, {size:,}. Aim: at least {LEAST} of `/healthz`."
            ],
        )
    )
    return section


def _always(path: str) -> Iterator[str]:
    while True:
        yield path


def _rate(
    loop: asyncio.AbstractEventLoop, address: str, paths: Iterator[str], seconds: float
) -> float:
    """Answered requests per second."""
    return loop.run_until_complete(_ask(address, paths, seconds))


async def _ask(address: str, paths: Iterator[str], seconds: float) -> float:
    loop = asyncio.get_running_loop()
    host, _, port = address.rpartition("/")[2].rpartition(":")
    clients = []
    for number in range(CONNECTIONS):
        make = functools.partial(_Client, paths, f"192.0.2.{number}")
        clients.append((await loop.create_connection(make, host, int(port)))[1])
    begin = loop.time()
    before = sum(client.answers for client in clients)
    await asyncio.sleep(seconds)
    answered = sum(client.answers for client in clients) - before
    took = loop.time() - begin
    for client in clients:
        client.line.close()
        if client.refused:
            raise RuntimeError(f"the server answered {client.refused.decode()}")
    return answered / took


class _Client(asyncio.Protocol):
    """Requests one path after another over one connection."""

    line: asyncio.Transport

    def __init__(self, paths: Iterator[str], address: str) -> None:
        self.answers = 0
        self.refused = b""
        self._paths = paths
        self._address = address
        self._buffer = bytearray()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Send the first request."""
        assert isinstance(transport, asyncio.Transport)
        self.line = transport
        self._ask()

    def data_received(self, data: bytes) -> None:
        """Send the next request when an answer is complete."""
        self._buffer += data
        head, gap, body = self._buffer.partition(b"\r\n\r\n")
        length = head.lower().partition(b"content-length: ")[2].partition(b"\r\n")[0]
        if not gap or len(body) < int(length):
            return
        if not head.startswith(b"HTTP/1.1 200"):
            self.refused = bytes(head.partition(b"\r\n")[0])
            self.line.close()
            return
        self._buffer.clear()
        self.answers += 1
        self._ask()

    def _ask(self) -> None:
        head = f"host: 127.0.0.1\r\nx-forwarded-for: {self._address}"
        self.line.write(f"GET {next(self._paths)} HTTP/1.1\r\n{head}\r\n\r\n".encode())


@contextlib.contextmanager
def _bare(size: int) -> Iterator[Served]:
    """The bare route's process and address."""
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.serving.replays", str(size)],
        cwd=Path(__file__).parents[2],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        yield Served(process, process.stdout.readline().strip())
    finally:
        stop(process)


def _serve_bare(size: int) -> None:
    import uvicorn
    from fastapi import FastAPI, Response

    app = FastAPI()
    body = b" " * size

    @app.get("/")
    async def get() -> Response:
        return Response(body, media_type="application/json")

    with socket.create_server(("127.0.0.1", 0)) as listener:
        print(f"http://127.0.0.1:{listener.getsockname()[1]}", flush=True)
        server = uvicorn.Server(uvicorn.Config(app, log_level="warning", access_log=False))
        with contextlib.suppress(KeyboardInterrupt):  # SIGINT stops it
            server.run(sockets=[listener])


if __name__ == "__main__":
    _serve_bare(int(sys.argv[1]))
