"""A look at the ledger's whole database, beside all else, once at each start."""

import asyncio
import logging
import sqlite3
import urllib.parse
from pathlib import Path
from typing import Final, Literal

import sqlalchemy as sa
from sqlalchemy import Connection

from app.errors import LedgerError
from app.persistence.writer import Ledger

Finding = Literal["checking", "sound", "damaged", "unknown"]

_MOST: Final = 10  # findings of SQLite that are told

_log = logging.getLogger("plinko")


class Integrity:
    """What the database says of itself: SQLite by its quick check, PostgreSQL by its checksums.

    It stops nothing. Rooms whose pages are damaged are set aside when they are read, the others
    play; that something is wrong is told, so that somebody sees to it.
    """

    def __init__(self, ledger: Ledger) -> None:
        self.finding: Finding = "checking"
        self._ledger = ledger

    async def look(self) -> None:
        """Find out; for the event loop, which goes on meanwhile."""
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
    """What SQLite finds wrong with its file, over a connection of its own."""
    connection = sqlite3.connect(
        f"file:{urllib.parse.quote(str(file))}?mode=ro", uri=True, check_same_thread=False
    )
    try:
        return await asyncio.to_thread(check_pages, connection, "quick_check")
    except asyncio.CancelledError:
        connection.interrupt()
        raise


def check_pages(connection: sqlite3.Connection, pragma: str) -> list[str]:
    """What SQLite's `quick_check` or `integrity_check` finds wrong; closes the connection."""
    try:
        rows = connection.execute(f"PRAGMA {pragma}({_MOST})").fetchall()
    except sqlite3.DatabaseError as error:
        if type(error) is not sqlite3.DatabaseError:
            raise
        return [str(error)]
    finally:
        connection.close()
    return [line for (line,) in rows if line != "ok"]


def checksum_failures(connection: Connection) -> list[str] | None:
    """What PostgreSQL found wrong as it read its pages; None where it keeps no checksums."""
    count = connection.execute(
        sa.text("SELECT checksum_failures FROM pg_stat_database WHERE datname = current_database()")
    ).scalar()
    if count is None:
        return None
    return [f"{count} pages were read whose checksum is wrong"] if count else []
