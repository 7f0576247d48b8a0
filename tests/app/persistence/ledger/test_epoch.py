"""A server refuses a ledger that is not as it left it, and only that; one file has one server."""

import os
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

from plinko.app.errors import SettingError
from plinko.app.persistence.ledger.database import Database, InDoubtError
from plinko.app.persistence.ledger.epoch import EpochFile, Place
from plinko.app.persistence.statements import store, writing
from plinko.app.rooms.records import BoardRow
from tests.app.persistence.crash.life import look


class EndError(BaseException):
    """The process ends here."""


def url_of(file: Path) -> str:
    return f"sqlite:///{file}"


def commit(database: Database, *boards: int) -> None:
    for number in boards:
        with database.batch() as connection:
            writing.apply(connection, [BoardRow(f"{number:064}", "board", "{}")])


def holds(url: str, number: int) -> bool:
    return look(url, store.board, f"{number:064}") is not None


def start(url: str, beside: Path | None = None, *, shared: bool = False) -> None:
    """Start and stop a server; raises SettingError if it refuses the ledger."""
    database = Database(url, shared=shared, beside=beside)
    database.open()
    database.close()


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
    start(url_of(killed))
    assert [holds(url_of(killed), number) for number in (1, 2, 3, 4)] == [True] * 4


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
        with pytest.raises(SettingError, match=r"or lost its write-ahead log \(plinko\.db-wal\)"):
            start(url_of(killed))
    assert not holds(url_of(killed), 4)


def test_a_file_that_is_gone_is_no_empty_start(killed: Path) -> None:
    killed.unlink()
    with pytest.raises(SettingError, match=r"file is missing, but .*db-epoch, which belongs to it"):
        start(url_of(killed))
    assert not killed.exists()


def test_a_first_life_whose_log_is_gone_is_no_empty_start(tmp_path: Path) -> None:
    file, place = tmp_path / "plinko.db", tmp_path / "killed"
    place.mkdir()
    database = Database(url_of(file))
    database.open()
    commit(database, 1)
    shutil.copy(file, place)
    shutil.copy(f"{file}-epoch", place)
    database.close()
    with pytest.raises(SettingError, match="lacks the start that the file of its epoch"):
        start(url_of(place / "plinko.db"))


def test_a_log_whose_commits_are_all_in_the_file_may_go(killed: Path) -> None:
    sqlite3.connect(killed).execute("PRAGMA wal_checkpoint(TRUNCATE)").connection.close()
    log_of(killed).unlink(missing_ok=True)
    start(url_of(killed))
    assert holds(url_of(killed), 4)


def test_a_lost_or_damaged_epoch_is_named(killed: Path) -> None:
    beside = killed.with_name("plinko.db-epoch")
    said = beside.read_bytes()
    beside.unlink()
    with pytest.raises(SettingError, match=r"plinko\.db-epoch, which belongs to it, is missing"):
        start(url_of(killed))
    assert not beside.exists()
    for damaged in (b"four\n", said[:-3], said + said, b"\xff" * len(said), b""):
        beside.write_bytes(damaged)
        with pytest.raises(SettingError, match=r"contains b['\"].* instead of an epoch"):
            start(url_of(killed))
    beside.write_bytes(said)
    start(url_of(killed))
    assert beside.stat().st_mode & 0o777 == 0o600


class Backups:
    """A ledger on either database, of which a test takes and restores backups."""

    def __init__(self, url: str, folder: Path) -> None:
        self.url, self.beside = url, folder / "data" / "epoch"
        self.file = Path(url.removeprefix("sqlite:///")) if url.startswith("sqlite") else None
        self.database = Database(url, beside=self.beside)

    def take(self) -> list[tuple[str, int]]:
        """The ledger's epochs and commits, which stand for a backup."""
        found: list[tuple[str, int]] = look(self.url, lambda c: [tuple(row) for row in
            c.exec_driver_sql("SELECT name, batch FROM writers")])  # fmt: skip
        return found

    def restore(self, backup: list[tuple[str, int]]) -> None:
        def back(connection: object) -> None:
            connection.exec_driver_sql("DELETE FROM writers")  # type: ignore[attr-defined]
            for name, batch in backup:
                connection.exec_driver_sql(  # type: ignore[attr-defined]
                    "INSERT INTO writers (name, batch, epoch, former) "
                    f"VALUES ('{name}', {batch}, 0, '')"
                )

        look(self.url, back)


def test_an_older_state_is_refused_and_the_present_one_is_not(url: str, tmp_path: Path) -> None:
    ledger = Backups(url, tmp_path)
    states = []
    for boards in ((), (1, 2), (3,)):
        ledger.database.open()
        commit(ledger.database, *boards)
        ledger.database.close()
        states.append(ledger.take())
    ledger.database.open()
    commit(ledger.database, 4)
    ledger.database.close()
    states += [[(name, batch) for name, batch in ledger.take() for batch in (0,)]]
    present = ledger.take()
    for state in states:
        ledger.restore(state)
        with pytest.raises(SettingError, match="plinko ledger restore"):
            start(url, ledger.beside)
    ledger.restore(present)
    start(url, ledger.beside)


def test_without_a_file_beside_it_nothing_is_noticed_on_postgresql(
    url: str, tmp_path: Path
) -> None:
    if url.startswith("sqlite"):
        pytest.skip("SQLite's file always has one beside it")
    ledger = Backups(url, tmp_path)
    start(url, ledger.beside)
    backup = ledger.take()
    start(url, ledger.beside)
    ledger.restore(backup)
    with pytest.raises(SettingError, match="lacks the start that the file of its epoch"):
        start(url, ledger.beside)
    start(url)
    other = tmp_path / "other" / "epoch"
    with pytest.raises(SettingError, match="which belongs to it, is missing"):
        start(url, other)
    start(url, other, shared=True)  # a server that joins others
    start(url, other, shared=True)


STEPS = ("entered", "drafted", "replaced", "begun", "committed", "noted")


@pytest.mark.parametrize("step", STEPS)
def test_a_process_that_ends_between_two_steps_leaves_what_the_next_accepts(
    url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    """Three times in a row, so that the remains of one death meet the next one."""
    beside = tmp_path / "data" / "epoch"
    start(url, beside)
    for number in range(3):
        with monkeypatch.context() as patch:
            end_at(patch, step)
            database = Database(url, beside=beside)
            with pytest.raises(EndError):
                begin_and_commit(database, number)
        database.close()
        start(url, beside)
        assert holds(url, number) == (step in ("committed", "noted"))
    assert len(Backups(url, tmp_path).take()) <= 5, "former epochs go, but for those of no file"


def begin_and_commit(database: Database, number: int) -> None:
    database.open()
    commit(database, number)


def end_at(patch: pytest.MonkeyPatch, step: str) -> None:
    """End the process at this step of a start, or of the first commit after it."""
    begin, note, replace = EpochFile.begin, EpochFile.note, os.replace

    def ends(*values: object) -> None:
        raise EndError

    def replaced(*names: str) -> None:
        replace(*names)
        raise EndError

    def begun(beside: EpochFile, place: Place) -> None:
        begin(beside, place)
        raise EndError

    def noted(beside: EpochFile, number: int) -> None:
        note(beside, number)
        raise EndError

    match step:
        case "entered":
            patch.setattr(EpochFile, "begin", ends)
        case "drafted":
            patch.setattr(os, "replace", ends)
        case "replaced":
            patch.setattr(os, "replace", replaced)
        case "begun":
            patch.setattr(EpochFile, "begin", begun)
        case "committed":
            patch.setattr(EpochFile, "note", ends)
        case "noted":
            patch.setattr(EpochFile, "note", noted)


def test_a_commit_is_acknowledged_only_when_its_number_is_beside_the_ledger(
    url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(beside: EpochFile, number: int) -> None:
        raise OSError("no room")

    beside = tmp_path / "data" / "epoch"
    database = Database(url, beside=beside)
    database.open()
    monkeypatch.setattr(EpochFile, "note", full)
    with pytest.raises(InDoubtError, match="no room"):
        commit(database, 1)
    with pytest.raises(OSError, match="no room"):
        database.has_batch()
    monkeypatch.undo()
    assert database.has_batch()
    commit(database, 2)
    place = database.place()
    assert place is not None
    assert place.commit == 2
    database.close()
    start(url, beside)


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
    assert holds(url_of(file), 1)


def test_a_file_of_two_names_is_refused(killed: Path) -> None:
    os.link(killed, killed.with_name("other.db"))
    with pytest.raises(SettingError, match="has 2 names"):
        Database(url_of(killed)).open()
    killed.with_name("other.db").unlink()
    assert holds(url_of(killed), 4)
