"""Streams room logs: later pages of a long log are read while the earlier ones are sent.

Only one page is read at a time, and the readers take turns. A page is short, and a pause follows
it. So a thousand readers slow down each other, but no drop.
"""

import asyncio
import functools
import time
import weakref
from collections import Counter, defaultdict
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass
from typing import Final

import msgspec
import sqlalchemy as sa
from sqlalchemy import Connection, Engine

from plinko.app.errors import BusyError, LedgerError, ReadersError
from plinko.app.persistence.ledger.database import reader, reason
from plinko.app.persistence.room_runs import RoomRuns
from plinko.app.persistence.statements import store
from plinko.app.rooms import log
from plinko.app.rooms.kinds import format_of
from plinko.app.rooms.room import Room

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


_PAGE: Final = 250  # inputs of one page: takes about 5 ms
_REST: Final = 3.0  # the pause after a page, in multiples of the time that the page took
_LONGEST_REST: Final = 1.0  # s, the longest pause

MOST_READERS: Final = 32
MOST_OF_ONE: Final = 4


@dataclass(frozen=True, slots=True)
class LogPart:
    """Selects `limit` of a room's inputs (None: all), from number `first` on."""

    first: int = 0
    limit: int | None = None

    @property
    def whole(self) -> bool:
        """Whether this is the complete log; only that has a digest."""
        return self.first == 0 and self.limit is None


WHOLE: Final = LogPart()


Compute = Callable[[Callable[[], Entries]], Awaitable[Entries]]
"""Calls a function in another process."""


class RoomLogs:
    """Reads logs for many readers; for the event loop's thread. `clock` returns seconds.

    `compute` reads the pages. Without it, or if the ledger is in this process's memory, the
    ledger's thread does.
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
        # The readers of an address take turns, and so do the addresses.
        self._turn = asyncio.Lock()
        self._turns: dict[str, asyncio.Lock] = defaultdict(asyncio.Lock)
        self._free = 0.0  # when the next page may be read
        self._readers: Counter[str] = Counter()

    @property
    def readers(self) -> int:
        return self._readers.total()

    async def read(
        self, room: Room, reader: str, *, marks: bool, part: LogPart = WHOLE, run: int | None = None
    ) -> AsyncIterator[bytes]:
        """The room's log until now as pieces of JSON, for a `reader` (an address).

        It is the log of the room's current run, or of the finished run number `run`. Without
        `marks`, players' marks are null; the digest is that of the log as sent. The first page is
        read before this returns, later pages while the pieces are iterated. Raises LedgerError,
        and BusyError or ReadersError if too many logs are being read.
        """
        if self.readers >= MOST_READERS:
            raise BusyError(f"{MOST_READERS} clients are reading room logs already; try again")
        if self._readers[reader] >= MOST_OF_ONE:
            raise ReadersError(f"your address is reading {MOST_OF_ONE} room logs already")
        self._readers[reader] += 1
        place = _Place(functools.partial(self._left, reader))
        number = self._runs.of(room).number if run is None else run
        head, name, count = log.head(room), room.format.name, room.input_count
        end = count if part.limit is None else min(count, part.first + part.limit)

        async def page_from(first: int) -> Entries:
            limit = min(_PAGE, end - first)
            if limit <= 0:
                return NONE
            page = LogPage(room.mode, number, head["tick"], first, limit, marks)
            return await self._page(reader, page)

        async def pieces(page: Entries, _place: _Place) -> AsyncIterator[bytes]:
            """The pieces, beginning with this first page. The iterator keeps `_place` alive."""
            digest = log.LogDigest(head)
            yield msgspec.json.encode(head)[:-1] + f',"{name}":['.encode()
            done = part.first
            while page.count:
                digest.add_lines(page.lines)
                yield (b"," if done > part.first else b"") + page.text
                done += page.count
                page = await page_from(done)
            if part.whole:
                yield b'],"digest":"' + digest.hex().encode() + b'"}\n'
            else:
                rest = {"first": part.first, "next": end if end < count else None, "digest": None}
                yield b"]," + msgspec.json.encode(rest)[1:] + b"\n"

        self._runs.report([])
        await self._runs.ledger.settled()  # now the ledger has all results until this moment
        return pieces(await page_from(part.first), place)

    def _left(self, reader: str) -> None:
        self._readers[reader] -= 1
        if not self._readers[reader]:
            del self._readers[reader]
            self._turns.pop(reader, None)

    async def _page(self, reader: str, page: LogPage) -> Entries:
        """Read a page when it is the reader's turn and the pause after the last page is over."""
        async with self._turns[reader], self._turn:
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
        if self._compute is None:
            return await ledger.read(page.entries)
        # Shielded: cancelling the computation would end its process, which the next reader needs.
        url = ledger.database.url.render_as_string(hide_password=False)
        return await asyncio.shield(self._compute(functools.partial(page.elsewhere, url)))


class _Place:
    """Calls `leave` when it is garbage-collected, also if the log's iteration was never begun."""

    def __init__(self, leave: Callable[[], None]) -> None:
        weakref.finalize(self, leave)
