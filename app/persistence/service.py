"""What the ledger knows of the rooms in memory: each drop before it is told, each room's progress.

How far a room may tick is written down ahead, half a second at a time. A room that is rebuilt goes
on from there, so it never shows a tick, nor takes a drop for one, that was shown before the crash.
"""

import asyncio
import functools
import logging
import math
import time
from collections.abc import AsyncIterator, Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Final

import msgspec
from sqlalchemy import Connection

from app.errors import LedgerError
from app.persistence import store
from app.persistence.recovery import Rebuilt, finish, rebuild, rebuild_arena, result_of
from app.persistence.unkept import Unkept
from app.persistence.writer import Done, Ledger
from app.protocol import messages
from app.rooms import log as roomlog
from app.rooms.independent import Plan
from app.rooms.kinds import MODE, AnyRoom, ArenaRoom, BallLimits, Ground, Room, ground_of, make_room
from app.rooms.records import (
    BoardRow,
    Close,
    DropRow,
    InputRow,
    Mark,
    Parked,
    ResultRow,
    RoomRow,
    Undo,
    Write,
)
from app.rooms.touching import log as arena_log
from app.rooms.touching.room import InputPlan
from engine import PHYSICS_VERSION, Board

AHEAD: Final = 0.5  # s; what a rebuilt room may have to skip
_RENEW: Final = 0.25  # s; how often the ledger hears of rooms that are awake
_CHECKPOINT: Final = 10.0  # s of ticks; bounds what has to be replayed at the start
_LONGEST_LEAD: Final = 0.5  # s that a drop may have to wait for its tick
_PAGE: Final = 2000  # drops read at once; commits wait meanwhile
_LONGEST_FALL: Final = 3600.0  # s of simulation to finish a room that cannot go on

_log = logging.getLogger("plinko")


@dataclass(slots=True)
class Book:
    """A room's sitting in the ledger. Times are Unix times."""

    number: int
    owned: bool
    opened: float
    used: float
    known: bool = False  # its row was handed to the ledger
    marked: int = 0  # ticks up to here were handed to the ledger
    horizon: int = 0  # ticks up to here are in it
    checkpoint_tick: int = 0
    clean: bool = True  # asleep, and the ledger has heard of it
    version: int = 0  # counts submissions


class Keeper:
    """Keeps the rooms' books; for the event loop's thread.

    `now` gives Unix time in seconds.
    """

    def __init__(
        self,
        ledger: Ledger | Unkept,
        *,
        tick_rate: int,
        limits: BallLimits,
        now: Callable[[], float] = time.time,
    ) -> None:
        self.ledger = ledger
        self.rebuilt = 0  # rooms, at the start
        self._tick_rate = tick_rate
        self._limits = limits
        self.now = now
        self._books: dict[str, Book] = {}
        self._next_number = 1
        self._results: list[Write] = []
        self._since_renewal = 0

    @property
    def lead(self) -> int:
        """Ticks from the acceptance of a drop to its start, enough for it to be durable by then."""
        longest = math.ceil(_LONGEST_LEAD * self._tick_rate)
        return min(max(1, math.ceil(self.ledger.lag * self._tick_rate)), longest)

    def book(self, room: AnyRoom) -> Book:
        """The room's page, a new one where it has none."""
        found = self._books.get(room.id)
        if found is None:
            now = self.now()
            found = self._books[room.id] = Book(self._number(), False, now, now)
        return found

    @property
    def keeps(self) -> bool:
        """Whether there is a ledger to find rooms in."""
        return not isinstance(self.ledger, Unkept)

    def forget(self, room: AnyRoom) -> None:
        """The room left the memory; what is in the ledger stays."""
        self._books.pop(room.id, None)

    def abandon(self, room: AnyRoom) -> None:
        """The room failed: its sitting is over."""
        book = self.book(room)
        if book.known:
            self._news([self._closing(room)], None)
        self.forget(room)

    def parkable(self, room: AnyRoom) -> bool:
        """Whether the ledger knows all of a sleeping room, so that memory may forget it."""
        return self.book(room).clean

    def park(self, room: AnyRoom) -> RoomRow | None:
        """Forget a sleeping room; the row from which `adopt` makes it again, if it has one."""
        book = self.book(room)
        self.forget(room)
        if not book.known:
            return None
        (*_, row) = self._rows(room, book)
        assert isinstance(row, RoomRow)
        return replace(
            row,
            used=book.used,
            tick=room.world.tick,
            checkpoint=room.checkpoint(),
            checkpoint_drops=room.taken,
        )

    async def found(self, room: AnyRoom) -> None:
        """Enter a room that belongs to its creator; raises LedgerError."""
        book = self.book(room)
        book.owned = book.known = True
        try:
            await self.ledger.commit(
                *self._rows(room, book), undo=(Close(book.number, 0, self.now()),)
            )
        except LedgerError:
            self.forget(room)
            raise

    async def end(self, room: AnyRoom) -> None:
        """Close the room's sitting for good; raises LedgerError."""
        await self.ledger.commit(*self._take_results(), self._closing(room))
        self.forget(room)

    async def replace(self, old: AnyRoom, new: AnyRoom) -> None:
        """End a room's sitting and begin its next, both or neither; raises LedgerError."""
        book = self.book(old)
        now = self.now()
        next_book = Book(self._number(), book.owned, book.opened, now, known=True)
        await self.ledger.commit(
            *self._take_results(),
            self._closing(old),
            *self._rows(new, next_book),
            undo=(Close(next_book.number, 0, now),),
        )
        self._books[new.id] = next_book

    def _closing(self, room: AnyRoom) -> Close:
        return Close(self.book(room).number, room.world.tick, self.now())

    def _take_results(self) -> list[Write]:
        results, self._results = self._results, []
        return results

    def submit(self, room: AnyRoom, plan: Plan | InputPlan, done: Done) -> None:
        """Have a planned drop written down; `done` hears when it is. Raises LedgerError."""
        book = self.book(room)
        now = self.now()
        tick = book.marked = max(book.marked, plan.tick + self._ahead)
        row, number = _row_of(book.number, plan)
        rows = [] if book.known else self._rows(room, book)
        undo: list[Write] = [Undo(book.number, number)]
        if rows:
            undo.append(Close(book.number, 0, now))
        self.ledger.submit(
            [*rows, Mark(book.number, tick, True, now), row],
            functools.partial(self._submitted, room, book.number, tick, bool(rows), done),
            undo=undo,
        )
        book.known = True
        book.clean = False
        book.used = now
        book.version += 1

    def may_step(self, room: AnyRoom) -> bool:
        """Whether the ledger has heard of the room's next tick; not asked for while it is lost.

        Nor of a room that it does not know: what moves there has moved since it began.
        """
        book = self.book(room)
        return not book.known or room.world.tick < book.horizon or not self.ledger.up

    def landed(self, room: AnyRoom, landed: messages.Landed) -> None:
        """A ball has landed; the ledger hears of it with the next news."""
        # What comes of a drop among balls that touch follows from all inputs, not from its own.
        if isinstance(room, Room):
            self._results.append(result_of(self.book(room).number, landed))

    def slept(self, room: AnyRoom) -> None:
        """Nothing moves in the room any more."""
        book = self.book(room)
        book.version += 1
        book.checkpoint_tick = book.marked = room.world.tick
        book.horizon = min(book.horizon, room.world.tick)
        mark = Mark(book.number, room.world.tick, False, self.now(), room.checkpoint(), room.taken)
        self._news([mark], functools.partial(self._asleep, room, book.number, book.version))

    def ticked(self, ticks: int, awake: Iterable[AnyRoom]) -> None:
        """So many ticks have passed; now and then the ledger hears how far the rooms have come."""
        self._since_renewal += ticks
        if self._since_renewal < _RENEW * self._tick_rate:
            return
        self._since_renewal = 0
        if not self.ledger.up:
            return  # what has landed is kept; that more has not can wait
        for room in awake:
            book = self.book(room)
            if book.known:
                tick = book.marked = max(book.marked, room.world.tick + self._ahead)
                mark = self._mark(room, book, tick)
                done = functools.partial(self._renewed, room, book.number, book.version, tick)
                self._news([mark], done)

    def leave(self, awake: Iterable[AnyRoom]) -> None:
        """The server stops: write down where the rooms stand that are awake, to go on there."""
        marks: list[Write] = []
        for room in awake:
            book = self.book(room)
            if book.known:
                tick = room.world.tick
                marks.append(
                    Mark(book.number, tick, True, self.now(), room.checkpoint(), room.taken)
                )
        self._news(marks, None)

    async def log(self, room: AnyRoom) -> AsyncIterator[bytes]:
        """The room's log as JSON in pieces, up to this moment; raises LedgerError.

        It is asked for whole before the first piece is given, but for later pages of a long one.
        """
        book = self.book(room)
        log: _DropLog | _InputLog
        if isinstance(room, ArenaRoom):
            log = _InputLog(room, book.number)
        else:
            log = _DropLog(room, book.number)
        self._news([], None)
        first = await self._page(log, 0)
        return self._log(log, first)

    async def _page(self, log: "_DropLog | _InputLog", first: int) -> list[dict[str, Any]]:
        if first >= log.count:
            return []
        limit = min(_PAGE, log.count - first)
        return await self.ledger.read(functools.partial(log.read, first=first, limit=limit))

    async def _log(
        self, log: "_DropLog | _InputLog", page: list[dict[str, Any]]
    ) -> AsyncIterator[bytes]:
        yield msgspec.json.encode(log.head)[:-1] + f',"{log.name}":['.encode()
        done = 0
        while page:
            log.digest.add(page)
            yield (b"," if done else b"") + msgspec.json.encode(page)[1:-1]
            done += len(page)
            page = await self._page(log, done)
        yield b'],"digest":"' + log.digest.hex().encode() + b'"}\n'

    async def resume(self) -> list[AnyRoom]:
        """The rooms in which something moved when the last server ended, as they were.

        Raises LedgerError when the ledger cannot be read.
        """
        self._next_number = await self.ledger.read(store.last_number) + 1
        rooms = []
        for row in await self.ledger.read(store.awake_rooms):
            try:
                room = await self._resume(row)
            except LedgerError:
                raise
            except Exception as error:  # noqa: BLE001
                # One room's fault must not keep the others closed. Its rows stay in the ledger.
                _log.exception("room cannot be rebuilt", extra={"room": row.id})
                self._retire(row, f"it cannot be rebuilt: {error}")
                continue
            if room is not None:
                rooms.append(room)
        return rooms

    async def public(self) -> dict[str, RoomRow]:
        """The public rooms that the ledger knows, by id."""
        return {row.id: row for row in await self.ledger.read(store.public_rooms)}

    async def parked(self) -> list[Parked]:
        """The open rooms with owners that the ledger knows, the longest unused first."""
        return await self.ledger.read(store.parked_rooms)

    def close(self, room: Parked) -> None:
        """A parked room's sitting is over."""
        self._news([Close(room.number, room.tick, self.now())], None)

    def touch(self, room: AnyRoom) -> None:
        """Someone needs the room."""
        self.book(room).used = self.now()

    async def load(self, room_id: str) -> AnyRoom | None:
        """A room that sleeps in the ledger, or None when it knows no such open room.

        Raises LedgerError when it cannot be read.
        """
        row = await self.ledger.read(functools.partial(store.open_room, room_id=room_id))
        if row is None:
            return None
        return await (self._succeed(row) if self._outdated(row) else self._resume(row))

    def adopt(self, row: RoomRow, board: Ground) -> AnyRoom | None:
        """A sleeping public room's next life in memory; None when its sitting cannot go on."""
        why = self._outdated(row)
        if why is None and row.board != board.digest:
            why = "its board is another now"
        if why is not None:
            self._retire(row, why)
            return None
        if isinstance(board, Board) and row.mode == MODE:
            return self._enter(row, rebuild(row, board, (), max_balls=self._limits.alone))
        return self._enter(row, rebuild_arena(row, board, (), limits=self._limits))

    @property
    def _ahead(self) -> int:
        return math.ceil(AHEAD * self._tick_rate)

    def _number(self) -> int:
        number, self._next_number = self._next_number, self._next_number + 1
        return number

    def _rows(self, room: AnyRoom, book: Book) -> list[Write]:
        board = msgspec.json.encode(room.board.to_dict()).decode()
        return [
            BoardRow(room.board.digest, room.board.name, board),
            RoomRow(
                number=book.number,
                id=room.id,
                board=room.board.digest,
                mode=room.mode,
                owned=book.owned,
                tick_rate=room.tick_rate,
                physics_version=PHYSICS_VERSION,
                opened=book.opened,
                used=book.used,
            ),
        ]

    def _mark(self, room: AnyRoom, book: Book, tick: int) -> Mark:
        mark = Mark(book.number, tick, True, self.now())
        if room.world.tick - book.checkpoint_tick < _CHECKPOINT * self._tick_rate:
            return mark
        book.checkpoint_tick = room.world.tick
        return replace(mark, checkpoint=room.checkpoint(), checkpoint_drops=room.taken)

    def _news(self, writes: list[Write], done: Done | None) -> None:
        """Hand what has landed, and `writes`, to the ledger."""
        news, self._results = [*self._results, *writes], []
        self.ledger.defer(news, done)

    def _submitted(
        self,
        room: AnyRoom,
        number: int,
        tick: int,
        first: bool,
        done: Done,
        error: LedgerError | None,
    ) -> None:
        book = self._books.get(room.id)
        if book is not None and book.number == number:
            if error is None:
                book.horizon = max(book.horizon, tick)
            elif first:
                # Whether its row was written is not known: the next drop brings another.
                book.known = False
                book.number = self._number()
        done(error)

    def _renewed(
        self, room: AnyRoom, number: int, version: int, tick: int, error: LedgerError | None
    ) -> None:
        book = self._books.get(room.id)
        if error is None and book is not None and (book.number, book.version) == (number, version):
            book.horizon = max(book.horizon, tick)

    def _asleep(self, room: AnyRoom, number: int, version: int, error: LedgerError | None) -> None:
        book = self._books.get(room.id)
        if book is not None and (book.number, book.version) == (number, version):
            book.clean = error is None

    async def _resume(self, row: RoomRow) -> AnyRoom | None:
        """A sitting's room, or None when it could not go on and was brought to an end."""
        if row.mode != MODE:
            return await self._resume_arena(row)
        board = await self._ground(row)
        assert isinstance(board, Board)
        # Those before the checkpoint are in it; their results are read to be compared.
        first = max(0, row.checkpoint_drops - self._limits.alone)
        drops = await self.ledger.read(functools.partial(store.drops, room=row.number, first=first))
        why = self._outdated(row)
        if why is not None and row.physics_version != PHYSICS_VERSION:
            void = [_void(drop.ball, row, why) for drop, result in drops if result is None]
            self._results += void
            self._retire(row, why)
            return None
        work = functools.partial(rebuild, row, board, drops, max_balls=self._limits.alone)
        rebuilt = await asyncio.to_thread(work)
        for difference in rebuilt.differences:
            _log.error("a result is not reproduced: %s", difference, extra={"room": row.id})
        if why is not None:
            most = math.ceil(_LONGEST_FALL * row.tick_rate)
            await asyncio.to_thread(finish, rebuilt, row.number, most)
            self._results += rebuilt.results
            self._retire(replace(row, tick=rebuilt.room.world.tick), why)
            return None
        self.rebuilt += row.awake
        return self._enter(row, rebuilt)

    async def _resume_arena(self, row: RoomRow) -> AnyRoom | None:
        """The same, of a sitting whose balls touch each other."""
        why = self._outdated(row)
        if why is not None:
            self._retire(row, why)
            return None
        ground = await self._ground(row)
        read = functools.partial(store.inputs, room=row.number, first=row.checkpoint_drops)
        inputs = await self.ledger.read(read)
        work = functools.partial(rebuild_arena, row, ground, inputs, limits=self._limits)
        rebuilt = await asyncio.to_thread(work)
        self.rebuilt += row.awake
        return self._enter(row, rebuilt)

    def _enter(self, row: RoomRow, rebuilt: Rebuilt) -> AnyRoom:
        room = rebuilt.room
        self._results += rebuilt.results
        self._books[row.id] = Book(
            number=row.number,
            owned=row.owned,
            opened=row.opened,
            used=row.used,
            known=True,
            marked=row.tick,
            horizon=row.tick,
            checkpoint_tick=room.world.tick,
            clean=not row.awake,
        )
        if row.awake and not room.awake:
            self.slept(room)
        return room

    def _outdated(self, row: RoomRow) -> str | None:
        """Why a sitting cannot go on in this server, or None when it can."""
        if row.physics_version != PHYSICS_VERSION:
            return f"its physics was version {row.physics_version}, now it is {PHYSICS_VERSION}"
        if row.tick_rate != self._tick_rate:
            return f"it ran at {row.tick_rate} Hz, the server now at {self._tick_rate} Hz"
        return None

    def _retire(self, row: RoomRow, why: str) -> None:
        _log.warning("room starts anew: %s", why, extra={"room": row.id})
        self._news([Close(row.number, row.tick, self.now())], None)

    async def _succeed(self, row: RoomRow) -> AnyRoom:
        """The same room in a new sitting, as the old one cannot go on."""
        ground = await self._ground(row)
        if row.awake:
            await self._resume(row)
        else:
            self._retire(row, self._outdated(row) or "")
        room = make_room(row.id, ground, row.mode, tick_rate=self._tick_rate, limits=self._limits)
        book = self.book(room)
        book.owned, book.opened, book.known = row.owned, row.opened, True
        await self.ledger.commit(*self._rows(room, book), undo=(Close(book.number, 0, row.used),))
        return room

    async def _ground(self, row: RoomRow) -> Ground:
        text = await self.ledger.read(functools.partial(store.board, digest=row.board))
        if text is None:
            raise LedgerError(f"the ledger lacks board {row.board}")
        return await asyncio.to_thread(ground_of, row.mode, text)


def _row_of(room: int, plan: Plan | InputPlan) -> tuple[DropRow | InputRow, int]:
    """What the ledger keeps of a planned drop or input, and its number in the room."""
    if isinstance(plan, InputPlan):
        data = msgspec.json.encode(plan.command.data).decode()
        return InputRow(room, plan.number, plan.tick, data, plan.command.who), plan.number
    drop = plan.command
    row = DropRow(room, plan.ball, plan.tick, drop.seed, drop.x, drop.stake, drop.who)
    return row, plan.ball


class _DropLog:
    """The log of a room by its drops."""

    name = "drops"

    def __init__(self, room: Room, number: int) -> None:
        self.head = roomlog.head(room)
        self.count = room.taken
        self.digest = roomlog.LogDigest(self.head["world_digest"])
        self._number = number

    def read(self, connection: Connection, first: int, limit: int) -> list[dict[str, Any]]:
        """Entries from `first` on."""
        found = store.drops(connection, self._number, first, limit)
        return [roomlog.entry(drop, result, self.head["tick"]) for drop, result in found]


class _InputLog:
    """The log of a room whose balls touch each other, by all its inputs."""

    name = "inputs"

    def __init__(self, room: ArenaRoom, number: int) -> None:
        self.head = arena_log.head(room, roomlog.KIND)
        self.count = room.taken
        self.digest = arena_log.LogDigest(self.head["world_digest"])
        self._number = number

    def read(self, connection: Connection, first: int, limit: int) -> list[dict[str, Any]]:
        """Entries from `first` on."""
        return [
            arena_log.entry(row) for row in store.inputs(connection, self._number, first, limit)
        ]


def _void(ball: int, row: RoomRow, why: str) -> ResultRow:
    """The end of a drop that can no longer be computed as it was promised: its stake is back."""
    return ResultRow(row.number, ball, row.tick, None, 1.0, 0.0, 0.0, "", why)
