"""Restores rooms from the ledger: sleeping ones when needed, awake ones by a replay in slices.

A thread replays a room from its checkpoint in slices of some milliseconds. Checkpoints on the way
are saved, so that a server killed during a replay does not have to begin again. A room whose
record is damaged is set aside with its rows unchanged, and clients that ask for it get an error;
all other rooms play.
"""

import asyncio
import functools
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeVar

from sqlalchemy import Connection

from app.errors import DamagedRoomError, LedgerError
from app.persistence.recovery.ending import voided
from app.persistence.recovery.rebuild import Replay, basis_of, rebuild
from app.persistence.recovery.rebuild_queue import Turn
from app.persistence.recovery.salvage import read_sound, salvage
from app.persistence.room_runs import RoomRun, RoomRuns
from app.persistence.statements import store
from app.rooms.kinds import DRAW, BallLimits, format_of, make_room
from app.rooms.records import Close, KeptBasis, Mark, Parked, ResultRow, RoomRow, TakenRow, Write
from app.rooms.room import Ground, Room
from engine import PHYSICS_VERSION

T = TypeVar("T")

_LONGEST_FALL: Final = 3600.0  # s of simulation after which the balls of an ending run are given up
_SLICE: Final = 0.02  # s of replay before other work gets its turn
_TICKS: Final = 4  # replayed before the clock is checked
_PAGE: Final = 500  # inputs read at once; commits wait meanwhile
_CHECKPOINT: Final = 10.0  # s of ticks between checkpoints: the most that a kill makes replay again

_log = logging.getLogger("plinko")


@dataclass(frozen=True, slots=True)
class Left:
    """The last server's rooms: awake ones, sleeping public ones by id, and sleeping owned ones."""

    moving: list[Parked]
    public: dict[str, RoomRow]
    owned: list[Parked]


async def _at_once() -> None:
    """The `Turn` of a rebuild that waits for no other."""


class Recovery:
    """Restores rooms from the ledger's rows; for the event loop's thread.

    set_aside: the fault of each room that is set aside, by id.
    """

    def __init__(self, runs: RoomRuns, *, tick_rate: int, limits: BallLimits) -> None:
        self.rebuilt = 0  # awake rooms that were rebuilt
        self.set_aside: dict[str, str] = {}
        self._readable: set[str] | None = None  # readable rooms of a damaged list; None if sound
        self._runs = runs
        self._ledger = runs.ledger
        self._tick_rate = tick_rate
        self._limits = limits

    async def survey(self, ground_now: Callable[[str], Ground | None]) -> Left:
        """List the rooms to continue, without rebuilding any; of a shared ledger, none.

        `ground_now` returns a public room's board or scene in this server, and None for other
        rooms. A public room that cannot continue unchanged is listed as awake, so that its run is
        ended soon. Raises LedgerError if the ledger cannot be read. If only the list of rooms is
        damaged, its readable rows are used.
        """
        if self._runs.numbers is not None:
            await self._runs.numbers.fill()
            return Left([], {}, [])  # this server takes each room when it is needed
        try:
            self._runs.next_number = await self._read(store.last_number) + 1
            moving = await self._read(store.awake_rooms)
            public = {row.id: row for row in await self._read(store.public_rooms)}
            owned = await self._read(store.parked_rooms)
        except DamagedRoomError:
            moving, public, owned = await self._salvage()
        for each in moving:
            public.pop(each.id, None)
        for row in [each for each in public.values() if self._outdated(each, ground_now(each.id))]:
            moving.append(Parked.of(public.pop(row.id), row.id))
        return Left(moving[::-1], public, owned)

    async def _salvage(self) -> tuple[list[Parked], dict[str, RoomRow], list[Parked]]:
        """The readable rooms of a damaged list: awake, public and owned ones."""
        found = await salvage(self._ledger)
        rows = found.rows
        self._runs.next_number = found.next_number
        self._readable = {row.id for row in rows} if found.lost else None
        _log.error(
            "the ledger's list of rooms is damaged: %d open ones can be read, and %d runs not; "
            "stop the server and run `plinko ledger check`", len(rows), found.lost,
        )  # fmt: skip
        moving = [Parked.of(row, row.id) for row in rows if row.awake]
        public = {row.id: row for row in rows if not row.owned}
        owned = [Parked.of(row, row.id) for row in rows if row.owned and not row.awake]
        return moving, public, owned

    def check(self, room_id: str) -> None:
        """Raise DamagedRoomError for a room that is set aside or may be among the lost ones."""
        if room_id in self.set_aside:
            raise self._refusal(room_id, self.set_aside[room_id])
        if self._readable is not None and room_id not in self._readable:
            raise self._refusal(room_id, "the ledger's list of rooms is damaged")

    def restore(self, row: RoomRow, ground: Ground) -> Room:
        """A sleeping public room from its row; raises DamagedRoomError and sets it aside."""
        try:
            return self._enter(row, rebuild(row, ground, (), limits=self._limits))
        except Exception as error:
            raise self._put_aside(row.id, error) from error

    async def load(
        self, room_id: str, *, ground_now: Ground | None = None, turn: Turn = _at_once
    ) -> Room | None:
        """Restore a room from the ledger. An owned room that cannot continue begins a new run.

        Returns None if the ledger has no such open room, or if a public room cannot continue.
        `ground_now` is a public room's board or scene in this server; `turn` is awaited between
        slices. Raises LedgerError if the ledger cannot be read, DamagedRoomError if the room is set
        aside, LeaseLostError if another server has taken the room meanwhile.
        """
        try:
            found = await self._read(_session, find=store.open_room, room_id=room_id)
            if found is None:
                return None
            row, kept = found
            self._runs.note(row.number, room_id)
            why = self._outdated(row, ground_now)
            if why is not None:
                return await self._succeed(row, kept, why, turn)
            replay = await self._replayed(row, kept, turn)
            await self._confirm(room_id)
            return self._enter(row, replay)
        except LedgerError as error:
            if not isinstance(error, DamagedRoomError):
                raise
            await self._confirm(room_id)
            raise self._put_aside(room_id, error) from error
        except Exception as error:
            await self._confirm(room_id)
            raise self._put_aside(room_id, error) from error

    async def _confirm(self, room_id: str) -> None:
        """Raise LeaseLostError if another server has taken the room while it was read.

        An old row and newer inputs of that server would look like damage, but are not.
        """
        if self._runs.leases is not None:
            await self._runs.leases.confirm(room_id)

    async def closed(self, room_id: str) -> tuple[int, Room] | None:
        """The number of a closed room's last run, and the room as it ended, to be read only.

        None if the ledger has no such run, or one of another physics version. Raises LedgerError,
        DamagedRoomError.
        """
        found = await self._read(_session, find=store.closed_room, room_id=room_id)
        if found is None or found[0].physics_version != PHYSICS_VERSION:
            return None
        replay = await self._replayed(*found, _at_once, over=True)
        return found[0].number, replay.room

    # Damage.

    def _put_aside(self, room_id: str, error: Exception) -> DamagedRoomError:
        """Set a room aside, so that its fault does not stop the others. Its rows do not change."""
        self.set_aside[room_id] = str(error)
        # A DamagedRoomError says what is wrong; any other error needs its traceback to be found.
        trace = None if isinstance(error, DamagedRoomError) else error
        _log.error("room is set aside: %s", error, extra={"room": room_id}, exc_info=trace)
        return self._refusal(room_id, str(error))

    def _refusal(self, room_id: str, why: str) -> DamagedRoomError:
        return DamagedRoomError(
            f"room {room_id!r} is set aside: {why}", field="room", retry_after=60.0
        )

    async def _read(self, read: Callable[..., T], **values: object) -> T:
        return await read_sound(self._ledger, read, **values)

    # Rooms that continue.

    async def _replayed(
        self, row: RoomRow, kept: KeptBasis, turn: Turn, *, over: bool = False
    ) -> Replay:
        """Replay a room to its last tick; unless its run is `over`, save checkpoints on the way.

        Raises DamagedRoomError if a result differs from the ledger's.
        """
        basis = await asyncio.to_thread(basis_of, row, kept)
        replay = await asyncio.to_thread(Replay, row, basis, limits=self._limits)
        results, page = await self._read(_begun, row=row, replay=replay)
        replay.expect(results)
        saved_at = replay.first_tick
        while True:
            replay.take(page)
            to_end = len(page) < _PAGE
            while not await asyncio.to_thread(_slice, functools.partial(replay.run, to_end=to_end)):
                _compare(replay)
                due = saved_at + _CHECKPOINT * row.tick_rate
                if replay.room.world.tick >= due and not over:
                    saved_at = replay.room.world.tick
                    self._keep(row, replay)
                await turn()
            _compare(replay)
            if to_end:
                return replay
            page = await self._read(_page, row=row, replay=replay)

    def _keep(self, row: RoomRow, replay: Replay) -> None:
        """Write the results and a checkpoint, so that this part need not be replayed again."""
        room = replay.room
        self._runs.add_results(replay.take_results())
        checkpoint = room.checkpoint()
        self._runs.report([Mark(row.number, row.tick, True, row.used, checkpoint, room.taken)])

    def _enter(self, row: RoomRow, replay: Replay) -> Room:
        room = replay.room
        self._runs.add_results(replay.take_results())
        record = RoomRun(
            number=row.number,
            owned=row.owned,
            opened=row.opened,
            used=row.used,
            known=True,
            marked=row.tick,
            horizon=row.tick,
            checkpoint_tick=room.world.tick,
            clean=not row.awake,
            creator=row.creator,
            key=row.key,
        )
        self._runs.begin(row.id, record)
        self.rebuilt += row.awake
        if row.awake and not room.awake:
            self._runs.slept(room)
        elif room.world.tick > replay.first_tick:
            # Save a checkpoint now: a server that often restarts may never reach the next one, and
            # would replay the same ticks each time.
            tick = max(row.tick, room.world.tick)
            self._runs.report([self._runs.mark(room, record, tick, awake=True)])
        return room

    # Rooms that cannot continue.

    def _outdated(self, row: RoomRow, ground_now: Ground | None) -> str | None:
        """Why a run cannot continue in this server; None if it can."""
        if row.physics_version != PHYSICS_VERSION:
            return f"its physics version is {row.physics_version}, the server's {PHYSICS_VERSION}"
        if row.tick_rate != self._tick_rate:
            return f"its tick rate is {row.tick_rate} Hz, the server's {self._tick_rate} Hz"
        if not row.owned and ground_now is not None and row.board != ground_now.digest:
            return "its board has changed"
        return None

    async def _succeed(self, row: RoomRow, kept: KeptBasis, why: str, turn: Turn) -> Room | None:
        """End a run that cannot continue, and begin the next one if the room has an owner.

        A room with a draw only ends: its seeds may land in other bins now, so its owner must make a
        new draw.
        """
        writes = await self._end(row, kept, why, turn)
        if not row.owned or row.mode == DRAW:
            _log.warning("room is closed: %s", why, extra={"room": row.id})
            self._runs.report(writes)
            return None
        _log.warning("room begins a new run: %s", why, extra={"room": row.id})
        basis = await asyncio.to_thread(basis_of, row, kept)
        room = make_room(row.id, basis, row.mode, tick_rate=self._tick_rate, limits=self._limits)
        record = self._runs.of(room)
        record.owned, record.opened, record.known = True, row.opened, True
        record.creator = row.creator
        # One transaction ends the old run and begins the new one, so the room always has one.
        self._runs.report([*writes, *self._runs.rows(room, record)])
        return room

    async def _end(self, row: RoomRow, kept: KeptBasis, why: str, turn: Turn) -> list[Write]:
        """Let balls in flight land, and return the writes that end the run.

        Balls that cannot land get their stake back.
        """
        tick = row.tick
        if format_of(row.mode).has_results and row.awake and row.physics_version == PHYSICS_VERSION:
            replay = await self._replayed(row, kept, turn)
            last = replay.room.world.tick + _LONGEST_FALL * row.tick_rate
            while replay.room.world.tick < last:
                if await asyncio.to_thread(_slice, replay.finish):
                    break
                await turn()
            self._runs.add_results(replay.take_results())
            self._runs.report([])
            tick = replay.room.world.tick
        unended = await self._read(voided, row=row, tick=tick, why=why)
        return [*unended, Close(row.number, tick, self._runs.now())]


# Reads. Each function reads all that belongs together in one call, because the ledger may commit
# between two calls.


def _session(
    connection: Connection, find: Callable[..., RoomRow | None], room_id: str
) -> tuple[RoomRow, KeptBasis] | None:
    """A room's run with its board and draw."""
    row = find(connection, room_id=room_id)
    return None if row is None else (row, store.basis(connection, row.board, row.draw))


def _begun(
    connection: Connection, row: RoomRow, replay: Replay
) -> tuple[list[ResultRow], list[tuple[TakenRow, ResultRow | None]]]:
    """The results of balls in flight at the checkpoint, and the first inputs after it."""
    found: list[ResultRow] = []
    if format_of(row.mode).has_results:
        oldest, after = replay.oldest_in_flight, replay.first_tick
        found = store.results(connection, room=row.number, first=oldest, after=after)
    return found, _page(connection, row, replay)


def _page(
    connection: Connection, row: RoomRow, replay: Replay
) -> list[tuple[TakenRow, ResultRow | None]]:
    name, first = format_of(row.mode).name, replay.next_input
    return store.taken(connection, name=name, room=row.number, first=first, limit=_PAGE)


def _compare(replay: Replay) -> None:
    """Raise DamagedRoomError if the replay differs from the ledger."""
    if replay.differences:
        raise DamagedRoomError(f"the replay gives another result: {replay.differences[0]}")


def _slice(run: Callable[[int], bool]) -> bool:
    """Call `run` for the length of a slice; returns whether it has finished."""
    end = time.perf_counter() + _SLICE
    while not run(_TICKS):
        if time.perf_counter() >= end:
            return False
    return True
