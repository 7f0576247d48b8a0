"""How rooms come back from the ledger: what sleeps when needed, what moved slice by slice.

A room is replayed from its checkpoint in a thread, a few milliseconds at a time, and what is
reached is kept: however often the server is killed on the way, the next one goes on from there.
What the ledger has of one room may be damaged; then that room is set aside, untouched, and whoever
asks for it is told so. The others play.
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

_LONGEST_FALL: Final = 3600.0  # s of simulation to finish a room that cannot go on
_SLICE: Final = 0.02  # s of replay between two looks at what else there is to do
_TICKS: Final = 4  # replayed between two looks at the clock
_PAGE: Final = 500  # inputs read at once; commits wait meanwhile
_CHECKPOINT: Final = 10.0  # s of ticks replayed; what a kill during a rebuild may cost

_log = logging.getLogger("plinko")


@dataclass(frozen=True, slots=True)
class Left:
    """What the last server left: rooms that moved, sleeping rooms of nobody, and of creators."""

    moving: list[Parked]
    public: dict[str, RoomRow]
    owned: list[Parked]


async def _at_once() -> None:
    """The turn of a rebuild that yields to nobody."""


class Recovery:
    """Makes rooms again from the ledger's rows; for the event loop's thread.

    set_aside: what is wrong with each room that cannot be had, by id.
    """

    def __init__(self, runs: RoomRuns, *, tick_rate: int, limits: BallLimits) -> None:
        self.rebuilt = 0  # rooms in which something moved
        self.set_aside: dict[str, str] = {}
        self._readable: set[str] | None = None  # rooms of a damaged list; None: all of them
        self._runs = runs
        self._ledger = runs.ledger
        self._tick_rate = tick_rate
        self._limits = limits

    async def survey(self, ground_now: Callable[[str], Ground | None]) -> Left:
        """What there is to go on with; no room is rebuilt yet. Of a shared ledger, nothing.

        `ground_now` gives what a public room is over in this server, and None for other rooms. A
        public room that cannot go on as it was counts as one that moved. Raises LedgerError when
        the ledger cannot be read. Where only the list of rooms is damaged, the rows that can be
        read are gone on with.
        """
        if self._runs.numbers is not None:
            await self._runs.numbers.fill()
            return Left([], {}, [])  # each room is taken when it is needed
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
        """What can be read of a damaged list of rooms: moving, public and owned ones."""
        found = await salvage(self._ledger)
        rows = found.rows
        self._runs.next_number = found.next_number
        self._readable = {row.id for row in rows} if found.lost else None
        _log.error(
            "the ledger's list of rooms is damaged: %d open ones can be read, and %d runs not; "
            "see `plinko ledger check`", len(rows), found.lost,
        )  # fmt: skip
        moving = [Parked.of(row, row.id) for row in rows if row.awake]
        public = {row.id: row for row in rows if not row.owned}
        owned = [Parked.of(row, row.id) for row in rows if row.owned and not row.awake]
        return moving, public, owned

    def check(self, room_id: str) -> None:
        """Raise DamagedRoomError for a room that was set aside, or may be among those lost."""
        if room_id in self.set_aside:
            raise self._refusal(room_id, self.set_aside[room_id])
        if self._readable is not None and room_id not in self._readable:
            raise self._refusal(room_id, "the ledger's list of rooms is damaged")

    def restore(self, row: RoomRow, ground: Ground) -> Room:
        """A sleeping public room from its row; raises DamagedRoomError when it is set aside."""
        try:
            return self._enter(row, rebuild(row, ground, (), limits=self._limits))
        except Exception as error:
            raise self._put_aside(row.id, error) from error

    async def load(
        self, room_id: str, *, ground_now: Ground | None = None, turn: Turn = _at_once
    ) -> Room | None:
        """A room that is in the ledger, as it was; one with an owner that cannot go on begins anew.

        None when the ledger knows no such open room, or the room of nobody could not go on.
        `ground_now` is what a public room is over in this server; `turn` is awaited now and then.
        Raises LedgerError when the ledger cannot be read, DamagedRoomError when the room is set
        aside, LeaseLostError when another server has taken it meanwhile.
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
        """Raise LeaseLostError where another server has gone on with what was read meanwhile.

        A row of before beside inputs of after looks like damage, and is none.
        """
        if self._runs.leases is not None:
            await self._runs.leases.confirm(room_id)

    async def closed(self, room_id: str) -> tuple[int, Room] | None:
        """The last run of a room that was closed, by number, and the room as it ended.

        None when the ledger knows none, or when its physics was another. Nothing goes on in it: it
        is there to be read. Raises LedgerError, DamagedRoomError.
        """
        found = await self._read(_session, find=store.closed_room, room_id=room_id)
        if found is None or found[0].physics_version != PHYSICS_VERSION:
            return None
        replay = await self._replayed(*found, _at_once, over=True)
        return found[0].number, replay.room

    # Damage.

    def _put_aside(self, room_id: str, error: Exception) -> DamagedRoomError:
        """One room's fault must not keep the others closed. Its rows stay as they are."""
        self.set_aside[room_id] = str(error)
        # Where damage was expected, it says all there is; elsewhere one wants to know where.
        trace = None if isinstance(error, DamagedRoomError) else error
        _log.error("room is set aside: %s", error, extra={"room": room_id}, exc_info=trace)
        return self._refusal(room_id, str(error))

    def _refusal(self, room_id: str, why: str) -> DamagedRoomError:
        return DamagedRoomError(
            f"room {room_id!r} is set aside: {why}", field="room", retry_after=60.0
        )

    async def _read(self, read: Callable[..., T], **values: object) -> T:
        return await read_sound(self._ledger, read, **values)

    # Rooms that go on.

    async def _replayed(
        self, row: RoomRow, kept: KeptBasis, turn: Turn, *, over: bool = False
    ) -> Replay:
        """The room at its last tick; of a run that is `over` the ledger is told nothing more.

        Raises DamagedRoomError where the ledger says otherwise.
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
        """Have the ledger know what is reached, so that it need not be replayed again."""
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
            # A life may be shorter than the time between two checkpoints.
            tick = max(row.tick, room.world.tick)
            self._runs.report([self._runs.mark(room, record, tick, awake=True)])
        return room

    # Rooms that cannot go on.

    def _outdated(self, row: RoomRow, ground_now: Ground | None) -> str | None:
        """Why a run cannot go on in this server, or None when it can."""
        if row.physics_version != PHYSICS_VERSION:
            return f"its physics was version {row.physics_version}, now it is {PHYSICS_VERSION}"
        if row.tick_rate != self._tick_rate:
            return f"it ran at {row.tick_rate} Hz, the server now at {self._tick_rate} Hz"
        if not row.owned and ground_now is not None and row.board != ground_now.digest:
            return "its board is another now"
        return None

    async def _succeed(self, row: RoomRow, kept: KeptBasis, why: str, turn: Turn) -> Room | None:
        """End a run that cannot go on, and begin the next where the room has an owner.

        Unless it has a draw: whether its seeds still land in their bins is for its owner to find.
        """
        writes = await self._end(row, kept, why, turn)
        if not row.owned or row.mode == DRAW:
            _log.warning("room ends: %s", why, extra={"room": row.id})
            self._runs.report(writes)
            return None
        _log.warning("room starts anew: %s", why, extra={"room": row.id})
        basis = await asyncio.to_thread(basis_of, row, kept)
        room = make_room(row.id, basis, row.mode, tick_rate=self._tick_rate, limits=self._limits)
        record = self._runs.of(room)
        record.owned, record.opened, record.known = True, row.opened, True
        record.creator = row.creator
        # In one transaction, so that the room is never without a run.
        self._runs.report([*writes, *self._runs.rows(room, record)])
        return room

    async def _end(self, row: RoomRow, kept: KeptBasis, why: str, turn: Turn) -> list[Write]:
        """What ends a run: what is in flight lands first; what cannot, gets its stake back."""
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


# What is read at once: each time the ledger is asked, a commit may come first.


def _session(
    connection: Connection, find: Callable[..., RoomRow | None], room_id: str
) -> tuple[RoomRow, KeptBasis] | None:
    """A room's run, and what it is made of."""
    row = find(connection, room_id=room_id)
    return None if row is None else (row, store.basis(connection, row.board, row.draw))


def _begun(
    connection: Connection, row: RoomRow, replay: Replay
) -> tuple[list[ResultRow], list[tuple[TakenRow, ResultRow | None]]]:
    """How the balls have landed that are in flight at the checkpoint, and the inputs after it."""
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
    """Raise DamagedRoomError when a result is not reproduced."""
    if replay.differences:
        raise DamagedRoomError(f"a result is not reproduced: {replay.differences[0]}")


def _slice(run: Callable[[int], bool]) -> bool:
    """Run for a moment; whether it is through."""
    end = time.perf_counter() + _SLICE
    while not run(_TICKS):
        if time.perf_counter() >= end:
            return False
    return True
