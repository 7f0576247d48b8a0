"""Loads rooms from the ledger when they are first asked for.

A table is loaded from its sums and the facts that have not landed; a thread computes their flights.
Touching balls are replayed from the last checkpoint, on a thread too. A room whose record is
damaged is set aside with its rows unchanged, and clients that ask for it get an error; all other
rooms play.
"""

import asyncio
import functools
import logging
from collections.abc import Callable
from typing import Final, TypeVar

import sqlalchemy as sa
from sqlalchemy import Connection

from plinko.app.errors import DamagedRoomError, LedgerError
from plinko.app.persistence.recovery import ending
from plinko.app.persistence.recovery.rebuild import Replay, basis_of
from plinko.app.persistence.room_runs import RoomRun, RoomRuns
from plinko.app.persistence.statements import facts, store
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.kinds import DRAW, BallLimits, format_of, make_room
from plinko.app.rooms.records import (
    RULES,
    Close,
    InputRow,
    ResultRow,
    RoomRow,
    StoredBasis,
    TableState,
    Void,
    Write,
)
from plinko.app.rooms.room import Ground, Room
from plinko.app.settings import TICK_RATE
from plinko.engine import PHYSICS_VERSION, Board
from plinko.engine.drops.flight import fly

T = TypeVar("T")

_PAGE: Final = 500  # inputs read at once; commits wait meanwhile

_log = logging.getLogger("plinko")


class Recovery:
    """Loads rooms from the ledger's rows; for the event loop's thread.

    set_aside: the fault of each room that is set aside, by id.
    """

    def __init__(self, runs: RoomRuns, limits: BallLimits) -> None:
        self.set_aside: dict[str, str] = {}
        self._runs = runs
        self._ledger = runs.ledger
        self._limits = limits

    async def prepare(self) -> None:
        """Get ready to load rooms; raises LedgerError, DamagedRoomError if no room can be found."""
        if not self._runs.leases.book.alone:
            await self._runs.follow_database()
            return
        try:
            self._runs.next_number = await self._read(store.last_number) + 1
            await self._read(store.directory)
        except DamagedRoomError as error:
            raise DamagedRoomError(
                "the ledger's list of rooms is damaged: restore a backup (docs/operations.md), or "
                "save what is readable with SQLite's `.recover`, then run `plinko ledger restore`"
            ) from error

    def check(self, room_id: str) -> None:
        """Raise DamagedRoomError for a room that is set aside."""
        if room_id in self.set_aside:
            raise self._refusal(room_id, self.set_aside[room_id])

    async def load(self, room_id: str, *, ground_now: Ground | None = None) -> Room | None:
        """Load a room from the ledger. An owned room that cannot continue begins a new run.

        Returns None if the ledger has no such open room, or if a public room cannot continue.
        `ground_now` is a public room's board or scene in this server. Raises LedgerError if the
        ledger cannot be read, DamagedRoomError if the room is set aside, LeaseLostError if another
        server has taken the room meanwhile.
        """
        try:
            found = await self._read(_run_and_basis, find=store.open_room, room_id=room_id)
            if found is None:
                return None
            row, kept = found
            self._runs.leases.book.note(row.number, room_id)
            why = self._outdated(row, ground_now)
            if why is not None:
                return await self._succeed(row, kept, why)
            if format_of(row.mode).has_results:
                return await self._load_table(row, kept)
            replay = await self._replayed(row, kept)
            await self._runs.leases.confirm(room_id)
            return self._enter(row, replay)
        except Exception as error:
            if isinstance(error, LedgerError) and not isinstance(error, DamagedRoomError):
                raise
            # An old row and newer inputs of another server would look like damage, but are not.
            await self._runs.leases.confirm(room_id)
            raise self._put_aside(room_id, error) from error

    async def closed(self, room_id: str) -> tuple[int, Room] | None:
        """The number of a closed room's last run, and the room as it ended, to be read only.

        None if the ledger has no such run, or one of another physics version. Raises LedgerError,
        DamagedRoomError.
        """
        found = await self._read(_run_and_basis, find=store.closed_room, room_id=room_id)
        if found is None or found[0].physics_version != PHYSICS_VERSION:
            return None
        row, kept = found
        if not format_of(row.mode).has_results:
            replay = await self._replayed(row, kept)
            return row.number, replay.room
        state = await self._read(facts.state_at_end, run=row.number, tick=row.tick)
        room = await self._table(row, kept)
        await asyncio.to_thread(load_table, room, state, row.tick)
        return row.number, room

    async def board_of(self, run: int) -> Board:
        """The board of a table's run, open or over; raises LedgerError, DamagedRoomError."""
        found = await self._read(_run_and_basis, find=store.run, number=run)
        assert found is not None
        return (await self._table(*found)).board

    # Damage.

    def _put_aside(self, room_id: str, error: Exception) -> DamagedRoomError:
        """Set a room aside, so that its fault does not stop the others. Its rows do not change."""
        self.set_aside[room_id] = str(error)
        # A DamagedRoomError says what is wrong; any other error needs its traceback to be found.
        trace = None if isinstance(error, DamagedRoomError) else error
        _log.error(
            "room is unavailable, its record is damaged: %s",
            error,
            extra={"room": room_id},
            exc_info=trace,
        )
        return self._refusal(room_id, str(error))

    def _refusal(self, room_id: str, why: str) -> DamagedRoomError:
        return DamagedRoomError(
            f"room {room_id!r} is unavailable, because its record is damaged: {why}",
            field="room",
            retry_after=60.0,
        )

    async def _read(self, read: Callable[..., T], **values: object) -> T:
        return await self._ledger.read(_sound, read, **values)

    # Tables.

    async def _table(self, row: RoomRow, kept: StoredBasis) -> IndependentRoom:
        """A run's table before its first drop."""
        basis = await asyncio.to_thread(basis_of, row, kept)
        make = functools.partial(make_room, tick_rate=row.tick_rate, limits=self._limits)
        room = await asyncio.to_thread(make, row.id, basis, row.mode)
        assert isinstance(room, IndependentRoom)
        return room

    async def _load_table(self, row: RoomRow, kept: StoredBasis) -> Room:
        """A table as it is now. Results that the ledger lacks are written with the next write."""
        state: TableState = await self._read(facts.table_state, run=row.number)
        room = await self._table(row, kept)
        record = self._record(row, least=state.last)
        if state.last > row.tick:
            raise DamagedRoomError(
                f"drop {state.drops - 1} has tick {state.last}, but its run is at tick {row.tick}"
            )
        landed = await asyncio.to_thread(load_table, room, state, record.clock.tick)
        await self._runs.leases.confirm(row.id)
        self._runs.begin(row.id, record)
        self._runs.add_results(landed)
        if row.awake and not room.awake:
            self._runs.slept(room)
        return room

    def _record(self, row: RoomRow, *, least: int = 0) -> RoomRun:
        return RoomRun(
            number=row.number,
            owned=row.owned,
            opened=row.opened,
            used=row.used,
            clock=self._runs.clock(row.opened, least),
            known=True,
            creator=row.creator,
        )

    # Rooms of touching balls.

    async def _replayed(self, row: RoomRow, kept: StoredBasis) -> Replay:
        """Replay a room to its last input, or to its end if its run is over."""
        basis = await asyncio.to_thread(basis_of, row, kept)
        replay = await asyncio.to_thread(Replay, row, basis, limits=self._limits)
        while True:
            page: list[InputRow] = await self._read(
                store.inputs, room=row.number, first=replay.next_input, limit=_PAGE
            )
            replay.take(page)
            to_end = len(page) < _PAGE
            await asyncio.to_thread(replay.run, to_end=to_end)
            if to_end:
                return replay

    def _enter(self, row: RoomRow, replay: Replay) -> Room:
        room, record = replay.room, self._record(row)
        self._runs.begin(row.id, record)
        if row.awake and not room.awake:
            self._runs.slept(room)
        elif room.world.tick > replay.first_tick:
            # Save a checkpoint now: a server that often restarts may never reach the next one, and
            # would replay the same ticks each time.
            self._runs.report([self._runs.mark(room, record, awake=True)])
        return room

    # Rooms that cannot continue.

    def _outdated(self, row: RoomRow, ground_now: Ground | None) -> str | None:
        """Why a run cannot continue in this server; None if it can."""
        if row.physics_version != PHYSICS_VERSION:
            return f"its physics version is {row.physics_version}, the server's {PHYSICS_VERSION}"
        if row.tick_rate != TICK_RATE:
            return f"its tick rate is {row.tick_rate} Hz, the server's {TICK_RATE} Hz"
        if row.rules != RULES and format_of(row.mode).has_results:
            return "an earlier release began it, whose clock stood still while no ball moved"
        if not row.owned and ground_now is not None and row.board != ground_now.digest:
            return "its board has changed"
        return None

    async def _succeed(self, row: RoomRow, kept: StoredBasis, why: str) -> Room | None:
        """End a run that cannot continue, and begin the next one if the room has an owner.

        A room with a draw only ends if the physics have changed: its seeds may land in other bins
        now, so its owner must make a new draw.
        """
        writes = await self._end(row, why)
        redrawn = row.mode == DRAW and row.physics_version != PHYSICS_VERSION
        if not row.owned or redrawn:
            _log.warning("room is closed: %s", why, extra={"room": row.id})
            self._runs.report(writes)
            return None
        _log.warning("room begins a new run: %s", why, extra={"room": row.id})
        basis = await asyncio.to_thread(basis_of, row, kept)
        room = make_room(row.id, basis, row.mode, tick_rate=TICK_RATE, limits=self._limits)
        record = await self._runs.new_run(row.id, owned=True, known=True)
        record.creator = row.creator
        self._runs.begin(row.id, record)
        # One transaction ends the old run and begins the new one, so the room always has one.
        self._runs.report([*writes, *self._runs.rows(room, record)])
        return room

    async def _end(self, row: RoomRow, why: str) -> list[Write]:
        """The writes that end a run: its balls land, or return their stakes."""
        landed = await self._read(ending.results, row=row)
        tick = max((row.tick, *(each.tick for each in landed)))
        void = Void(row.number, tick, why)
        return [*landed, void, Close(row.number, tick, self._runs.now())]


def load_table(room: IndependentRoom, state: TableState, tick: int) -> list[ResultRow]:
    """Bring a new room to this tick; returns the results that the ledger lacks."""
    flying = [(fact, fly(room.board, room.start_of(fact))) for fact in state.flying]
    return room.load(state, flying, tick)


# Reads. Each function reads all that belongs together in one call, because the ledger may commit
# between two calls.


def _run_and_basis(
    connection: Connection, find: Callable[..., RoomRow | None], **chosen: object
) -> tuple[RoomRow, StoredBasis] | None:
    row = find(connection, **chosen)
    return None if row is None else (row, store.basis(connection, row.board, row.draw))


def _sound(connection: Connection, read: Callable[..., T], /, **values: object) -> T:
    """Call `read`; raises DamagedRoomError if it meets damaged pages."""
    try:
        return read(connection, **values)
    except sa.exc.DatabaseError as error:
        # Only DatabaseError itself means damage: its subclasses also occur in a sound database.
        if type(error) is not sa.exc.DatabaseError:
            raise
        raise DamagedRoomError("its pages in the database are damaged") from error
