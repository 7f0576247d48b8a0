"""While the ledger cannot be written, drops get 503 and rooms play on; then it recovers."""

import contextlib
import os
import shutil
import signal
import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import psycopg
import pytest
import sqlalchemy as sa

from plinko.app.persistence.ledger.writer import COMMIT_PATIENCE
from plinko.app.rooms.log import verify_log
from tests.app.conftest import QUICK, TINY
from tests.kit.player import playing
from tests.kit.postgres import PostgreSQL
from tests.kit.serving import Running, serving
from tests.kit.waiting import LIMIT, eventually, until

Break = Callable[[], AbstractContextManager[None]]
ROOM = "triangle-8"


async def suffers_and_heals(
    server: Running, broken: Break, wanted: str, *, noticed: bool = False
) -> None:
    """Check a server before, during and after a failure; `noticed`: a probe finds it first."""
    rooms = server.services.rooms
    with server.client() as first:
        room = first.post("/api/v1/rooms", json={"board": TINY}).json()["id"]
    async with (
        server.async_client() as http,
        playing(server.socket(room)) as player,
    ):
        await player.send(type="drop", seed=1)
        flying = await player.until("accepted")
        with broken():
            if noticed:
                assert (await http.get("/readyz")).status_code == 503
            refused = await http.post(f"/api/v1/rooms/{room}/drops", json={"seed": 2})
            assert refused.status_code == 503
            assert refused.headers["content-type"] == "application/problem+json"
            assert refused.json()["code"] == "ledger-unavailable"
            assert wanted in str(server.services.ledger.problem)  # in the log, not in the answer
            assert "the server's log has the reason" in refused.json()["detail"]
            assert int(refused.headers["retry-after"]) >= 1
            # The WebSocket's sender receives the error with its `ref`, and stays connected.
            await player.send(type="drop", seed=3, ref="mine")
            error = await player.until("error")
            assert (error["code"], error["ref"]) == ("ledger-unavailable", "mine")
            ready = await http.get("/readyz")
            assert (ready.status_code, ready.json()["checks"]["ledger"]) == (503, False)
            assert (await http.get("/healthz")).status_code == 200
            opened = await http.post("/api/v1/rooms", json={"board": "triangle-8"})
            assert opened.status_code == 503
            # Clients can still join and watch: the ball in flight lands.
            async with playing(server.socket(room)) as late:
                assert late.hello["type"] == "hello"
            landed = await player.until("landed", ball=flying["ball"])
            view = (await http.get(f"/api/v1/rooms/{room}")).json()
            assert view["stats"]["drops"] == 1, "nothing half-done"
        await eventually(lambda: server.services.ledger.up)
        assert (await http.get("/readyz")).status_code == 200
        again = (await http.post(f"/api/v1/rooms/{room}/drops?wait=1", json={"seed": 4})).json()
        assert again["ball"] == 1
        log = (await http.get(f"/api/v1/rooms/{room}/log")).json()
    assert [each["seed"] for each in log["drops"]] == ["1", "4"], "no refused drop came back"
    assert log["drops"][0]["result"]["digest"] == landed["digest"]
    assert verify_log(log).ok
    assert not rooms.find(room).busy


async def test_a_full_disk(small_disk: Path) -> None:
    url = f"sqlite:///{small_disk / 'plinko.db'}"

    @contextlib.contextmanager
    def full() -> Iterator[None]:
        filler = small_disk / "filler"
        with filler.open("wb", buffering=0) as file, contextlib.suppress(OSError):
            while True:
                file.write(b"x" * 512)
        yield
        filler.unlink()

    with serving(database_url=url, drop_rate=1000.0) as server:
        await suffers_and_heals(server, full, "full")


async def test_a_database_that_may_not_grow(tmp_path: Path) -> None:
    """SQLite reports SQLITE_FULL without a full disk."""
    url = f"sqlite:///{tmp_path / 'plinko.db'}"
    with serving(database_url=url, drop_rate=1000.0) as server:
        engine = server.services.ledger.database._engine
        limit = 0

        @sa.event.listens_for(engine, "begin")
        def _limit(connection: Any) -> None:
            connection.exec_driver_sql(f"PRAGMA max_page_count = {limit or 1 << 30}")

        @contextlib.contextmanager
        def full() -> Iterator[None]:
            nonlocal limit
            limit = 1  # fewer pages than the file has: it cannot grow
            with sqlite3.connect(tmp_path / "plinko.db") as other:
                # SQLite would still use free pages inside the file: fill them.
                (free,) = other.execute("PRAGMA freelist_count").fetchone()
                other.execute("CREATE TABLE filler (x)")
                other.execute("INSERT INTO filler VALUES (zeroblob(?))", (4096 * (free + 4),))
            other.close()
            yield
            limit = 0

        # A drop's row may still fit into a page; the probe, a whole page, does not.
        await suffers_and_heals(server, full, "full", noticed=True)


async def test_a_file_that_is_gone(tmp_path: Path) -> None:
    home, away = tmp_path / "here", tmp_path / "away"

    @contextlib.contextmanager
    def gone() -> Iterator[None]:
        home.rename(away)
        yield
        away.rename(home)

    with serving(database_url=f"sqlite:///{home / 'plinko.db'}", drop_rate=1000.0) as server:
        await suffers_and_heals(server, gone, "No such file")


@pytest.mark.postgresql
async def test_a_postgresql_that_crashed(postgresql: PostgreSQL) -> None:
    @contextlib.contextmanager
    def down() -> Iterator[None]:
        postgresql.end(signal.SIGQUIT)
        yield
        postgresql.start()

    with serving(database_url=postgresql.new_database(), drop_rate=1000.0) as server:
        await suffers_and_heals(server, down, "ledger")


async def test_a_database_that_does_not_answer(url: str, tmp_path: Path) -> None:
    """Another connection's lock blocks a commit: its outcome is unknown for some time."""

    @contextlib.contextmanager
    def locked() -> Iterator[None]:
        # Its patience is short only here: on a busy machine another commit may take longer.
        ledger, patience = server.services.ledger, server.services.ledger.patience
        if url.startswith("sqlite"):
            other = sqlite3.connect(tmp_path / "plinko.db", isolation_level=None)
            other.execute("BEGIN IMMEDIATE")
            ledger.patience = 0.3
            yield
            ledger.patience = patience
            other.execute("ROLLBACK")
            other.close()
        else:
            with psycopg.connect(url) as connection:
                connection.execute("LOCK TABLE drops, rooms, probes IN ACCESS EXCLUSIVE MODE")
                ledger.patience = 0.3
                yield
                ledger.patience = patience

    with serving(database_url=url, patience=COMMIT_PATIENCE, drop_rate=1000.0) as server:
        await suffers_and_heals(server, locked, "has not answered for 0.3 seconds")


def test_a_late_commit_is_undecided_until_then_and_true_after(
    url: str,
) -> None:
    with (
        serving(database_url=url, patience=COMMIT_PATIENCE) as server,
        server.client("/api/v1") as http,
    ):
        made = http.post("/rooms", json={"board": QUICK}).raise_for_status()
        room = made.json()["id"]
        ledger = server.services.ledger
        batch, patience = ledger.database.batch, ledger.patience  # `batch` is for writes only
        told = threading.Event()

        @contextlib.contextmanager
        def slow() -> Iterator[Any]:
            with batch() as connection:
                yield connection
                drops = connection.scalar(sa.text("SELECT count(*) FROM drops"))
                if drops:  # else a batch of the start, or a heartbeat
                    ledger.patience = 0.1  # not before: unsent writes would be refused
            assert not drops or told.wait(LIMIT)

        ledger.database.batch = slow  # type: ignore[method-assign]
        undecided = http.post(f"/rooms/{room}/drops", json={"seed": 1})
        assert (undecided.status_code, undecided.json()["code"]) == (503, "undecided")
        assert int(undecided.headers["retry-after"]) >= 1
        refused = http.post(f"/rooms/{room}/drops", json={"seed": 7})
        assert (refused.status_code, refused.json()["code"]) == (503, "ledger-unavailable")
        ledger.database.batch = batch  # type: ignore[method-assign]
        ledger.patience = patience
        told.set()
        again = f"/rooms/{room}/drops?wait=1"
        until(lambda: http.post(again, json={"seed": 2}).status_code == 200)
        log = http.get(f"/rooms/{room}/log").json()
    assert [each["seed"] for each in log["drops"]] == ["1", "2"]
    with (
        serving(database_url=url) as server,
        server.client() as http,
    ):
        stats = http.get(f"/api/v1/rooms/{room}").json()["stats"]
    assert (stats["drops"], sum(stats["histogram"])) == (2, 2)


def test_a_file_put_in_the_ledgers_place_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "plinko.db"
    with (
        serving(database_url=f"sqlite:///{file}") as server,
        server.client("/api/v1") as http,
    ):
        assert http.post(f"/rooms/{ROOM}/drops").status_code == 202
        copy = tmp_path / "copy"
        shutil.copy(file, copy)
        os.replace(copy, file)
        refused = http.post(f"/rooms/{ROOM}/drops")
        assert refused.status_code == 503
        assert "replaced by another file" in str(server.services.ledger.problem)
        assert str(file) not in refused.text
