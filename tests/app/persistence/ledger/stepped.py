"""A whole table whose ledger works step by step in the test's own thread, by a clock of the test's.

Between any two steps of a commit anything may happen: time passes, players drop, rooms tick, the
database fails, the process ends. So every interleaving of the two threads can be had again.
"""

import asyncio
import contextlib
import functools
import heapq
import itertools
import sqlite3
from collections import deque
from collections.abc import Awaitable, Callable, Iterator
from typing import Any, TypeVar

import msgspec
import sqlalchemy as sa
from sqlalchemy import Connection

from app.errors import LedgerError
from app.live.broadcast.hub import Hub
from app.live.registry import Rooms
from app.persistence.holds import Holds
from app.persistence.ledger.database import Database
from app.persistence.ledger.writer import Ledger
from app.persistence.room_log import RoomLogs
from app.persistence.service import PersistenceService
from app.protocol import messages
from app.rooms.boards import Boards
from app.rooms.kinds import BallLimits
from app.rooms.room import Room
from app.settings import Settings
from engine import Board
from tests.app.passes import run_pass
from tests.app.persistence.oracle import Told

T = TypeVar("T")

PATIENCE = 2.0  # s
LIMITS = BallLimits(200, 200)


def failure() -> Exception:
    """What a database says that cannot go on."""
    return sa.exc.OperationalError("COMMIT", {}, sqlite3.OperationalError("disk I/O error"))


class Steps(Database):
    """A database that calls `at` with the name of each step before it, and after the last one."""

    def __init__(self, url: str, *, shared: bool = False) -> None:
        super().__init__(url, shared=shared)
        self.at: Callable[[str], None] = lambda step: None

        @sa.event.listens_for(self._engine, "before_cursor_execute")
        def _statement(
            connection: Any, cursor: Any, statement: str, values: Any, context: Any, many: bool
        ) -> None:
            self.at(statement.splitlines()[0].split("(", maxsplit=1)[0].strip())

    @contextlib.contextmanager
    def transaction(self) -> Iterator[Connection]:
        self.at("connect")
        with super().transaction() as connection:
            yield connection
            self.at("commit")
        try:
            self.at("committed")
        except BaseException:
            self.disconnect()
            raise


class Clockwork:
    """An event loop's timers and messages, by hand."""

    def __init__(self) -> None:
        self.now = 0.0
        self._order = itertools.count()
        self._timers: list[tuple[float, int, Callable[[], None]]] = []
        self._inbox: deque[Callable[[], None]] = deque()

    def call_soon_threadsafe(self, callback: Callable[..., Any], *args: Any) -> None:
        self._inbox.append(functools.partial(callback, *args))

    def call_later(self, delay: float, callback: Callable[[], None]) -> None:
        heapq.heappush(self._timers, (self.now + delay, next(self._order), callback))

    def is_closed(self) -> bool:
        return False

    def deliver(self) -> None:
        """Let the loop hear what the ledger's thread has said."""
        while self._inbox:
            self._inbox.popleft()()

    def pass_time(self, seconds: float) -> None:
        """So much time passes, and the loop runs all the while."""
        end = self.now + max(0.0, seconds)
        while self._timers and self._timers[0][0] <= end:
            due, _, callback = heapq.heappop(self._timers)
            self.now = max(self.now, due)
            callback()
            self.deliver()
        self.now = end

    def freeze(self, seconds: float) -> None:
        """So much time passes in which the process does not run."""
        self.now += seconds
        self.pass_time(0.0)


class _Heard(PersistenceService):
    """Notes what is told as landed."""

    told: dict[str, Told]

    def landed(self, room: Room, landed: messages.Landed) -> None:
        self.told[room.id].hear(msgspec.to_builtins(landed))
        super().landed(room, landed)


class Table:
    """Rooms over a ledger of which each commit is made when the test says.

    A `holder` is the name of one of several servers that share the ledger.
    """

    def __init__(self, url: str, told: dict[str, Told], holder: str = "") -> None:
        self.told = told
        self.loop = Clockwork()
        self.database = Steps(url, shared=bool(holder))
        self.ledger = Ledger(
            self.database, period=1 / 60, patience=PATIENCE, clock=lambda: self.loop.now
        )
        self.ledger.open()
        self.ledger.attach(self.loop)
        self.persistence = _Heard(
            self.ledger,
            tick_rate=60,
            limits=LIMITS,
            now=lambda: 1e9 + self.loop.now,
            holds=Holds(self.ledger, holder) if holder else None,
        )
        self.persistence.told = told
        board = Board.preset("triangle-8")
        self.rooms = Rooms(
            Settings(),
            Boards(8),
            Hub(8),
            board,
            clock=lambda: self.loop.now,
            persistence=self.persistence,
        )
        self.ledger.start = lambda: None  # type: ignore[method-assign]

    def asks(self, room_id: str, seed: int, stake: int = 0) -> "asyncio.Future[Any] | None":
        """A player drops; None when that is refused at once."""
        room = self.rooms.find(room_id)
        try:
            asked = self.rooms.drop(room, seed, None, stake=stake)
        except LedgerError:
            self.told[room_id].refused.add(str(seed))
            return None
        asked.add_done_callback(functools.partial(self._answered, room_id, seed))
        return asked

    def _answered(self, room_id: str, seed: int, asked: "asyncio.Future[Any]") -> None:
        if asked.exception() is None:
            self.told[room_id].hear(msgspec.to_builtins(asked.result()))
        else:
            self.told[room_id].refused.add(str(seed))

    def turn(self) -> None:
        """The ledger's thread does one piece of work; what it says waits to be heard."""
        self.loop.pass_time(self.ledger.committer.pause())
        self.ledger.committer.turn()

    def work(self) -> None:
        """The ledger's thread does all that waits, and the loop hears of it."""
        self.loop.deliver()
        while not self.ledger.idle:
            self.turn()
            self.loop.deliver()

    async def until(self, wanted: Awaitable[T]) -> T:
        """What comes of something that waits for the ledger."""
        task = asyncio.ensure_future(wanted)
        try:
            while not task.done():
                await asyncio.sleep(0)
                self.work()
            return await task
        finally:
            task.cancel()

    def tick(self, times: int) -> None:
        for _ in range(times):
            run_pass(self.rooms.runner)

    async def until_still(self) -> None:
        """Let all that moves land, and the ledger hear of it."""
        while run_pass(self.rooms.runner) or not self.ledger.idle:
            self.work()
            await asyncio.sleep(0)

    async def log(self, room_id: str) -> dict[str, Any]:
        """A room's log, as a client gets it."""

        async def read() -> bytes:
            room = await self.rooms.seek(room_id)
            pieces = await RoomLogs(self.persistence.runs).read(room, "", marks=True)
            return b"".join([piece async for piece in pieces])

        log: dict[str, Any] = msgspec.json.decode(await self.until(read()))
        return log

    def end(self) -> None:
        """The process ends, as if it were killed."""
        self.database.close()
