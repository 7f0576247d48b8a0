"""`prune` deletes the rooms closed long ago, with all their rows, and old drops of others."""

import time
from dataclasses import replace
from pathlib import Path

import pytest
import sqlalchemy as sa

from plinko.app.cli import main
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.statements import tables, writing
from plinko.app.rooms.records import BoardRow, Close, DropRow, NewInput, ResultRow, RoomRow, Write
from tests.kit.facts import new

DAY = 86400.0
BOARD = "b" * 64


def fill(url: str, folder: Path) -> None:
    """Three old rooms with a drop each: 1 closed 100 days ago, 2 closed yesterday, 3 open."""
    now = time.time()
    old = RoomRow(1, "r1", BOARD, "independent", True, 60, 1, now - 200 * DAY, now - 200 * DAY)
    writes: list[Write] = [BoardRow(BOARD, "board", "{}")]
    writes += [replace(old, number=number, id=f"r{number}") for number in (1, 2, 3)]
    for room in (1, 2, 3):
        writes.append(new(DropRow(room, 0, 0, 7)))
        writes.append(ResultRow(room, 0, 9, 1, 1.0, 0.1, 0.0, "d" * 64, None))
        writes.append(NewInput(room, 0, "{}"))
    writes += [Close(1, 9, now - 100 * DAY), Close(2, 9, now - DAY)]
    database = Database(url, beside=folder / "epoch")
    database.open()
    with database.transaction() as connection:
        writing.apply(connection, writes)
    database.close()


def rooms_of(url: str, folder: Path) -> dict[str, list[int]]:
    """The rooms that still have rows, for each table."""
    database = Database(url, beside=folder / "epoch")
    database.open()
    columns = {
        "rooms": tables.rooms.c.number,
        "drops": tables.drops.c.room,
        "inputs": tables.inputs.c.room,
        "results": tables.results.c.room,
    }
    with database.transaction() as connection:
        found = {
            name: sorted(connection.execute(sa.select(column)).scalars())
            for name, column in columns.items()
        }
        assert connection.scalar(sa.select(sa.func.count()).select_from(tables.boards)) == 1
    database.close()
    return found


def test_closed_rooms_that_are_old_enough_go_with_all_they_held(
    url: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fill(url, tmp_path)
    order = ["ledger", "prune", "--keep-days", "30", "--database-url", url, "--data", str(tmp_path)]
    assert main([*order, "--dry-run"]) == 0
    assert capsys.readouterr().out == "1 closed rooms, 2 drops, 1 inputs would be deleted\n"
    assert set(map(tuple, rooms_of(url, tmp_path).values())) == {(1, 2, 3)}
    assert main(order) == 0
    assert capsys.readouterr().out == "1 closed rooms, 2 drops, 1 inputs deleted\n"
    assert rooms_of(url, tmp_path) == {
        "rooms": [2, 3], "inputs": [2, 3], "drops": [3], "results": [3]
    }  # fmt: skip
    assert main(order) == 0
    assert capsys.readouterr().out == "0 closed rooms, 0 drops, 0 inputs deleted\n"


def test_the_file_gets_smaller(tmp_path: Path) -> None:
    file = tmp_path / "plinko.db"
    url = f"sqlite:///{file}"
    fill(url, tmp_path)
    database = Database(url)
    database.open()
    with database.transaction() as connection:
        writing.apply(connection, [new(DropRow(1, ball, 0, ball)) for ball in range(1, 16000)])
    database.close()
    before = file.stat().st_size
    assert main(["ledger", "prune", "--keep-days", "30", "--database-url", url]) == 0
    assert file.stat().st_size < before / 2


def test_a_ledger_that_is_in_use_or_is_not_there_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "plinko.db"
    order = ["ledger", "prune", "--keep-days", "30", "--database-url", f"sqlite:///{file}"]
    assert main(order) == 2
    assert "there is no ledger" in capsys.readouterr().err
    assert not file.exists()
    database = Database(f"sqlite:///{file}")
    database.open()
    assert main(order) == 1
    assert "another server uses it" in capsys.readouterr().err
    database.close()
