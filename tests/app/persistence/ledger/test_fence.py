"""The server notices lost commits, and one file has one server, also by another path."""

import os
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest
import sqlalchemy as sa

from app.errors import SettingError
from app.persistence.ledger.database import Database
from app.persistence.ledger.fence import Fence
from app.persistence.statements import store, writing
from app.rooms.records import BoardRow, DropRow
from tests.app.persistence.crash.life import look
from tests.kit.facts import new


def url_of(file: Path) -> str:
    return f"sqlite:///{file}"


def commit(database: Database, *boards: int) -> None:
    for number in boards:
        with database.transaction() as connection:
            writing.apply(connection, [BoardRow(f"{number:064}", "board", "{}")])


def holds(file: Path, number: int) -> bool:
    return look(url_of(file), store.board, f"{number:064}") is not None


@pytest.fixture
def killed(tmp_path: Path) -> Path:
    """The file of a killed server: of commits 1 to 4, the last two are only in the log."""
    file, place = tmp_path / "plinko.db", tmp_path / "killed"
    place.mkdir()
    database = Database(url_of(file))
    database.open()
    commit(database, 1, 2)
    database.close()
    database.open()
    commit(database, 3, 4)
    for each in tmp_path.glob("plinko.db*"):
        shutil.copy(each, place)
    database.close()
    return place / "plinko.db"


def test_after_a_kill_all_of_it_is_there(killed: Path) -> None:
    assert [holds(killed, number) for number in (1, 2, 3, 4)] == [True] * 4


def log_of(file: Path) -> Path:
    return file.with_name(f"{file.name}-wal")


def cut(log: Path) -> None:
    os.truncate(log, log.stat().st_size - 100)


def empty(log: Path) -> None:
    os.truncate(log, 0)


def flip(log: Path) -> None:
    found = bytearray(log.read_bytes())
    found[-200] ^= 1
    log.write_bytes(found)


@pytest.mark.parametrize("harm", [Path.unlink, cut, flip, empty])
def test_a_log_that_was_cut_taken_away_or_harmed_is_noticed(
    killed: Path, harm: Callable[[Path], object]
) -> None:
    harm(log_of(killed))
    for _ in range(2):
        with pytest.raises(SettingError, match=r"lost its last commits.*has commit 4"):
            Database(url_of(killed)).open()
    killed.with_name("plinko.db-fence").unlink()
    assert [holds(killed, 1), holds(killed, 4)] == [True, False], "on demand it goes on"
    assert killed.with_name("plinko.db-fence").exists()


def test_a_first_life_whose_log_is_gone_is_no_empty_start(tmp_path: Path) -> None:
    file, place = tmp_path / "plinko.db", tmp_path / "killed"
    place.mkdir()
    database = Database(url_of(file))
    database.open()
    commit(database, 1)
    shutil.copy(file, place)
    shutil.copy(f"{file}-fence", place)
    database.close()
    with pytest.raises(SettingError, match=r"at commit 0, but plinko\.db-fence"):
        Database(url_of(place / "plinko.db")).open()


def test_a_file_that_is_gone_is_no_empty_start(killed: Path) -> None:
    killed.unlink()
    with pytest.raises(SettingError, match=r"no such file, but plinko\.db-fence next to it"):
        Database(url_of(killed)).open()
    assert not killed.exists()


def test_a_log_whose_commits_are_all_in_the_file_may_go(killed: Path) -> None:
    sqlite3.connect(killed).execute("PRAGMA wal_checkpoint(TRUNCATE)").connection.close()
    log_of(killed).unlink(missing_ok=True)
    assert holds(killed, 4)


def test_a_missing_fence_is_made_and_an_invalid_one_named(
    killed: Path,
) -> None:
    fence = killed.with_name("plinko.db-fence")
    fence.unlink()
    assert holds(killed, 4)
    assert (fence.read_text(), fence.stat().st_mode & 0o777) == ("0000000004\n", 0o600)
    fence.write_text("four\n")
    with pytest.raises(SettingError, match=r"plinko\.db-fence contains 'four\\n' instead of"):
        Database(url_of(killed)).open()


def test_only_what_changes_something_is_counted(tmp_path: Path) -> None:
    database = Database(url_of(tmp_path / "plinko.db"))
    database.open()
    commit(database, 1)
    for _ in range(3):
        with database.transaction() as connection:
            store.last_number(connection)
    with pytest.raises(sa.exc.IntegrityError), database.transaction() as connection:
        writing.apply(connection, [BoardRow("b" * 64, "board", "{}"), new(DropRow(1, 0, 0, 1))])
    fence = tmp_path / "plinko.db-fence"
    assert int(fence.read_text()) == 1
    database.disconnect()
    commit(database, 2)
    assert int(fence.read_text()) == 2
    database.close()


@pytest.mark.parametrize(("number", "beside", "sound"), [
    (0, (1 << 31) - 1, True), ((1 << 31) - 1, 0, False), (7, 7, True), (8, 7, True), (6, 7, False),
])  # fmt: skip
def test_numbers_that_wrap_around_compare_the_nearer_way(
    tmp_path: Path, number: int, beside: int, sound: bool
) -> None:
    file = tmp_path / "plinko.db"
    database = Database(url_of(file))
    database.open()
    database.close()
    plain = sqlite3.connect(file)
    plain.execute(f"PRAGMA user_version = {number}")
    plain.close()
    file.with_name("plinko.db-fence").write_text(f"{beside}\n")
    if not sound:
        with pytest.raises(SettingError, match="has lost"):
            database.open()
        return
    database.open()
    commit(database, 1)
    database.close()
    assert int(file.with_name("plinko.db-fence").read_text()) == (number + 1) % (1 << 31)


def test_a_number_that_cannot_be_written_fails_no_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(fence: Fence) -> None:
        raise OSError("no room")

    database = Database(url_of(tmp_path / "plinko.db"))
    database.open()
    monkeypatch.setattr(Fence, "_write", full)
    commit(database, 1)
    monkeypatch.undo()
    database.close()
    assert "plinko.db-fence cannot be written: no room" in caplog.text
    assert holds(tmp_path / "plinko.db", 1)


# One server at a time.


def test_a_second_server_through_a_link_is_refused(tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    file, link = tmp_path / "here" / "plinko.db", tmp_path / "there" / "linked.db"
    link.symlink_to(file)
    (tmp_path / "folder").symlink_to(tmp_path / "here")
    first = Database(url_of(link))
    first.open()
    commit(first, 1)
    for name in (file, link, tmp_path / "folder" / "plinko.db"):
        with pytest.raises(SettingError, match="another server uses it"):
            Database(url_of(name)).open()
    first.close()
    assert [path.name for path in (tmp_path / "there").iterdir()] == ["linked.db"]
    assert holds(file, 1)


def test_a_file_of_two_names_is_refused(killed: Path) -> None:
    os.link(killed, killed.with_name("other.db"))
    with pytest.raises(SettingError, match="has 2 names"):
        Database(url_of(killed)).open()
    killed.with_name("other.db").unlink()
    assert holds(killed, 4)
