"""A room's log as it is sent: in pieces, of which a long one's later pages are read on the way.

Commits wait while a page is read. So there is one page at a time for all who read, each is short,
and the ledger rests after it: a thousand readers slow down each other and no drop.
"""

import asyncio
import functools
import time
import weakref
from collections import Counter
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from typing import Any, Final

import msgspec
from sqlalchemy import Connection

from app.errors import BusyError, ReadersError
from app.persistence import store
from app.persistence.null_ledger import NullLedger
from app.persistence.sessions import Sessions
from app.persistence.writer import Ledger
from app.rooms import log
from app.rooms.room import Room

_MARKS: Final = frozenset({"who"})
_PAGE: Final = 250  # inputs read at once: some 5 ms
_REST: Final = 3.0  # times as long as a page took, the ledger has for others before the next
_LONGEST_REST: Final = 1.0  # s

MOST_READERS: Final = 32
MOST_OF_ONE: Final = 4


@dataclass(frozen=True, slots=True)
class LogPart:
    """Which of a room's inputs are asked for: `limit` of them from `first` on, None for all."""

    first: int = 0
    limit: int | None = None

    @property
    def whole(self) -> bool:
        """Whether that is the log itself, whose digest can be told."""
        return self.first == 0 and self.limit is None


WHOLE: Final = LogPart()


class RoomLogs:
    """The logs that are being read; for the event loop's thread. `clock` gives s."""

    def __init__(
        self,
        sessions: Sessions,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: "Callable[[float], Any]" = asyncio.sleep,
    ) -> None:
        self._sessions = sessions
        self._clock = clock
        self._sleep = sleep
        self._turn = asyncio.Lock()
        self._free = 0.0  # when the next page may be read
        self._readers: Counter[str] = Counter()

    @property
    def readers(self) -> int:
        """How many read now."""
        return self._readers.total()

    async def read(
        self,
        room: Room,
        reader: str,
        *,
        marks: bool,
        part: LogPart = WHOLE,
        session: int | None = None,
    ) -> AsyncIterator[bytes]:
        """The room's log as JSON in pieces, up to this moment, for a `reader` (an address).

        Of the session that goes on in the room, or of the one of this number, which is over.

        Players' `marks` are null in it unless they are asked for; its digest is of the log
        as given. It is asked for whole before the first piece is given, but for later pages of a
        long one. Raises LedgerError; BusyError and ReadersError when too many are read at a time.
        """
        if self.readers >= MOST_READERS:
            raise BusyError(f"{MOST_READERS} logs of rooms are being read already")
        if self._readers[reader] >= MOST_OF_ONE:
            raise ReadersError(f"{MOST_OF_ONE} logs of rooms are being read by this address")
        self._readers[reader] += 1
        place = _Place(functools.partial(self._left, reader))
        number = self._sessions.of(room).number if session is None else session
        pages = _Pages(self._sessions.ledger, number, room, self._paced, marks=marks, part=part)
        self._sessions.report([])
        return pages.pieces(await pages.read(part.first), place)

    def _left(self, reader: str) -> None:
        self._readers[reader] -= 1
        if not self._readers[reader]:
            del self._readers[reader]

    async def _paced(self, read: "Callable[[], Any]") -> Any:
        """What `read()` gives, in its turn and after the ledger's rest."""
        async with self._turn:
            if (rest := self._free - self._clock()) > 0.0:
                await self._sleep(rest)
            began = self._clock()
            try:
                return await read()
            finally:
                ended = self._clock()
                self._free = ended + min(_REST * (ended - began), _LONGEST_REST)


class _Place:
    """A reader's place, given up when nobody holds it any more: what was never begun, too."""

    def __init__(self, leave: Callable[[], None]) -> None:
        weakref.finalize(self, leave)


class _Pages:
    """A room's log as of now; `paced` reads a page in its turn."""

    def __init__(
        self,
        ledger: Ledger | NullLedger,
        session: int,
        room: Room,
        paced: "Callable[..., Any]",
        *,
        marks: bool,
        part: LogPart,
    ) -> None:
        self._marks = marks
        self._part = part
        self._ledger = ledger
        self._paced = paced
        self._session = session
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
        entries = functools.partial(self._entries, first=first, limit=limit)
        found: list[dict[str, Any]] = await self._paced(
            functools.partial(self._ledger.read, entries)
        )
        return found

    def _entries(self, connection: Connection, first: int, limit: int) -> list[dict[str, Any]]:
        found = store.taken(connection, self._inputs.name, self._session, first, limit)
        page = [self._inputs.entry(row, result, self._head["tick"]) for row, result in found]
        if not self._marks:
            for entry in page:
                entry.update(dict.fromkeys(_MARKS & entry.keys()))
        return page

    async def pieces(self, page: list[dict[str, Any]], _place: _Place) -> AsyncIterator[bytes]:
        """All of it, from the first page on; for as long as this goes on a place is held."""
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
