"""A server's rooms from start to stop: a real database, ticks by hand, no network."""

import asyncio
import contextlib
import shutil
import sqlite3
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from plinko.app.live.arriving import Claim, any_room
from plinko.app.live.broadcast.hub import Hub
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.registry import Rooms
from plinko.app.live.stored_rooms import StoredRooms
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.persistence.leases import Leases
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.service import PersistenceService
from plinko.app.persistence.statements import store
from plinko.app.protocol import messages
from plinko.app.rooms.boards import Boards
from plinko.app.rooms.kinds import MAX_TOUCHING, BallLimits
from plinko.app.rooms.records import RoomRow
from plinko.app.settings import Settings
from plinko.engine import Board
from tests.app.asking import ask
from tests.app.passes import run_pass
from tests.kit.hand import HandClock
from tests.kit.waiting import LIMIT, turns

BOARD = Board.preset("triangle-8")

CLOCK = HandClock()
"""The time of all lives: it goes on from one to the next."""


@dataclass
class Life:
    """The rooms and the ledger of one run of a server."""

    rooms: Rooms
    ledger: Ledger
    going_on: "asyncio.Task[None]"

    async def drop(self, live: LiveRoom, seed: int | None, **values: Any) -> messages.Accepted:
        """Drop a ball, and tick until it has entered."""
        asked = ask(live, seed, **values)
        await turns()
        await self.heard()
        await self.until(asked.done, 1)
        return await asked

    def tick(self, times: int) -> None:
        for _ in range(times):
            run_pass(self.rooms.runner)

    async def heard(self) -> None:
        """Wait until the ledger has written everything: ticks here are faster than real time."""
        await self.ledger.read(lambda connection: None)

    async def until(self, condition: Callable[[], object], ticks: int = 20) -> None:
        """Tick, with the ledger's writes in between, until the condition holds."""
        async with asyncio.timeout(LIMIT):
            while not condition():
                self.tick(ticks)
                await self.heard()

    async def run(self, live: LiveRoom, ticks: int) -> None:
        """Tick until the room has advanced by this many ticks or sleeps."""
        room = live.room
        last = room.world.tick + ticks
        await self.until(lambda: room.world.tick + 20 > last or not room.awake)
        await self.until(lambda: room.world.tick >= last or not room.awake, 1)

    async def rest(self) -> None:
        """Tick until nothing moves."""
        await self.until(lambda: not self.rooms.runner.awake)

    async def back(self) -> None:
        """Wait until all rooms that were awake are in memory."""
        await self.going_on

    @property
    def stored(self) -> StoredRooms:
        """The rooms in the ledger."""
        return self.rooms.stored

    @property
    def leases(self) -> Leases:
        """The leases of a server that shares its ledger."""
        return self.stored.leases

    async def row(self, room_id: str) -> RoomRow:
        """The room's current run, as the ledger has it."""
        found = await self.ledger.read(lambda connection: store.open_room(connection, room_id))
        assert found is not None
        return found

    async def leave(self) -> None:
        """Stop in order. A life that ends without it acts as if killed: it loses its memory."""
        self.rooms.leave()
        await self.heard()


@contextlib.asynccontextmanager
async def living(
    url: str,
    *,
    board: Board = BOARD,
    go_on: bool = True,
    holder: str = "",
    claim: Claim = any_room,
    **settings: Any,
) -> AsyncIterator[Life]:
    """A life over the ledger at `url`.

    go_on: load all rooms that were awake, not only those asked for; holder: the server's name, if
    several servers share the ledger; claim: decides which rooms it may lease.
    """
    chosen = Settings(**settings)
    limits = BallLimits(chosen.max_balls, MAX_TOUCHING)
    database = Database(url, shared=bool(holder))
    ledger = Ledger(database, period=0.0, patience=60.0, leases=LeaseBook(holder))
    service = PersistenceService(ledger, limits=limits, now=CLOCK.unix)
    rooms = Rooms(chosen, Boards(8), Hub(8), board, service, clock=CLOCK, claim=claim)
    await asyncio.to_thread(ledger.open)
    ledger.start()
    try:
        await rooms.resume()
        alone = go_on and not holder
        going_on = asyncio.create_task(rooms.go_on() if alone else asyncio.sleep(0))
        try:
            yield Life(rooms, ledger, going_on)
        finally:
            going_on.cancel()
            await asyncio.gather(going_on, return_exceptions=True)
    finally:
        await ledger.close()


def change(url: str, *statements: str) -> None:
    """Change a ledger by statements that the server never executes."""
    database = Database(url)
    database.open(check=False, enter=False)
    with database.transaction() as connection:
        for statement in statements:
            connection.execute(sa.text(statement))
    database.close()


def look(url: str, read: Callable[..., Any], *values: Any) -> Any:
    """Call `read` on a ledger that no server uses."""
    database = Database(url)
    database.open(check=False, enter=False)
    try:
        with database.transaction() as connection:
            return read(connection, *values)
    finally:
        database.close()


def break_page(file: Path, table: str) -> None:
    """Flip a bit in the header of a table's first page, so that the page is invalid."""
    with sqlite3.connect(file) as connection:
        (size,) = connection.execute("PRAGMA page_size").fetchone()
        wanted = "SELECT rootpage FROM sqlite_master WHERE name = ?"
        (page,) = connection.execute(wanted, (table,)).fetchone()
    connection.close()
    found = bytearray(file.read_bytes())
    found[(page - 1) * size] ^= 0x40
    file.write_bytes(found)


def copy_ledger(file: Path, folder: Path) -> Path:
    """Copy an SQLite ledger with its epoch, as if it had always been in this folder."""
    shutil.copy(f"{file}-epoch", folder)
    return Path(shutil.copy(file, folder))
