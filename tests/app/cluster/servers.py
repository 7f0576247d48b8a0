"""Several `plinko serve` processes over one PostgreSQL, which tests kill and restart."""

import signal
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import httpx

from tests.kit.process import ServerProcess
from tests.kit.waiting import LIMIT, until


def member(name: str, *flags: str, ledger: str = "") -> ServerProcess:
    """A server of this name; `ledger` if its address of PostgreSQL differs from the others'."""
    common = ("--max-rooms", "10000", "--workers", "1")
    return ServerProcess(name=name, flags=(*common, *flags), ledger=ledger)


def three() -> tuple[ServerProcess, ...]:
    # Each has another drop rate, so that a response's headers show which server counted it.
    return tuple(member(f"plinko{k + 1}", "--drop-rate", f"{1000 + k}") for k in range(3))


@dataclass
class Servers:
    """Servers that share a ledger; the end of a `with` block kills all of them."""

    ledger: str
    all: tuple[ServerProcess, ...]

    def __iter__(self) -> Iterator[ServerProcess]:
        return iter(self.all)

    def __enter__(self) -> Self:
        try:
            self.start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        for each in self.up:
            each.end(signal.SIGKILL)

    @property
    def up(self) -> list[ServerProcess]:
        return [each for each in self.all if each.process is not None]

    def start(self) -> None:
        """Start those that do not run, and wait until every server knows all others."""
        down = [each for each in self.all if each.process is None]
        for each in down:
            each.ledger = each.ledger or self.ledger
            each.begin()
        for each in down:
            each.wait()
        names = {each.name for each in self.all}
        until(lambda: all(self.known_to(each) == names for each in self))

    def known_to(self, server: ServerProcess) -> set[str]:
        """The names of the servers that this one considers alive."""
        return set(server.get("/readyz").json()["cluster"]["servers"])

    def holder(self, room: str) -> ServerProcess:
        """Wait until exactly one server has the room in memory; returns that server."""
        found: list[ServerProcess] = []

        def somebody() -> bool:
            found[:] = [each for each in self.up if self.has(each, room)]
            return len(found) == 1

        until(somebody)
        return found[0]

    def has(self, server: ServerProcess, room: str) -> bool:
        """Whether this server has this room in memory."""
        own = f'plinko_cluster_rooms{{process="{server.name}"}}'
        return own in server.get("/metrics").text and room in rooms_of(server)


def rooms_of(server: ServerProcess) -> set[str]:
    """The rooms in this server's memory."""
    own = {"plinko-hops": "3"}
    answer = httpx.get(f"{server.url}/api/v1/rooms", headers=own, timeout=LIMIT)
    return {room["id"] for room in answer.json()["rooms"]}
