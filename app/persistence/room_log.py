"""A room's log as it is sent: in pieces, of which a long one's later pages are read on the way."""

import functools
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any, Final

import msgspec
from sqlalchemy import Connection

from app.persistence import store
from app.persistence.null_ledger import NullLedger
from app.persistence.writer import Ledger
from app.rooms import log
from app.rooms.room import Room

_MARKS: Final = frozenset({"who"})
_PAGE: Final = 500  # inputs read and hashed at once; commits, then ticks, wait meanwhile


@dataclass(frozen=True, slots=True)
class LogPart:
    """Which of a room's inputs are asked for: `limit` of them from `first` on, None for all.

    Players' `marks` are null unless they are asked for; a digest is of the log as given.
    """

    first: int = 0
    limit: int | None = None
    marks: bool = False

    @property
    def whole(self) -> bool:
        """Whether that is the log itself, whose digest can be told."""
        return self.first == 0 and self.limit is None


async def read_log(
    ledger: Ledger | NullLedger, room: Room, session: int, part: LogPart
) -> AsyncIterator[bytes]:
    """The log of a room's session as JSON in pieces, up to this moment; raises LedgerError.

    It is asked for whole before the first piece is given, but for later pages of a long one.
    """
    pages = _Pages(ledger, room, session, part)
    first = await pages.read(part.first)
    return pages.pieces(first)


class _Pages:
    """A room's log as of now."""

    def __init__(
        self, ledger: Ledger | NullLedger, room: Room, session: int, part: LogPart
    ) -> None:
        self._ledger = ledger
        self._session = session
        self._part = part
        self._inputs = room.format
        count = room.taken
        self._end = count if part.limit is None else min(count, part.first + part.limit)
        self._next = self._end if self._end < count else None
        self._head = log.head(room)

    async def read(self, first: int) -> list[dict[str, Any]]:
        """Entries from `first` on, as many as a page has."""
        if first >= self._end:
            return []
        limit = min(_PAGE, self._end - first)
        return await self._ledger.read(functools.partial(self._entries, first=first, limit=limit))

    def _entries(self, connection: Connection, first: int, limit: int) -> list[dict[str, Any]]:
        found = store.taken(connection, self._inputs.name, self._session, first, limit)
        page = [self._inputs.entry(row, result, self._head["tick"]) for row, result in found]
        if not self._part.marks:
            for entry in page:
                entry.update(dict.fromkeys(_MARKS & entry.keys()))
        return page

    async def pieces(self, page: list[dict[str, Any]]) -> AsyncIterator[bytes]:
        """All of it, from the first page on."""
        digest = log.LogDigest(self._head)
        yield msgspec.json.encode(self._head)[:-1] + f',"{self._inputs.name}":['.encode()
        done = self._part.first
        while page:
            digest.add(page)
            yield (b"," if done > self._part.first else b"") + msgspec.json.encode(page)[1:-1]
            done += len(page)
            page = await self.read(done)
        if self._part.whole:
            yield b'],"digest":"' + digest.hex().encode() + b'"}\n'
        else:
            rest = {"first": self._part.first, "next": self._next, "digest": None}
            yield b"]," + msgspec.json.encode(rest)[1:] + b"\n"
