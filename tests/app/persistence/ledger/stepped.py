"""Rooms and their ledger in one thread, where the test decides the order of all steps.

On a server the event loop and the ledger's thread run at the same time. Here the test runs both by
turns, with a clock that it sets. Between any two steps of a commit it can let time pass, drop
balls, tick rooms, fail the database or end the process. So it can reproduce every interleaving.
"""

import asyncio
import contextlib
import functools
import heapq
import itertools
import sqlite3
from collections import deque
from collections.abc import Callable, Coroutine, Iterator
from typing import Any, TypeVar

import msgspec
import sqlalchemy as sa
from sqlalchemy import Connection

from plinko.app.errors import LedgerError, UndecidedError
from plinko.app.live.broadcast.hub import Hub
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.registry import Rooms
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.room_log import RoomLogs
from plinko.app.persistence.service import PersistenceService
from plinko.app.protocol import messages
from plinko.app.rooms.boards import Boards
from plinko.app.rooms.kinds import BallLimits
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.room import Room
from plinko.app.settings import Settings
from plinko.engine import Board
from tests.app.passes import run_pass
from tests.kit.told import Told

T = TypeVar("T")

PATIENCE = 2.0  # s
_ROUNDS = 12  # iterations of the event loop, more than the longest chain of ready awaits
LIMITS = BallLimits(200, 200)


def failure() -> Exception:
    """The error of a database whose disk fails."""
    return sa.exc.OperationalError("COMMIT", {}, sqlite3.OperationalError("disk I/O error"))


class Steps(Database):
    """A database that calls `at` with each step's name before that step, and after a commit."""

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

    def _note(self, batch: int) -> None:
        self.at("note")
        super()._note(batch)
        self.at("noted")


class Clockwork:
    """The event loop as the ledger sees it: timers and callbacks, which the test runs."""

    def __init__(self, within: Callable[[Callable[[], None]], None]) -> None:
        self.now = 0.0
        self._within = within
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
        """Run the callbacks that the ledger's thread has sent to the loop."""
        while self._inbox:
            self._within(self._inbox.popleft())

    def pass_time(self, seconds: float) -> None:
        """Let time pass while the loop runs."""
        end = self.now + max(0.0, seconds)
        while self._timers and self._timers[0][0] <= end:
            due, _, callback = heapq.heappop(self._timers)
            self.now = max(self.now, due)
            self._within(callback)
            self.deliver()
        self.now = end

    def freeze(self, seconds: float) -> None:
        """Let time pass while the whole process is frozen."""
        self.now += seconds
        self.pass_time(0.0)


def record_landings(rooms: Rooms, told: dict[str, Told]) -> None:
    """Record the landings that rooms send."""
    add = rooms._open.add

    def heard(room: Room) -> LiveRoom:
        live = add(room)
        forward = live.landings.landed

        def hear(landed: messages.Landed) -> None:
            told[room.id].hear(msgspec.to_builtins(landed))
            forward(landed)

        live.landings.landed = hear  # type: ignore[method-assign]
        return live

    rooms._open.add = heard  # type: ignore[method-assign]


class Table:
    """Rooms over a ledger; the test decides when each commit is made.

    holder: the server's name, if several servers share the ledger.
    """

    def __init__(self, url: str, told: dict[str, Told], holder: str = "") -> None:
        self.told = told
        self._aio = asyncio.new_event_loop()
        self.loop = Clockwork(self.within)
        self.database = Steps(url, shared=bool(holder))
        self.ledger = Ledger(
            self.database,
            period=1 / 60,
            patience=PATIENCE,
            clock=lambda: self.loop.now,
            leases=LeaseBook(holder),
        )
        self.ledger.open()
        self.ledger.attach(self.loop)  # type: ignore[arg-type]
        self.persistence = PersistenceService(
            self.ledger,
            limits=LIMITS,
            now=lambda: 1e9 + self.loop.now,
        )
        board = Board.preset("triangle-8")
        self.rooms = Rooms(
            Settings(),
            Boards(8),
            Hub(8),
            board,
            self.persistence,
            clock=lambda: self.loop.now,
        )
        record_landings(self.rooms, told)
        self.ledger.start = lambda: None  # type: ignore[method-assign]

    def within(self, call: Callable[[], T]) -> T:
        """Run `call` on the event loop, and then every ready callback; returns its result."""
        called: asyncio.Future[T] = self._aio.create_future()

        def run() -> None:
            try:
                called.set_result(call())
            except Exception as error:  # noqa: BLE001 - it is raised below
                called.set_exception(error)

        self._aio.call_soon(run)
        self._go_round()
        return called.result()

    def _go_round(self) -> None:
        for _ in range(_ROUNDS):
            self._aio.call_soon(self._aio.stop)
            self._aio.run_forever()

    def asks(self, room_id: str, seed: int, stake: int = 0) -> "asyncio.Task[Any] | None":
        """Drop a ball; returns None if the room refuses it at once."""
        live = self.within(lambda: self.rooms.find(room_id))
        command = DropCommand(seed, stake=stake, practice=True)
        asked = self._aio.create_task(_decided(live.drop(command)))
        asked.add_done_callback(functools.partial(self._answered, room_id, seed))
        self._go_round()
        return None if asked.done() and asked.exception() is not None else asked

    def _answered(self, room_id: str, seed: int, asked: "asyncio.Future[Any]") -> None:
        error = asked.exception()
        if error is None:
            self.told[room_id].hear(msgspec.to_builtins(asked.result().accepted))
        else:
            assert isinstance(error, LedgerError), error
            self.told[room_id].refused.add(str(seed))

    @property
    def idle(self) -> bool:
        """Whether the ledger has no job, and accepts writes."""
        queue = self.ledger._queue
        return not (queue._waiting or queue._reads or queue._taken or queue.failure)

    def turn(self) -> None:
        """Do one piece of the ledger thread's work; the loop does not yet run its callbacks."""
        self.loop.pass_time(self.ledger.committer.pause())
        if not self.idle:  # a timer may have refused all work during the pause
            self.ledger.committer.turn()

    def work(self) -> None:
        """Do all of the ledger thread's work, and run its callbacks on the loop."""
        self.loop.deliver()
        while not self.idle:
            self.turn()
            self.loop.deliver()

    def until(self, wanted: Coroutine[Any, Any, T]) -> T:
        """The result of a coroutine that waits for the ledger."""
        task = self._aio.create_task(_decided(wanted))
        try:
            while not task.done():
                self._go_round()
                self.work()
            return task.result()
        finally:
            task.cancel()

    def tick(self, times: int) -> bool:
        """Tick this often; returns whether something still moves."""

        awake = False
        for _ in range(times):
            self.loop.pass_time(1 / 60)
            awake = self.within(lambda: run_pass(self.rooms.runner))
        return awake

    def until_still(self) -> None:
        """Tick until nothing moves and the ledger has written everything."""
        while self.tick(1) or not self.idle:
            self.work()

    def log(self, room_id: str) -> dict[str, Any]:
        """A room's log, as a client receives it."""

        async def read() -> bytes:
            live = await self.rooms.seek(room_id)
            pieces = await RoomLogs(self.persistence.runs).read(live.room, "", marks=True)
            return b"".join([piece async for piece in pieces])

        log: dict[str, Any] = msgspec.json.decode(self.until(read()))
        return log

    def end(self) -> None:
        """End the process as if killed; does nothing if it has ended."""
        if self._aio.is_closed():
            return
        self.database.close()
        for task in asyncio.all_tasks(self._aio):
            task.cancel()
        self._go_round()
        self._aio.close()


async def _decided(wanted: Coroutine[Any, Any, T]) -> T:
    """The final result of a coroutine, also if it was undecided at first."""
    try:
        return await wanted
    except UndecidedError as undecided:
        if undecided.outcome is None:
            raise
        outcome: T = await undecided.outcome
        return outcome
