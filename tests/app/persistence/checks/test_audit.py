"""`plinko ledger check` finds damaged rooms; `retire` closes one and lands its balls."""

import asyncio
import json
import math
import re
import sqlite3
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psycopg
import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st

from plinko.app.cli import main
from plinko.app.persistence.statements import store, tables
from plinko.app.rooms.kinds import INDEPENDENT
from plinko.app.rooms.stakes import payout_of
from plinko.engine import Board, World, drop
from plinko.engine.drops.flight import ticks_of
from tests.app.persistence.crash.life import BOARD, break_page, copy_ledger, living, look
from tests.kit.postgres import PostgreSQL

_OWN = "(SELECT number FROM rooms WHERE owned)"
_TABLE = "(SELECT number FROM rooms WHERE mode = 'interacting')"

FINDINGS: dict[str, tuple[str, str, str]] = {
    "a missing row": (
        f"DELETE FROM drops WHERE room = {_OWN} AND ball = 1",
        "own",
        "lacks drop 1",
    ),
    "the last row missing": (
        f"DELETE FROM drops WHERE room = {_OWN} AND ball = 2",
        "own",
        "it has 2 inputs, but its row says 3",
    ),
    "a result of nothing": (
        f"UPDATE results SET ball = 9 WHERE room = {_OWN} AND ball = 1",
        "own",
        "drop 9 has a result but is missing",
    ),
    "no result": (
        f"DELETE FROM results WHERE room = {_OWN} AND ball = 2",
        "own",
        "drop 2 has no result, but nothing moves",
    ),
    "another seed": (
        f"UPDATE drops SET seed = '77' WHERE room = {_OWN} AND ball = 0",
        "own",
        "drop 0: the ledger has digest",
    ),
    "a payout": (
        f"UPDATE results SET payout = payout + 1 WHERE room = {_OWN} AND ball = 1",
        "own",
        "drop 1: the ledger has payout",
    ),
    "a tick": (
        f"UPDATE results SET tick = tick + 1 WHERE room = {_OWN} AND ball = 1",
        "own",
        "drop 1: the ledger has tick",
    ),
    "an order": (
        f"UPDATE drops SET tick = 0 WHERE room = {_OWN} AND ball = 2",
        "own",
        "input 2 has tick 0, but the one before has tick",
    ),
    "a board": (
        "UPDATE boards SET json = '{}' WHERE digest = (SELECT board FROM rooms WHERE owned)",
        "own",
        "its board",
    ),
    "an input": (
        f"UPDATE inputs SET data = '[]' WHERE room = {_TABLE}",
        "interacting-triangle-8",
        "input 0.input is not an object",
    ),
    "a checkpoint": (
        "UPDATE rooms SET checkpoint = x'00' WHERE mode = 'interacting'",
        "interacting-triangle-8",
        "the checkpoint is unreadable",
    ),
}


@dataclass(frozen=True)
class Ledger:
    """A ledger with idle rooms of both kinds, and `main` with a ball in flight."""

    file: Path
    own: str


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> Ledger:
    file = tmp_path_factory.mktemp("played") / "plinko.db"
    return Ledger(file, asyncio.run(play(f"sqlite:///{file}")))


async def play(url: str) -> str:
    async with living(url) as life:
        own = await life.rooms.create(Board.preset("triangle-9"), INDEPENDENT)
        for seed in range(3):
            await life.drop(own, seed, stake=100)
            await life.run(own, 30)
        await life.drop(await life.rooms.seek("interacting-triangle-8"), 1)
        await life.rest()
        await life.drop(life.rooms.find("main"), 5, stake=7)
        await life.leave()
        return own.id


def check(capsys: pytest.CaptureFixture[str], url: str, *more: str) -> tuple[int, dict[str, Any]]:
    code = main(["ledger", "check", "--json", "--database-url", url, *more])
    said: dict[str, Any] = json.loads(capsys.readouterr().out)
    return code, said


async def test_a_sound_ledger_is_sound(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    own = await play(url)
    for more in ([], ["--replay"]):
        code, said = await asyncio.to_thread(check, capsys, url, *more)
        assert (code, said["sound"], said["findings"], said["database"]) == (0, True, [], [])
        assert (said["sessions"], said["drops"], said["results"], said["inputs"]) == (3, 4, 3, 1)
    code, said = await asyncio.to_thread(check, capsys, url, own)
    assert (code, said["sessions"], said["drops"]) == (0, 1, 3)


def harm(file: Path, statement: str) -> None:
    """Execute a statement without the server's checks."""
    with sqlite3.connect(file) as connection:
        connection.execute(statement)
    connection.close()


@pytest.mark.parametrize("name", FINDINGS)
def test_each_damage_is_named(
    played: Ledger, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    url = f"sqlite:///{copy_ledger(played.file, tmp_path)}"
    statement, room, what = FINDINGS[name]
    harm(tmp_path / "plinko.db", statement)
    code, said = check(capsys, url)
    assert (code, said["sound"]) == (1, False)
    room_id = played.own if room == "own" else room
    assert {each["room"] for each in said["findings"]} == {room_id}
    assert any(what in each["what"] for each in said["findings"]), said["findings"]


def test_a_checkpoint_that_is_another_is_found_by_playing_again(
    played: Ledger, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"sqlite:///{copy_ledger(played.file, tmp_path)}"
    with sqlite3.connect(tmp_path / "plinko.db") as connection:
        where = "WHERE mode = 'interacting'"
        (kept,) = connection.execute(f"SELECT checkpoint FROM rooms {where}").fetchone()
        # The next ball's number becomes 2 instead of 1: a valid checkpoint, but not this room's.
        harmed = kept.replace(b"next_id\x01", b"next_id\x02")
        assert harmed != kept
        connection.execute(f"UPDATE rooms SET checkpoint = ? {where}", (harmed,))
    connection.close()
    assert check(capsys, url)[0] == 0
    code, said = check(capsys, url, "--replay")
    assert code == 1
    assert [each["what"] for each in said["findings"]] == [
        "its checkpoint differs from the replay of its inputs"
    ]


def test_sessions_of_another_physics_are_held_to_their_payouts(
    played: Ledger, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"sqlite:///{copy_ledger(played.file, tmp_path)}"
    harm(tmp_path / "plinko.db", "UPDATE rooms SET physics_version = 1")
    harm(tmp_path / "plinko.db", f"UPDATE results SET digest = 'd' WHERE room = {_OWN}")
    code, said = check(capsys, url)
    assert (code, said["other_physics"]) == (0, 3)
    harm(tmp_path / "plinko.db", "UPDATE results SET payout = payout + 1 WHERE ball = 1")
    assert check(capsys, url)[0] == 1


def test_damaged_pages_are_reported_and_the_rest_is_read(
    played: Ledger, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = copy_ledger(played.file, tmp_path)
    break_page(file, "inputs")
    assert main(["ledger", "check", "--database-url", f"sqlite:///{file}"]) == 1
    said = capsys.readouterr().out
    assert "the database: " in said
    assert re.search(r"interacting-triangle-8, run \d: its pages in the database are", said)
    assert "damaged: 3 room runs, 4 drops, 3 results, 0 inputs" in said


def test_a_ledger_that_is_not_there_cannot_be_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["ledger", "check", "--database-url", f"sqlite:///{tmp_path / 'none.db'}"]) == 2
    assert "there is no ledger" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.postgresql
def test_postgresqls_own_check_is_asked_where_it_is_installed(
    postgresql: PostgreSQL, capsys: pytest.CaptureFixture[str]
) -> None:
    url = postgresql.new_database()
    asyncio.run(play(url))
    with psycopg.connect(url, autocommit=True) as connection:
        connection.execute("CREATE EXTENSION amcheck")
        assert check(capsys, url)[0] == 0
        # An index that lacks a row: PostgreSQL does not update it while it is not ready.
        connection.execute(
            "UPDATE pg_index SET indisready = false WHERE indexrelid = 'drops_pkey'::regclass"
        )
        connection.execute(
            "INSERT INTO drops SELECT room, 50, tick, seed, x, stake, player, aim, practice "
            "FROM drops LIMIT 1"
        )
        connection.execute(
            "UPDATE pg_index SET indisready = true WHERE indexrelid = 'drops_pkey'::regclass"
        )
    code, said = check(capsys, url)
    assert code == 1
    assert "index drops_pkey: " in said["database"][0]


# Retiring a room.


def test_a_given_up_drop_that_cannot_be_computed_returns_its_stake(
    played: Ledger, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"sqlite:///{copy_ledger(played.file, tmp_path)}"
    number = look(url, store.open_room, "main").number
    harm(tmp_path / "plinko.db", f"UPDATE drops SET seed = 'x' WHERE room = {number}")
    order = ["ledger", "retire", "main", "--database-url", url]
    assert main(order) == 0
    said = (
        f"main, run {number}: ended; 0 balls landed and pay 0; 1 cannot be computed and return 7\n"
    )
    assert capsys.readouterr().out == said
    assert main(order) == 2
    assert "the ledger has no open room 'main'" in capsys.readouterr().err
    chosen = sa.select(tables.results).where(tables.results.c.room == number)
    (result,) = look(url, lambda connection: connection.execute(chosen).all())
    assert (result.payout, result.bin, "taken off" in result.unsettled) == (7, None, True)
    assert look(url, store.open_room, played.own) is not None

    async def again() -> tuple[int, int]:
        async with living(url) as life:
            room = await life.rooms.seek("main")
            return room.room.input_count, (await life.drop(room, 1)).ball

    assert asyncio.run(again()) == (0, 0)


def test_the_balls_of_a_given_up_room_land_as_their_facts_say(
    played: Ledger, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"sqlite:///{copy_ledger(played.file, tmp_path)}"
    number = look(url, store.open_room, "main").number
    assert main(["ledger", "retire", "main", "--database-url", url]) == 0
    ((fact, result),) = look(url, store.drops, number, 0)
    alone = drop(BOARD, fact.seed)
    assert (result.bin, result.digest) == (alone.bin, alone.digest)
    assert result.payout == payout_of(7, alone.score)
    assert f"1 balls landed and pay {result.payout}; 0 cannot" in capsys.readouterr().out
    assert look(url, store.run, number).tick >= result.tick


# The tick of a landing.


@pytest.mark.parametrize("rate", [10, 30, 60, 144])
def test_a_drops_last_tick_is_that_of_a_world(rate: int) -> None:
    for seed in range(20):
        world = World(BOARD, dt=1.0 / rate)
        world.add(seed)
        while world.awake:
            world.step()
        assert ticks_of(drop(BOARD, seed).duration, 1 / rate) == world.tick


@given(ticks=st.integers(1, 10**6), rate=st.integers(1, 1000), ulps=st.integers(-2, 2))
def test_the_last_tick_is_the_first_not_before_the_landing(
    ticks: int, rate: int, ulps: int
) -> None:
    dt = 1.0 / rate
    t = ticks * dt
    for _ in range(abs(ulps)):
        t = math.nextafter(t, math.inf if ulps > 0 else 0.0)
    found = ticks_of(t, 1 / rate)
    assert found * dt >= t
    assert found == 1 or (found - 1) * dt < t
