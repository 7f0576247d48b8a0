"""A room's log as it is sent: in pieces, of which a long one's later pages are read on the way."""

import functools
from collections.abc import AsyncIterator
from typing import Any, Final

import msgspec
from sqlalchemy import Connection

from app.persistence import store
from app.persistence.sessions import Sessions
from app.rooms import log
from app.rooms.room import Room

_MARKS: Final = frozenset({"who"})
_PAGE: Final = 500  # inputs read and hashed at once; commits, then ticks, wait meanwhile


async def read_log(sessions: Sessions, room: Room, *, marks: bool) -> AsyncIterator[bytes]:
    """The room's log as JSON in pieces, up to this moment; raises LedgerError.

    Players' `marks` are null in it unless they are asked for; its digest is of the log as given.

    It is asked for whole before the first piece is given, but for later pages of a long one.
    """
    pages = _Pages(sessions, room, marks)
    sessions.report([])
    first = await pages.read(0)
    return pages.pieces(first)


class _Pages:
    """A room's log as of now."""

    def __init__(self, sessions: Sessions, room: Room, marks: bool) -> None:
        self._marks = marks
        self._ledger = sessions.ledger
        self._session = sessions.of(room).number
        self._inputs = room.format
        self._count = room.taken
        self._head = log.head(room)

    async def read(self, first: int) -> list[dict[str, Any]]:
        """Entries from `first` on, as many as a page has."""
        if first >= self._count:
            return []
        limit = min(_PAGE, self._count - first)
        return await self._ledger.read(functools.partial(self._entries, first=first, limit=limit))

    def _entries(self, connection: Connection, first: int, limit: int) -> list[dict[str, Any]]:
        found = store.taken(connection, self._inputs.name, self._session, first, limit)
        page = [self._inputs.entry(row, result, self._head["tick"]) for row, result in found]
        if not self._marks:
            for entry in page:
                entry.update(dict.fromkeys(_MARKS & entry.keys()))
        return page

    async def pieces(self, page: list[dict[str, Any]]) -> AsyncIterator[bytes]:
        """All of it, from the first page on."""
        digest = log.LogDigest(self._head)
        yield msgspec.json.encode(self._head)[:-1] + f',"{self._inputs.name}":['.encode()
        done = 0
        while page:
            digest.add(page)
            yield (b"," if done else b"") + msgspec.json.encode(page)[1:-1]
            done += len(page)
            page = await self.read(done)
        yield b'],"digest":"' + digest.hex().encode() + b'"}\n'
