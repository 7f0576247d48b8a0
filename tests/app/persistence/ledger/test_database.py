"""Opening a ledger: address, tables, one server at a time; errors name the reason."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import sqlalchemy as sa

from plinko.app.errors import DamagedRoomError, SettingError
from plinko.app.persistence.ledger.database import HEAD, Database, address
from plinko.app.persistence.statements import store, tables, writing
from plinko.app.rooms.records import BoardRow, DropRow, ResultRow, RoomRow, Write
from tests.kit.facts import new
from tests.kit.postgres import PostgreSQL
from tests.kit.waiting import until


def test_records_read_by_position_match_the_order_of_columns() -> None:
    assert DropRow.__slots__ == tuple(store.FACTS.selected_columns.keys())
    assert ResultRow.__slots__ == tuple(tables.results.c.keys())


def test_what_is_written_is_read_to_the_last_bit(url: str) -> None:
    database = Database(url)
    database.open()
    drop = DropRow(1, 0, 2**40, 2**64 - 1, 0.1 + 2**-56, 10**9, "ann")
    room = RoomRow(1, "r", "b" * 64, "independent", True, 60, 1, 1.5, 2.5, checkpoint=b"\0\xff")
    with database.transaction() as connection:
        writing.apply(connection, [BoardRow("b" * 64, "board", "{}"), room, new(drop)])
    database.close()
    database.open()
    with database.transaction() as connection:
        assert store.drops(connection, 1, 0) == [(drop, None)]
        assert store.open_room(connection, "r") == room
        assert store.last_number(connection) == 1
    database.close()


def test_a_gap_in_the_drops_is_no_ledger(url: str) -> None:
    database = Database(url)
    database.open()
    room = RoomRow(1, "r", "b" * 64, "independent", True, 60, 1, 1.5, 2.5)
    board = BoardRow("b" * 64, "board", "{}")
    rows: list[Write] = [board, room, *(new(DropRow(1, ball, 0, 1)) for ball in range(3))]
    with database.transaction() as connection:
        writing.apply(connection, rows)
        connection.execute(sa.text("DELETE FROM drops WHERE ball = 1"))
        with pytest.raises(DamagedRoomError, match="lacks drop 1"):
            store.drops(connection, 1, 0)
    database.close()


def test_one_server_at_a_time(url: str) -> None:
    first, second = Database(url), Database(url)
    first.open()
    with pytest.raises(SettingError, match="another server uses it"):
        second.open()
    first.close()
    second.open()
    second.close()


def test_a_server_waits_until_the_one_before_leaves_postgresql(postgresql: PostgreSQL) -> None:
    url = postgresql.new_database()
    before, after = Database(url), Database(url)
    before.open()
    opening = ThreadPoolExecutor(1).submit(after.open)
    with before.transaction() as connection:
        waiting = sa.text(
            "SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND NOT granted"
        )
        until(lambda: connection.execute(waiting).scalar() or opening.done())
    before.close()
    opening.result()
    after.close()


def test_tables_of_a_later_release_are_refused(url: str) -> None:
    database = Database(url)
    database.open()
    with database.transaction() as connection:
        connection.execute(sa.text("UPDATE alembic_version SET version_num = '9999'"))
    database.close()
    with pytest.raises(SettingError, match=f"step '9999', but .* knows the steps up to '{HEAD}'"):
        database.open()


def test_a_transaction_that_fails_leaves_nothing(url: str) -> None:
    database = Database(url)
    database.open()
    board = BoardRow("b" * 64, "board", "{}")
    drop_of_no_room = new(DropRow(1, 0, 0, 1))
    with pytest.raises(sa.exc.IntegrityError), database.transaction() as connection:
        writing.apply(connection, [board, drop_of_no_room])
    with database.transaction() as connection:
        assert store.board(connection, "b" * 64) is None
    database.close()


def test_sqlite_waits_for_the_disk(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'new' / 'plinko.db'}")
    database.open()
    with database.transaction() as connection:
        pragma = {
            name: connection.exec_driver_sql(f"PRAGMA {name}").scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys")
        }
    database.close()
    assert pragma == {"journal_mode": "wal", "synchronous": 2, "foreign_keys": 1}
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("plinko.db", "is not an address such as sqlite:///plinko.db"),
        ("mysql://u:hidden@h/d", "neither sqlite:///FILE"),
        ("sqlite:///x.db?mode=ro", "neither sqlite:///FILE"),
    ],
)
def test_an_address_that_is_none_is_named_without_its_password(url: str, said: str) -> None:
    with pytest.raises(SettingError, match=said) as raised:
        address(url)
    assert "hidden" not in str(raised.value)


def test_a_missing_database_is_named_without_its_password(tmp_path: Path) -> None:
    for url in (
        f"postgresql://plinko:hidden@/none?host={tmp_path}",
        f"sqlite:///{tmp_path}",
        "sqlite:////proc/plinko/plinko.db",
    ):
        with pytest.raises(SettingError, match=r"the ledger .* cannot be opened: ") as raised:
            Database(url).open()
        assert "hidden" not in str(raised.value)
        assert "\n" not in str(raised.value)
