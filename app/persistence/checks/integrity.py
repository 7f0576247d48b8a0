"""Checks the ledger's whole database in the background, once at each start."""

import asyncio
import logging
import sqlite3
import urllib.parse
from pathlib import Path
from typing import Final, Literal

import sqlalchemy as sa
from sqlalchemy import Connection

from plinko.app.errors import LedgerError
from plinko.app.persistence.ledger.database import Database, reason
from plinko.app.persistence.ledger.writer import Ledger

Finding = Literal["checking", "sound", "damaged", "unknown"]

_MOST: Final = 10  # findings that SQLite reports at most

_log = logging.getLogger("plinko")


class Integrity:
    """The result of the database's own check: SQLite's quick check, or PostgreSQL's checksums.

    Damage is logged and reported to the operator, but stops nothing: only rooms whose pages are
    damaged are set aside, when they are read.
    """

    def __init__(self, ledger: Ledger) -> None:
        self.finding: Finding = "checking"
        self._ledger = ledger

    async def look(self) -> None:
        """Check the database without blocking the event loop, and set `finding`."""
        database = self._ledger.database
        try:
            if database.in_memory:
                found: list[str] | None = []
            elif database.file is not None:
                found = await _quick_check(database.file)
            else:
                found = await self._ledger.read(checksum_failures)
        except (LedgerError, sqlite3.Error) as error:
            _log.warning("the ledger %s could not be checked: %s", database.name, error)
            found = None
        for line in found or ():
            _log.error("the ledger %s is damaged: %s", database.name, line)
        self.finding = "unknown" if found is None else "damaged" if found else "sound"


async def _quick_check(file: Path) -> list[str]:
    """SQLite's findings about its file, over a private connection on another thread."""
    connection = sqlite3.connect(
        f"file:{urllib.parse.quote(str(file))}?mode=ro", uri=True, check_same_thread=False
    )
    try:
        return await asyncio.to_thread(check_pages, connection, "quick_check")
    except asyncio.CancelledError:
        connection.interrupt()
        raise


def check_pages(connection: sqlite3.Connection, pragma: str) -> list[str]:
    """The findings of SQLite's `quick_check` or `integrity_check`; closes the connection."""
    try:
        rows = connection.execute(f"PRAGMA {pragma}({_MOST})").fetchall()
    except sqlite3.DatabaseError as error:
        if type(error) is not sqlite3.DatabaseError:
            raise
        return [str(error)]
    finally:
        connection.close()
    return [line for (line,) in rows if line != "ok"]


def check_database(database: Database) -> list[str]:
    """The findings of a database's most thorough check, which may take long.

    PostgreSQL: failed checksums, and the findings of the extension `amcheck` if it is installed.
    """
    if database.file is not None:
        return check_pages(sqlite3.connect(database.file), "integrity_check")
    with database.transaction() as connection:
        return [*(checksum_failures(connection) or ()), *_amcheck(connection)]


def _amcheck(connection: Connection) -> list[str]:
    """The findings of `amcheck` about tables and indexes; [] if it is not installed."""
    installed = "SELECT 1 FROM pg_extension WHERE extname = 'amcheck'"
    if connection.execute(sa.text(installed)).scalar() is None:
        return []
    found = []
    inspector = sa.inspect(connection)
    for table in inspector.get_table_names():
        heap = "SELECT blkno, msg FROM verify_heapam(:name)"
        for block, message in connection.execute(sa.text(heap), {"name": table}):
            found.append(f"table {table}, block {block}: {message}")
        indexes = [each["name"] for each in inspector.get_indexes(table)]
        for index in filter(None, [*indexes, inspector.get_pk_constraint(table)["name"]]):
            try:
                with connection.begin_nested():
                    connection.execute(
                        sa.text("SELECT bt_index_check(:name, true)"), {"name": index}
                    )
            except sa.exc.DBAPIError as error:
                found.append(f"index {index}: {reason(error)}")
    return found


def checksum_failures(connection: Connection) -> list[str] | None:
    """The count of failed checksums, as findings; None if PostgreSQL keeps no checksums."""
    count = connection.execute(
        sa.text("SELECT checksum_failures FROM pg_stat_database WHERE datname = current_database()")
    ).scalar()
    if count is None:
        return None
    return [f"{count} pages with a wrong checksum were read"] if count else []
