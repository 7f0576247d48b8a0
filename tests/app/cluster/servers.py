"""Several `plinko serve` processes over one PostgreSQL, that can be killed."""

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field

import httpx

from tests.ports import free_port
from tests.waiting import LIMIT, first_line, until

OPERATOR = "an operator's token for the tests of clusters"

_SERVE = (
    *(sys.executable, "-m", "app.cli", "serve"),
    *("--drop-rate", "1000", "--creator-rooms", "1000"),
    *("--workers", "1"),
)


@dataclass
class One:
    """One server; it can be started again.

    database: what it reaches the ledger by, where that is not as for the others; more: options.
    """

    name: str
    port: int = field(default_factory=free_port)
    process: "subprocess.Popen[str] | None" = None
    database: str = ""
    more: tuple[str, ...] = ()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def address(self) -> str:
        """What `play` asks for."""
        return self.url

    def socket(self, room: str) -> str:
        return f"ws://127.0.0.1:{self.port}/ws/rooms/{room}"

    def begin(self, database: str) -> None:
        """Start it, without waiting for it."""
        ledger = self.database or database
        own = {"PLINKO_OPERATOR_TOKEN": OPERATOR, "PLINKO_DATABASE_URL": ledger}
        self.process = subprocess.Popen(
            [
                *_SERVE,
                "--port",
                str(self.port),
                "--name",
                self.name,
                *self.more,
            ],
            env=os.environ | own,
            stdout=subprocess.PIPE,
            text=True,
        )

    def started(self) -> None:
        """Return once it listens."""
        assert self.process is not None
        line = first_line(self.process)
        assert re.search(r"http://\S+", line), f"the server said {line!r} and no address"

    def send(self, what: signal.Signals) -> None:
        assert self.process is not None
        self.process.send_signal(what)

    def end(self, how: signal.Signals) -> int:
        """End it; returns its exit code."""
        assert self.process is not None
        process, self.process = self.process, None
        process.send_signal(how)
        process.communicate(timeout=LIMIT)
        return process.returncode

    def get(self, path: str) -> httpx.Response:
        return httpx.get(f"{self.url}{path}", timeout=LIMIT)

    @property
    def rooms(self) -> int:
        """Rooms that are this server's."""
        count: int = self.get("/readyz").json()["cluster"]["rooms"]
        return count


@dataclass
class Servers:
    """Servers that share a ledger, and what they share."""

    database: str
    all: tuple[One, ...]

    def __iter__(self) -> Iterator[One]:
        return iter(self.all)

    @property
    def up(self) -> list[One]:
        return [one for one in self.all if one.process is not None]

    def start(self) -> None:
        """Start all that are not running, and return once each knows all."""
        down = [one for one in self.all if one.process is None]
        for one in down:
            one.begin(self.database)
        for one in down:
            one.started()
        until(lambda: all(self.known_to(one) == {each.name for each in self.all} for one in self))

    def known_to(self, one: One) -> set[str]:
        """The servers that this one takes for alive."""
        return set(one.get("/readyz").json()["cluster"]["servers"])

    def holder(self, room: str) -> One:
        """The server that has the room, which somebody does: one asks each for itself alone."""
        found: list[One] = []

        def somebody() -> bool:
            found[:] = [one for one in self.up if self.has(one, room)]
            return len(found) == 1

        until(somebody)
        return found[0]

    def has(self, one: One, room: str) -> bool:
        """Whether this server has this room in memory."""
        answer = one.get("/metrics").text
        return f'plinko_cluster_rooms{{process="{one.name}"}}' in answer and room in one_s_rooms(
            one
        )


def one_s_rooms(one: One) -> set[str]:
    """The rooms in this server's memory."""
    own = {"plinko-hops": "3"}
    answer = httpx.get(f"{one.url}/api/v1/rooms", headers=own, timeout=LIMIT)
    return {room["id"] for room in answer.json()["rooms"]}


@contextlib.contextmanager
def running(database: str, count: int = 3) -> Iterator[Servers]:
    """So many servers, gone at the end."""
    # Each allows an address another rate, so that an answer shows which of them has counted.
    rates = [("--drop-rate", f"{1000 + k}") for k in range(count)]
    all_of_them = (One(f"plinko{k + 1}", more=rate) for k, rate in enumerate(rates))
    servers = Servers(database, tuple(all_of_them))
    with kept(servers):
        yield servers


@contextlib.contextmanager
def kept(servers: Servers) -> Iterator[None]:
    """These servers run, and are gone at the end."""
    try:
        servers.start()
        yield
    finally:
        for one in servers.up:
            one.end(signal.SIGKILL)
