"""A page of a room's log, as the bytes that are sent and those that its digest covers.

It is made in a process of its own wherever the ledger is no part of the server's memory: rows and
JSON in a thread beside the event loop keep the interpreter from the ticks.
"""

import functools
from dataclasses import dataclass
from typing import Final

import msgspec
import sqlalchemy as sa
from sqlalchemy import Connection, Engine

from app.errors import LedgerError
from app.persistence.ledger.database import reader, reason
from app.persistence.statements import store
from app.rooms import log
from app.rooms.kinds import format_of

_MARKS: Final = frozenset({"who"})


@dataclass(frozen=True, slots=True)
class Entries:
    """So many entries of a log: as JSON without the list's brackets, and as lines of the digest."""

    count: int
    text: bytes
    lines: bytes


NONE: Final = Entries(0, b"", b"")


@dataclass(frozen=True, slots=True)
class LogPage:
    """Which entries of the log of which run, of a room of this `mode` that is at this `tick`.

    `limit` of them from `first` on; players' `marks` are null unless they are asked for.
    """

    mode: str
    run: int
    tick: int
    first: int
    limit: int
    marks: bool

    def entries(self, connection: Connection) -> Entries:
        """What the ledger has of it; raises DamagedRoomError."""
        inputs = format_of(self.mode)
        found = store.taken(connection, inputs.name, self.run, self.first, self.limit)
        page = [inputs.entry(row, result, self.tick) for row, result in found]
        if not self.marks:
            for entry in page:
                entry.update(dict.fromkeys(_MARKS & entry.keys()))
        return Entries(len(page), msgspec.json.encode(page)[1:-1], log.lines(page))

    def elsewhere(self, url: str) -> Entries:
        """`entries`, for a process without a connection to the ledger; raises LedgerError."""
        try:
            with _reader(url).connect() as connection:
                return self.entries(connection)
        except sa.exc.SQLAlchemyError as error:
            # Not from it: what a driver raises holds statements, and is not made for pickling.
            raise LedgerError(f"the ledger cannot be read: {reason(error)}") from None


@functools.lru_cache(maxsize=1)
def _reader(url: str) -> Engine:
    return reader(url)
