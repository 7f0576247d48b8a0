"""A number beside SQLite's file by which a write-ahead log that was cut or removed is noticed.

What was committed is in the write-ahead log until SQLite moves it to the file. Take the log away,
and SQLite opens what the file held some time ago, or nothing at all, without a word. So each
transaction that changes something counts up a number in the database, and once that is durable the
same number is written to a file of its own. A database that is behind it has lost what it had.

The number in the database is `PRAGMA user_version`: it is in the header, goes with the transaction
and needs no table. SQLite's own change counter will not do, as it is not counted up by commits to
a write-ahead log. The number beside is written after the commit and without waiting for the disk:
after a power cut it may be older than the database, but it is never newer, so that it costs a few
microseconds and no sound ledger is ever refused.
"""

import logging
import os
from pathlib import Path
from typing import Final

from sqlalchemy import Connection

from app.errors import LedgerError

_MASK: Final = (1 << 31) - 1  # what a user_version holds without a sign
_HALF: Final = 1 << 30

_log = logging.getLogger("plinko")


class Fence:
    """The number beside `file`; for the ledger's thread."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._path = file.with_name(f"{file.name}-fence")
        self._descriptor: int | None = None
        self._number = 0  # of the last commit
        self._coming = 0  # of the transaction that is under way
        self._changes = 0  # of the connection when that began

    def check_presence(self) -> None:
        """Raise LedgerError when there was a database and now there is none."""
        found = self._read()
        if found and not self._file.exists():
            raise LedgerError(f"there is no such file, but {self._told(found)}")

    def open(self, connection: Connection) -> None:
        """Begin to count; raises LedgerError when the database is behind."""
        number = int(connection.exec_driver_sql("PRAGMA user_version").scalar() or 0)
        connection.commit()
        found = self._read()
        # Numbers begin again at 0 some day: which is ahead is told by the nearer way round.
        if found is not None and (number - found) & _MASK >= _HALF:
            raise LedgerError(
                f"it has lost what was written last: it is at commit {number}, but "
                f"{self._told(found)}"
            )
        self._number = number
        self._descriptor = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o600)
        self._write()
        os.fsync(self._descriptor)

    def begin(self, connection: Connection) -> None:
        self._changes, self._coming = _changes(connection), self._number

    def count(self, connection: Connection) -> None:
        """It is about to be committed: count it if it changes anything."""
        if _changes(connection) != self._changes:
            self._coming = (self._number + 1) & _MASK
            connection.exec_driver_sql(f"PRAGMA user_version = {self._coming}")

    def committed(self) -> None:
        if self._coming == self._number:
            return
        self._number = self._coming
        try:
            self._write()
        except OSError as error:
            # The commit stands. The number lags behind, which is what it may.
            _log.warning("%s cannot be written: %s", self._path, error)

    def close(self) -> None:
        """Have the number on the disk."""
        if self._descriptor is not None:
            os.fsync(self._descriptor)
            os.close(self._descriptor)
            self._descriptor = None

    def _read(self) -> int | None:
        """The number beside; None where there is none yet."""
        try:
            text = self._path.read_text(encoding="ascii")
        except FileNotFoundError:
            return None
        if not text.strip().isdecimal():
            raise LedgerError(f"{self._path} holds {text!r:.40} where a number should be")
        return int(text)

    def _write(self) -> None:
        assert self._descriptor is not None
        # Always as long, in place: it takes no room on a disk that is full.
        os.pwrite(self._descriptor, b"%010d\n" % self._number, 0)

    def _told(self, found: int) -> str:
        return (
            f"{self._path.name} beside it tells of commit {found}. Was its write-ahead log "
            f"({self._file.name}-wal) cut or taken away, or a backup put in its place? Put back "
            f"what is missing, or delete {self._path.name} to go on with what is there"
        )


def _changes(connection: Connection) -> int:
    """Rows that this connection has changed so far."""
    driver = connection.connection.driver_connection
    assert driver is not None
    changes: int = driver.total_changes
    return changes
