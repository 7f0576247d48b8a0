"""A ledger of release 1.0.0 is upgraded: its results, logs and receipts stay provable.

That release wrote kept/ledger-1.0.0.tar.xz and was killed with balls in flight. The file told.json
in it has what its players had received.
"""

import contextlib
import functools
import json
import sqlite3
import tarfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from plinko.app.fairness.check import check_session, kernel_digest_of
from plinko.app.fairness.export import read_export
from plinko.app.persistence.ledger.database import Database, address
from plinko.app.persistence.statements import fair_store, store
from plinko.app.rooms.log import verify_log
from plinko.app.settings import page_kernels
from plinko.engine import Board, drop
from tests.app.persistence.crash.life import look
from tests.kit.postgres import PostgreSQL
from tests.kit.serving import serving

KEPT = Path(__file__).parent / "kept" / "ledger-1.0.0.tar.xz"
BOARD = Board.preset("triangle-8")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    with tarfile.open(KEPT) as kept:
        kept.extractall(tmp_path, filter="data")
    return tmp_path


def told_in(folder: Path) -> dict[str, Any]:
    told: dict[str, Any] = json.loads((folder / "told.json").read_text())
    return told


def test_an_upgrade_keeps_told_results_and_returns_the_stakes_of_balls_in_flight(
    folder: Path,
) -> None:
    """Those balls fell by an earlier PHYSICS_VERSION, which this release cannot compute."""
    url, told = f"sqlite:///{folder / 'plinko.db'}", told_in(folder)
    with serving(database_url=url) as server, server.client("/api/v1") as http:
        room = http.get(f"/rooms/{told['room']}").raise_for_status().json()
        assert room["stats"]["drops"] == 0, "a new run with the new clock"
        shown = {"authorization": f"Bearer {told['session_token']}"}
        session = f"/sessions/{told['session']}"
        http.post(f"{session}/end", headers=shown).raise_for_status()
        export = http.get(f"{session}/export", headers=shown).raise_for_status().json()
    landed, flying = export["drops"][:3], export["drops"][3:]
    assert [each["result"]["digest"] for each in landed] == [
        each["landed"]["digest"] for each in told["staked"]
    ]
    assert len(flying) == 2
    for each in flying:
        assert (each["result"]["bin"], each["result"]["payout"]) == (None, each["receipt"]["stake"])
    export["heard"] = [each["receipt"] for each in (*told["staked"], *told["flying"][:2])]
    verdict = check_session(
        read_export(export), kernel_digest=kernel_digest_of(page_kernels().read_bytes())
    )
    computed = {"physics", "kernel", "trajectory"}  # these need the release that played the session
    assert verdict.drops == 5
    assert {step.name for step in verdict.failed if step.drop not in (3, 4)} == computed
    assert {step.name for step in verdict.failed if step.drop in (3, 4)} == {
        "trajectory", "outcome", "payout",
    }  # fmt: skip


def test_results_stay_and_no_drop_of_the_earlier_release_is_without_one(folder: Path) -> None:
    url, told = f"sqlite:///{folder / 'plinko.db'}", told_in(folder)
    runs = look(url, store.run_numbers)
    with serving(database_url=url) as server, server.client("/api/v1") as http:
        main = http.get("/rooms/main/log").json()
        assert (main["drops"], verify_log(main).ok) == ([], True)
    boards = {told["room"]: BOARD, "main": Board.preset("triangle-16")}
    landed = returned = 0
    for number in runs:
        row = look(url, store.run, number)
        if row.id not in boards:
            continue
        assert row.closed is not None
        for fact, result in look(url, store.drops, number, 0):
            assert result is not None
            if result.bin is None:
                assert "physics version" in str(result.unsettled)
                returned += 1
                continue
            alone = drop(boards[row.id], fact.seed)  # the presets' paths are the same ones
            assert (result.bin, result.x_end) == (alone.bin, alone.x_end)
            landed += 1
    assert (landed, returned) == (6, 5)


def schema(url: str) -> dict[str, Any]:
    """Columns, keys and indexes of a ledger's tables, as texts."""

    def read(connection: sa.Connection) -> dict[str, Any]:
        inspector = sa.inspect(connection)
        parts = (
            inspector.get_columns,
            inspector.get_foreign_keys,
            inspector.get_indexes,
            inspector.get_check_constraints,
            inspector.get_unique_constraints,
            lambda table: [inspector.get_pk_constraint(table)],
        )
        return {
            table: [
                sorted(json.dumps(each, default=str, sort_keys=True) for each in part(table))
                for part in parts
            ]
            for table in inspector.get_table_names()
        }

    found: dict[str, Any] = look(url, read)
    return found


def test_an_upgraded_ledger_has_the_tables_of_a_new_one(folder: Path) -> None:
    upgraded, new = (f"sqlite:///{folder / name}" for name in ("plinko.db", "new.db"))
    for url in (upgraded, new):
        database = Database(url)
        database.open(check=False)
        database.close()
    assert schema(upgraded) == schema(new)


@pytest.mark.postgresql
def test_on_postgresql_each_row_is_the_same_after_the_upgrade(
    folder: Path, postgresql: PostgreSQL
) -> None:
    kept, there = f"sqlite:///{folder / 'plinko.db'}", postgresql.new_database()
    with contextlib.closing(sqlite3.connect(folder / "plinko.db")) as ledger:
        ledger.execute("UPDATE drops SET who = 'ann', seed = '18446744073709551615' WHERE ball = 0")
        ledger.execute("INSERT INTO halts VALUES ('a', 5)")
        ledger.commit()
    copy(kept, there)
    session = told_in(folder)["session"]
    with opened(kept) as one, opened(there) as other:
        reads: list[Callable[[sa.Connection], object]] = [
            functools.partial(store.drops, room=run, first=0) for run in store.run_numbers(one)
        ]
        reads += [functools.partial(fair_store.exported, session_id=session), store.orders]
        for read in reads:
            assert read(other) == read(one)
        facts = store.drops(other, 1, 0)
        assert (facts[0][0].who, facts[0][0].seed) == ("ann", 2**64 - 1)
        assert [order.subject for order in store.orders(other)] == ["a"]
        assert fair_store.exported(other, session) is not None


@pytest.mark.postgresql
def test_servers_that_start_at_once_upgrade_the_tables_once(
    folder: Path, postgresql: PostgreSQL
) -> None:
    there = postgresql.new_database()
    copy(f"sqlite:///{folder / 'plinko.db'}", there)
    databases = [Database(there, shared=True) for _ in range(3)]
    with ThreadPoolExecutor(len(databases)) as threads:
        assert [*threads.map(Database.open, databases)] == [None] * len(databases)
    for each in databases:
        each.close()


def copy(kept: str, there: str) -> None:
    """Copy the tables of release 1.0 into an empty PostgreSQL."""
    engines = sa.create_engine(kept), sa.create_engine(address(there))
    tables = sa.MetaData()
    tables.reflect(engines[0])
    with engines[0].begin() as source, engines[1].begin() as target:
        for table in tables.sorted_tables:
            rows = [dict(row) for row in source.execute(table.select()).mappings()]
            for column in table.c:
                kind: Any = column.type
                column.type = kind.as_generic()
            table.create(target)
            if rows:
                target.execute(table.insert(), rows)
    for engine in engines:
        engine.dispose()


@contextlib.contextmanager
def opened(url: str) -> Iterator[sa.Connection]:
    database = Database(url)
    database.open(check=False, enter=False)
    try:
        with database.transaction() as connection:
            yield connection
    finally:
        database.close()
