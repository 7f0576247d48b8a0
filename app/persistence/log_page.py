"""A page of a room's log: the bytes that are sent, and those that the log's digest covers.

Another process makes it unless the ledger is in the server's memory: a thread that reads rows and
encodes JSON would hold the interpreter's lock and delay the ticks.
"""

import functools
from dataclasses import dataclass
from typing import Final

import msgspec
import sqlalchemy as sa
from sqlalchemy import Connection, Engine

from plinko.app.errors import LedgerError
from plinko.app.persistence.ledger.database import reader, reason
from plinko.app.persistence.statements import store
from plinko.app.rooms import log
from plinko.app.rooms.kinds import format_of

_MARKS: Final = frozenset({"who"})  # an entry's fields with a player's mark


@dataclass(frozen=True, slots=True)
class Entries:
    """`count` entries of a log: as JSON without the list's brackets, and as the digest's lines."""

    count: int
    text: bytes
    lines: bytes


NONE: Final = Entries(0, b"", b"")


@dataclass(frozen=True, slots=True)
class LogPage:
    """Selects `limit` entries, from number `first` on, of the log of a run.

    `mode` and `tick` are those of the run's room. Without `marks`, players' marks become null.
    """

    mode: str
    run: int
    tick: int
    first: int
    limit: int
    marks: bool

    def entries(self, connection: Connection) -> Entries:
        """Read the entries; raises DamagedRoomError."""
        inputs = format_of(self.mode)
        found = store.stored_inputs(connection, inputs.name, self.run, self.first, self.limit)
        page = [inputs.entry(row, result, self.tick) for row, result in found]
        if not self.marks:
            for entry in page:
                entry.update(dict.fromkeys(_MARKS & entry.keys()))
        return Entries(len(page), msgspec.json.encode(page)[1:-1], log.lines(page))

    def elsewhere(self, url: str) -> Entries:
        """As `entries`, in a process that has no connection to the ledger; raises LedgerError."""
        try:
            with _reader(url).connect() as connection:
                return self.entries(connection)
        except sa.exc.SQLAlchemyError as error:
            # `from None`: the driver's error contains statements, and may not be picklable.
            raise LedgerError(f"the ledger cannot be read: {reason(error)}") from None


@functools.lru_cache(maxsize=1)
def _reader(url: str) -> Engine:
    return reader(url)
