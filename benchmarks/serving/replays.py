"""Replays and `/healthz` over REST, each compared with a bare route of as many bytes.

`python -m benchmarks.serving.replays BYTES …` serves the bare routes: FastAPI on uvicorn, with the
server's parser and event loop. The reply to `/BYTES` has that many bytes.
"""

import asyncio
import contextlib
import functools
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterable, Iterator
from itertools import count
from pathlib import Path
from typing import Final

from benchmarks.harness.clock import Job, in_turns
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.serving.process import OPTIONS, Served, core_for_server, pinned, serving, stop

BOARD: Final = "triangle-16"
CONNECTIONS: Final = 16
HEALTH, REPLAYS = "`/healthz`", "replays of distinct seeds"
AIMS: Final = {HEALTH: 0.65, REPLAYS: 0.5}
"""Aims for requests per second, relative to the bare route."""


def run(effort: Effort) -> Section:
    """Measure requests per second of each route, in turns."""
    section = Section("replays")
    window = 2.0 if not effort.quick else 0.2
    seeds = count()
    with contextlib.ExitStack() as stack:
        loop = stack.enter_context(contextlib.closing(asyncio.new_event_loop()))
        server = stack.enter_context(serving(OPTIONS))
        replay = f"/api/v1/drops/{BOARD}/"
        sizes = {
            HEALTH: _size(f"{server.address}/healthz"),
            REPLAYS: _size(f"{server.address}{replay}0"),
        }
        bare = stack.enter_context(_bare(sizes.values()))
        for each in (server, bare):
            pinned(each.process, core_for_server())
        paths = {
            HEALTH: _always("/healthz"),
            REPLAYS: (f"{replay}{seed}" for seed in seeds),
        }
        jobs: dict[str, Job] = {}
        for name, asked in paths.items():
            jobs[name] = functools.partial(_rate, loop, server, asked, window)
            same_size = _always(f"/{sizes[name]}")
            jobs[_bare_of(name)] = functools.partial(_rate, loop, bare, same_size, window)
        rates = in_turns(jobs, effort.rounds, lambda: effort.step("replays"))
    section.data["replays"] = {name: sample.to_dict() for name, sample in rates.items()}
    section.tables.append(
        Table(
            "Requests over REST",
            ["request", "bytes", "requests/s", "bare route", "ratio", "aim"],
            [
                [
                    name,
                    f"{sizes[name]:,}",
                    spread(rates[name], "{:,.0f}"),
                    spread(rates[_bare_of(name)], "{:,.0f}"),
                    spread(rates[name].over(rates[_bare_of(name)]), "{:.2f}"),
                    f"{aim:.2f}",
                ]
                for name, aim in AIMS.items()
            ],
            [
                "Answers per second of the serving process's processor time, so other load on the "
                f"machine counts little. {CONNECTIONS} clients each send the next request when "
                "they have the last answer. The bare route is an `async` function of a FastAPI "
                "application without middleware that returns as many bytes, on uvicorn with the "
                f"server's parser and event loop. A replay is `GET drops/{BOARD}/SEED`, each of a "
                "new seed."
            ],
        )
    )
    return section


def _bare_of(name: str) -> str:
    return f"a bare route for {name}"


def _size(url: str) -> int:
    with urllib.request.urlopen(url) as answer:
        return len(answer.read())


def _always(path: str) -> Iterator[str]:
    while True:
        yield path


def _rate(
    loop: asyncio.AbstractEventLoop, server: Served, paths: Iterator[str], seconds: float
) -> float:
    """Answered requests per second of the server's processor time."""
    return loop.run_until_complete(_ask(server, paths, seconds))


async def _ask(server: Served, paths: Iterator[str], seconds: float) -> float:
    loop = asyncio.get_running_loop()
    host, _, port = server.address.rpartition("/")[2].rpartition(":")
    clients = []
    for number in range(CONNECTIONS):
        make = functools.partial(_Client, paths, f"192.0.2.{number}")
        clients.append((await loop.create_connection(make, host, int(port)))[1])
    before, began = sum(client.answers for client in clients), server.cpu
    await asyncio.sleep(seconds)
    answered, took = sum(client.answers for client in clients) - before, server.cpu - began
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
def _bare(sizes: Iterable[int]) -> Iterator[Served]:
    """The bare routes' process and address."""
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.serving.replays", *map(str, sizes)],
        cwd=Path(__file__).parents[2],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        yield Served(process, process.stdout.readline().strip())
    finally:
        stop(process)


def _serve_bare(sizes: Iterable[int]) -> None:
    import uvicorn
    from fastapi import FastAPI, Response

    app = FastAPI()

    def add(size: int) -> None:
        body = b" " * size

        @app.get(f"/{size}")
        async def get() -> Response:
            return Response(body, media_type="application/json")

    for size in sizes:
        add(size)
    config = uvicorn.Config(
        app, loop="uvloop", http="httptools", access_log=False, log_config=None,
        server_header=False, proxy_headers=False,
    )  # fmt: skip
    with socket.create_server(("127.0.0.1", 0)) as listener:
        print(f"http://127.0.0.1:{listener.getsockname()[1]}", flush=True)
        with contextlib.suppress(KeyboardInterrupt):  # SIGINT stops it
            uvicorn.Server(config).run(sockets=[listener])


if __name__ == "__main__":
    _serve_bare(map(int, sys.argv[1:]))
