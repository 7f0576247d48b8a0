"""A room's log as it is sent: in pieces, of which a long one's later pages are read on the way.

One page is read at a time, readers in turn. Each is short, and there is a rest after it: a thousand
readers slow down each other and no drop.
"""

import asyncio
import functools
import time
import weakref
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass
from typing import Final

import msgspec

from app.concurrency.fair_queue import FairLock
from app.errors import BusyError, ReadersError
from app.persistence.ledger.null_ledger import NullLedger
from app.persistence.log_page import NONE, Entries, LogPage
from app.persistence.room_runs import RoomRuns
from app.rooms import log
from app.rooms.room import Room

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


Compute = Callable[[Callable[[], Entries]], Awaitable[Entries]]
"""Does something in another process."""


class RoomLogs:
    """The logs that are being read; for the event loop's thread. `clock` gives s.

    Pages are read by `compute`, and without it, as where the ledger is in this process's memory, by
    the ledger's thread.
    """

    def __init__(
        self,
        runs: RoomRuns,
        compute: Compute | None = None,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: "Callable[[float], Awaitable[None]]" = asyncio.sleep,
    ) -> None:
        self._runs = runs
        self._compute = compute
        self._clock = clock
        self._sleep = sleep
        self._turns = FairLock()
        self._free = 0.0  # when the next page may be read
        self._readers: Counter[str] = Counter()

    @property
    def readers(self) -> int:
        return self._readers.total()

    async def read(
        self, room: Room, reader: str, *, marks: bool, part: LogPart = WHOLE, run: int | None = None
    ) -> AsyncIterator[bytes]:
        """The room's log as JSON in pieces, up to this moment, for a `reader` (an address).

        Of the run that goes on in the room, or of the one of this number, which is over.

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
        number = self._runs.of(room).number if run is None else run
        read = functools.partial(self._page, reader)
        pages = _Pages(number, room, read, marks=marks, part=part)
        self._runs.report([])
        await self._runs.ledger.settled()  # what has landed until now is in it then
        return pages.pieces(await pages.read(part.first), place)

    def _left(self, reader: str) -> None:
        self._readers[reader] -= 1
        if not self._readers[reader]:
            del self._readers[reader]

    async def _page(self, reader: str, page: LogPage) -> Entries:
        """A page in the reader's turn, after the rest that the one before has earned to others."""
        async with self._turns.turn(reader):
            if (rest := self._free - self._clock()) > 0.0:
                await self._sleep(rest)
            began = self._clock()
            try:
                return await self._read(page)
            finally:
                ended = self._clock()
                self._free = ended + min(_REST * (ended - began), _LONGEST_REST)

    async def _read(self, page: LogPage) -> Entries:
        ledger = self._runs.ledger
        if self._compute is None or isinstance(ledger, NullLedger):
            return await ledger.read(page.entries)
        # Who goes away meanwhile does not end the process that reads: the next has it at once.
        url = ledger.database.url.render_as_string(hide_password=False)
        return await asyncio.shield(self._compute(functools.partial(page.elsewhere, url)))


class _Place:
    """A reader's place, given up when nobody holds it any more: what was never begun, too."""

    def __init__(self, leave: Callable[[], None]) -> None:
        weakref.finalize(self, leave)


class _Pages:
    """A room's log as of now; `read` reads a page in its turn."""

    def __init__(
        self,
        run: int,
        room: Room,
        read: "Callable[[LogPage], Awaitable[Entries]]",
        *,
        marks: bool,
        part: LogPart,
    ) -> None:
        self._marks = marks
        self._part = part
        self._read = read
        self._run = run
        self._mode = room.mode
        self._name = room.format.name
        count = room.taken
        self._end = count if part.limit is None else min(count, part.first + part.limit)
        self._next = self._end if self._end < count else None
        self._head = log.head(room)

    async def read(self, first: int) -> Entries:
        limit = min(_PAGE, self._end - first)
        if limit <= 0:
            return NONE
        tick = self._head["tick"]
        return await self._read(LogPage(self._mode, self._run, tick, first, limit, self._marks))

    async def pieces(self, page: Entries, _place: _Place) -> AsyncIterator[bytes]:
        """All of it, from the first page on; for as long as this goes on a place is held."""
        digest = log.LogDigest(self._head)
        yield msgspec.json.encode(self._head)[:-1] + f',"{self._name}":['.encode()
        done = self._part.first
        while page.count:
            digest.add_lines(page.lines)
            yield (b"," if done > self._part.first else b"") + page.text
            done += page.count
            page = await self.read(done)
        if self._part.whole:
            yield b'],"digest":"' + digest.hex().encode() + b'"}\n'
        else:
            rest = {"first": self._part.first, "next": self._next, "digest": None}
            yield b"]," + msgspec.json.encode(rest)[1:] + b"\n"
