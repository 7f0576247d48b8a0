"""A high-water mark of commits next to SQLite's file, which detects a lost write-ahead log.

SQLite keeps commits in the write-ahead log until it moves them to the database file. If the log is
cut or removed, SQLite opens an older state, or an empty database, without an error. Therefore each
transaction that changes something increases a number in the database, and after its commit the
same number is written to a separate file, FILE-fence. A database behind that file has lost commits.

The number in the database is `PRAGMA user_version`: it is in the file's header, is part of the
transaction, and needs no table. (SQLite's own change counter does not count commits to a
write-ahead log.) FILE-fence is written after the commit, without waiting for the disk, which costs
a few microseconds. After a power cut it may be behind the database, but never ahead, so that an
intact ledger is never refused.
"""

import logging
import os
from pathlib import Path
from typing import Final

from sqlalchemy import Connection

from app.errors import LedgerError

_MASK: Final = (1 << 31) - 1  # the largest user_version, a signed 32-bit integer
_HALF: Final = 1 << 30

_log = logging.getLogger("plinko")


class Fence:
    """The high-water mark of the database `file`; for the ledger's thread."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._path = file.with_name(f"{file.name}-fence")
        self._descriptor: int | None = None
        self._number = 0  # of the last commit
        self._coming = 0  # of the current transaction
        self._changes = 0  # rows that the connection had changed when that began

    def check_presence(self) -> None:
        """Raise LedgerError if the mark shows that there was a database which is now missing."""
        found = self._read()
        if found and not self._file.exists():
            raise LedgerError(f"there is no such file, but {self._behind(found)}")

    def open(self, connection: Connection) -> None:
        """Begin to count; raises LedgerError if the database is behind the mark."""
        number = int(connection.exec_driver_sql("PRAGMA user_version").scalar() or 0)
        connection.commit()
        found = self._read()
        # Numbers wrap around to 0 after `_MASK`, so compare them modulo 2^31: a difference of half
        # of that or more means that the database is behind.
        if found is not None and (number - found) & _MASK >= _HALF:
            raise LedgerError(
                f"it has lost its last commits: it is at commit {number}, but {self._behind(found)}"
            )
        self._number = number
        self._descriptor = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o600)
        self._write()
        os.fsync(self._descriptor)

    def begin(self, connection: Connection) -> None:
        self._changes, self._coming = _changes(connection), self._number

    def count(self, connection: Connection) -> None:
        """Increase the number before the COMMIT of a transaction that has changed rows."""
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
            # The commit is durable. The mark may lag behind it.
            _log.warning("%s cannot be written: %s", self._path, error)

    def close(self) -> None:
        """Flush the mark to the disk."""
        if self._descriptor is not None:
            os.fsync(self._descriptor)
            os.close(self._descriptor)
            self._descriptor = None

    def _read(self) -> int | None:
        """The mark in the file; None if the file is missing."""
        try:
            text = self._path.read_text(encoding="ascii")
        except FileNotFoundError:
            return None
        if not text.strip().isdecimal():
            raise LedgerError(
                f"{self._path} contains {text!r:.40} instead of a number; delete it if you are "
                "sure that the database is complete"
            )
        return int(text)

    def _write(self) -> None:
        assert self._descriptor is not None
        # Overwritten in place with the same length, so that it works on a full disk too.
        os.pwrite(self._descriptor, b"%010d\n" % self._number, 0)

    def _behind(self, found: int) -> str:
        return (
            f"{self._path.name} next to it has commit {found}. Was its write-ahead log "
            f"({self._file.name}-wal) cut or removed, or a backup restored? Restore the missing "
            f"file, or delete {self._path.name} to continue with the database as it is"
        )


def _changes(connection: Connection) -> int:
    """The number of rows that this connection has changed."""
    driver = connection.connection.driver_connection
    assert driver is not None
    changes: int = driver.total_changes
    return changes
