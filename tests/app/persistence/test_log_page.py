"""Another process reads the pages of a room's log; it cannot write, and it may die."""

import os
import signal
from pathlib import Path

import pytest
import sqlalchemy as sa

from plinko.app.errors import LedgerError
from plinko.app.persistence.ledger.database import Database, reader
from plinko.app.persistence.room_log import LogPage
from plinko.app.rooms.log import verify_log
from tests.kit.serving import serving
from tests.kit.waiting import lives, until

PAGE = LogPage("independent", 1, 0, 0, 10, marks=False)


def test_a_log_is_read_by_another_process_that_may_die(url: str) -> None:
    with (
        serving(database_url=url, drop_rate=1000.0) as server,
        server.client("/api/v1") as http,
    ):
        room = http.post("/rooms", json={"board": "triangle-8"}).json()["id"]
        for seed in range(3):
            http.post(f"/rooms/{room}/drops", json={"seed": seed}).raise_for_status()
        before = http.get(f"/rooms/{room}/log").json()
        (idle,) = server.services.computing.readers._idle
        pid = idle.pid
        assert pid not in (None, os.getpid())
        os.kill(pid, signal.SIGKILL)
        until(lambda: not lives(pid))
        after = http.get(f"/rooms/{room}/log").json()
    for log in (before, after):
        assert [each["seed"] for each in log["drops"]] == ["0", "1", "2"]
        assert verify_log(log).ok


def test_a_reader_of_a_ledger_cannot_write(url: str) -> None:
    database = Database(url)
    database.open()
    with (
        reader(url).connect() as connection,
        pytest.raises(sa.exc.DBAPIError, match=r"read-?only"),
    ):
        connection.execute(sa.text("DELETE FROM rooms"))
    database.close()


def test_reading_a_missing_file_creates_none(tmp_path: Path) -> None:
    with pytest.raises(LedgerError, match="cannot be read"):
        PAGE.elsewhere(f"sqlite:///{tmp_path / 'plinko.db'}")
    assert not list(tmp_path.iterdir())
