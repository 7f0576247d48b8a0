"""A server under load whose process or database stalls, is cut off or full at random moments.

The server is not killed, so ledger and events must agree on every drop: no refused drop is in the
ledger, and every drop in the ledger was sent to all clients.
"""

import asyncio
import contextlib
import os
import random
import signal
import sqlite3
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from pathlib import Path

import psycopg
import pytest

from plinko.app.rooms.log import verify_log
from plinko.engine import Board
from tests.kit.process import ServerProcess
from tests.kit.siege import Heard, Siege, play
from tests.kit.waiting import LIMIT, eventually

FAULTS = int(os.environ.get("PLINKO_TEST_FAULTS", "20"))
SECONDS = (0.5, 1.0, 1.7, 2.0, 2.2, 2.5, 3.0, 4.0, 6.0, 10.0)
TABLES = {"main": "triangle-16", "triangle-8": "triangle-8"}
TOUCHING = "interacting-triangle-8"

Fault = Callable[["Load", float], AbstractAsyncContextManager[None]]


@dataclass(kw_only=True)
class Load(Siege):
    """Players in three rooms, whose connections must survive every fault."""

    server: ServerProcess
    file: Path | None = None  # SQLite's
    disk: Path | None = None  # a small disk for the test to fill

    def somewhere(self) -> ServerProcess:
        return self.server

    async def play(self, told: Heard, seeds: Iterator[int], pause: float | None = 0.3) -> None:
        """Play without reconnecting: the connection must last to the end."""
        await play(self.server, told, seeds, 0.3, stakes=told.room in self.boards)

    async def until_still(self) -> None:
        await super().until_still()
        # The last events may still be on their way.
        tables = [self.rooms[name] for name in self.boards]
        await eventually(lambda: all(t.accepted.keys() == t.landed.keys() for t in tables))

    def came_through(self, told: Heard) -> int:
        return len(told.accepted)

    async def ready(self) -> None:
        """Wait until the server is ready and accepts drops in every room."""
        async with self.server.async_client() as http:
            while (await http.get("/readyz")).status_code != 200:
                await asyncio.sleep(0.05)
        await self.until_all_take_drops()


@contextlib.asynccontextmanager
async def locked_file(load: Load, seconds: float) -> AsyncIterator[None]:
    assert load.file is not None
    other = sqlite3.connect(load.file, isolation_level=None, timeout=LIMIT, check_same_thread=False)
    with contextlib.closing(other):
        await asyncio.to_thread(other.execute, "BEGIN IMMEDIATE")
        yield
        other.execute("ROLLBACK")


@contextlib.asynccontextmanager
async def full_disk(load: Load, seconds: float) -> AsyncIterator[None]:
    assert load.disk is not None
    filler = load.disk / "filler"
    if load.file is not None:
        # Without this, the file of the write-ahead log may have space for the next writes.
        with contextlib.closing(sqlite3.connect(load.file, timeout=LIMIT)) as other:
            other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    with filler.open("wb", buffering=0) as file:
        for size in (1 << 16, 512):
            with contextlib.suppress(OSError):
                while True:
                    file.write(b"x" * size)
    yield
    filler.unlink()


@contextlib.asynccontextmanager
async def locked_tables(load: Load, seconds: float) -> AsyncIterator[None]:
    async with await psycopg.AsyncConnection.connect(load.server.ledger) as connection:
        await connection.execute("LOCK TABLE rooms IN ACCESS EXCLUSIVE MODE")
        yield


async def _backend(load: Load) -> int:
    """The id of the PostgreSQL process that serves the server's connection."""
    async with await psycopg.AsyncConnection.connect(load.server.ledger) as connection:
        while True:
            found = await connection.execute(
                "SELECT pid FROM pg_stat_activity WHERE application_name = 'plinko' "
                "AND datname = current_database()"
            )
            row = await found.fetchone()
            if row is not None:
                return int(row[0])
            await asyncio.sleep(0.05)


@contextlib.asynccontextmanager
async def frozen_backend(load: Load, seconds: float) -> AsyncIterator[None]:
    backend = await _backend(load)
    os.kill(backend, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(backend, signal.SIGCONT)


@contextlib.asynccontextmanager
async def cut_line(load: Load, seconds: float) -> AsyncIterator[None]:
    os.kill(await _backend(load), signal.SIGTERM)
    yield


@contextlib.asynccontextmanager
async def frozen_server(load: Load, seconds: float) -> AsyncIterator[None]:
    load.server.send(signal.SIGSTOP)
    yield
    load.server.send(signal.SIGCONT)


KINDS: dict[str, dict[str, Fault]] = {
    "sqlite": {
        "locked file": locked_file,
        "full disk": full_disk,
        "frozen server": frozen_server,
    },
    "postgresql": {
        "locked tables": locked_tables,
        "frozen backend": frozen_backend,
        "cut line": cut_line,
        "full disk": full_disk,
        "frozen server": frozen_server,
    },
}


CASES = [
    pytest.param(database, kind, marks=[pytest.mark.postgresql] * (database == "postgresql"))
    for database, kinds in KINDS.items()
    for kind in kinds
]


def _ledger(
    database: str, kind: str, request: pytest.FixtureRequest
) -> tuple[str, Path | None, Path | None]:
    """The address of a new ledger, its SQLite file, and its small disk."""
    if database == "sqlite":
        disk: Path = request.getfixturevalue("small_disk")
        return f"sqlite:///{disk / 'plinko.db'}", disk / "plinko.db", disk
    if kind == "full disk":
        address, disk = request.getfixturevalue("database_on_small_disk")
        return address, None, disk
    return request.getfixturevalue("postgresql").new_database(), None, None


@pytest.mark.long("a server under load meets stalls and frozen back ends")
@pytest.mark.timeout(7200)
@pytest.mark.parametrize(("database", "kind"), CASES)
async def test_after_stalls_and_full_disks_ledger_and_events_agree(
    database: str, kind: str, request: pytest.FixtureRequest
) -> None:
    url, file, disk = _ledger(database, kind, request)
    seed = int(os.environ.get("PLINKO_TEST_SEED", "1"))
    chance = random.Random(f"{kind} {seed}")
    load = Load(server=ServerProcess(url), chance=chance, file=file, disk=disk)
    for room in (*TABLES, TOUCHING):
        load.join(room, Board.preset(TABLES[room]) if room in TABLES else None)
    with load.server as server:
        async with load.playing() as players:
            for _ in range(FAULTS):
                await load.ready()
                seconds = load.chance.choice(SECONDS)
                await asyncio.sleep(load.chance.uniform(0.0, 0.3))  # no wait: left to chance
                async with KINDS[database][kind](load, seconds):
                    await asyncio.sleep(seconds)  # no wait: the duration of the fault
            await load.ready()
            assert not any(player.done() for player in players), "no player was sent away"
        logs = {name: server.get(f"/api/v1/rooms/{name}/log").json() for name in load.rooms}
        assert all(verify_log(log).ok for log in logs.values())
        said = [(each["seed"], each["tick"]) for each in load.rooms[TOUCHING].accepted.values()]
        inputs = logs[TOUCHING]["inputs"]
        assert sorted(said) == sorted((each["input"]["seed"], each["tick"]) for each in inputs)
        assert server.end(signal.SIGTERM) == 0
        server.start()
        rooms = {name: server.get(f"/api/v1/rooms/{name}").json() for name in TABLES}
        assert {name: room["stats"]["drops"] for name, room in rooms.items()} == {
            name: len(load.rooms[name].accepted) for name in TABLES
        }
        assert server.end(signal.SIGTERM) == 0
    drops = load.hold(url)
    refused = sum(len(told.refused) for told in load.rooms.values())
    print(  # noqa: T201
        f"{kind} on {database}: {FAULTS} faults, {load.acknowledged} drops taken, "
        f"{refused} refused, {drops} computed again, all as they were announced"
    )
