"""What the ledger knows of the rooms in memory: each drop before it is told, each room's progress.

How far a room may tick is written down ahead, half a second at a time. A room that is rebuilt goes
on from there, so it never shows a tick, nor takes a drop for one, that was shown before the crash.
"""

import asyncio
import functools
import math
import time
from collections.abc import Callable, Coroutine, Iterable, Sequence
from typing import Final

from app.errors import LedgerError
from app.persistence.leases import Leases
from app.persistence.ledger.null_ledger import NullLedger
from app.persistence.ledger.writer import Ledger
from app.persistence.recovery.recovery import Recovery
from app.persistence.room_runs import RoomRun, RoomRuns
from app.protocol import messages
from app.rooms.kinds import BallLimits
from app.rooms.pending import Pending
from app.rooms.records import Close, Lease, LogLeaf, Mark, Parked, RoomRow, Void, Write
from app.rooms.room import Room
from app.rooms.settling import Settled

AHEAD: Final = 0.5  # s; what a rebuilt room may have to skip
_RENEW: Final = 0.25  # s; how often the ledger hears of rooms that are awake
_CHECKPOINT: Final = 10.0  # s of ticks; bounds what has to be replayed at the start
_LONGEST_LEAD: Final = 0.5  # s that a drop may have to wait for its tick
_UNDERWAY: Final = 8
"""Marks of one room that may wait for a slow ledger: two seconds of them. What is not told is told
by the next one, so that nothing grows however long a commit takes."""


class PersistenceService:
    """Tells the ledger what happens in rooms, and when; for the event loop's thread.

    `now` gives Unix time in seconds; `leases` are this server's where several share the ledger.
    """

    def __init__(
        self,
        ledger: Ledger | NullLedger,
        *,
        tick_rate: int,
        limits: BallLimits,
        now: Callable[[], float] = time.time,
        leases: Leases | None = None,
    ) -> None:
        self.ledger = ledger
        self.leases = leases
        self.runs = RoomRuns(ledger, now, leases)
        self.recovery = Recovery(self.runs, tick_rate=tick_rate, limits=limits)
        self._tick_rate = tick_rate
        self._since_renewal = 0  # ticks

    @property
    def lead(self) -> int:
        """Ticks from the acceptance of a drop to its start, enough for it to be durable by then."""
        longest = math.ceil(_LONGEST_LEAD * self._tick_rate)
        return min(max(1, math.ceil(self.ledger.lag * self._tick_rate)), longest)

    @property
    def _ahead(self) -> int:
        return math.ceil(AHEAD * self._tick_rate)

    def now(self) -> float:
        """Unix time in seconds."""
        return self.runs.now()

    def lease_of(self, room_id: str) -> Lease | None:
        """Under which a room is this server's; None without the room, or without other servers."""
        return None if self.leases is None else self.leases.book.of(room_id)

    # Runs begin and end.

    async def create(
        self,
        room: Room,
        creator: str | None = None,
        taken: Sequence[Pending] = (),
        key: str | None = None,
    ) -> None:
        """Enter a room that belongs to its creator, by a mark of that; raises LedgerError.

        taken: the inputs that it begins with, of one that was played elsewhere. key: of the
        request that made it.
        """
        record = self.runs.of(room)
        record.owned = record.known = True
        record.creator, record.key = creator, key
        rows = self.runs.rows_with(room, record, taken)
        try:
            await self.ledger.commit(*rows)
        except LedgerError:
            self.runs.forget(room)
            raise

    async def replace(
        self, old: Room, new: Room, settled: Settled | None, key: str | None = None
    ) -> None:
        """End a room's run and begin its next, both or neither; raises LedgerError.

        With the results of what fell in it, where each ball has one.
        """
        record = self.runs.of(old)
        now = self.now()
        number = self.runs.number(old.id)
        following = RoomRun(
            number, record.owned, record.opened, now, known=True, creator=record.creator, key=key
        )
        self.runs.report([])
        await self.ledger.commit(*self.runs.closing(old, settled), *self.runs.rows(new, following))
        self.runs.begin(new.id, following)

    async def end(self, room: Room, settled: Settled | None) -> None:
        """Close the room's run for good, as `replace` does; raises LedgerError."""
        self.runs.report([])
        await self.ledger.commit(*self.runs.closing(room, settled))
        self.runs.forget(room)

    def abandon(self, room: Room, why: str) -> None:
        """The room failed: its run is over, and what has no result gets its stake back."""
        record = self.runs.of(room)
        if record.known:
            void = Void(record.number, room.world.tick, why)
            self.runs.report([void, *self.runs.closing(room)])
        self.runs.forget(room)

    def close(self, room: Parked) -> None:
        self.runs.note(room.number, room.id)
        self.runs.report([Close(room.number, room.tick, self.now())])

    # Rooms leave the memory.

    def parkable(self, room: Room) -> bool:
        """Whether the ledger knows all of a sleeping room, so that memory may forget it."""
        return self.runs.of(room).clean

    def park(self, room: Room) -> RoomRow | None:
        """Forget a sleeping room; the row from which it is restored, if it has one."""
        record = self.runs.of(room)
        self.runs.forget(room)
        return self.runs.restorable_row(room, record) if record.known else None

    def touch(self, room: Room) -> None:
        self.runs.of(room).used = self.now()

    def leave(self, awake: Iterable[Room]) -> None:
        """The server stops: write down where the rooms stand that are awake, to go on there."""
        marks: list[Write] = []
        for room in awake:
            record = self.runs.of(room)
            if record.known:
                marks.append(self.runs.mark(room, record, room.world.tick, awake=True))
        self.runs.report(marks)

    # What happens in rooms.

    def submit(
        self, room: Room, pending: Pending, leaf: LogLeaf | None = None
    ) -> Coroutine[None, None, None]:
        """Have a planned input written down; what this returns ends when it is. Raises LedgerError.

        So may what it returns: then all that the room has planned and that is not durable is
        refused, the latest first. `leaf`: the receipt that goes into the log with the input.
        """
        record = self.runs.of(room)
        now = self.now()
        tick = record.marked = max(record.marked, pending.tick + self._ahead)
        rows = [] if record.known else self.runs.rows(room, record)
        kept = self.ledger.submit(
            *rows,
            Mark(record.number, tick, True, now),
            room.format.row(record.number, pending),
            *([] if leaf is None else [leaf]),
            line=record.number,
        )
        record.known = True
        record.clean = False
        record.used = now
        record.version += 1
        return _noted(record, kept, tick, first=bool(rows))

    def taken_back(self, room: Room, number: int) -> None:
        """The room has taken back all that the ledger has refused of its run `number`."""
        self.ledger.mend(number)
        if self.runs.find(room, number) is not None and not room.awake:
            self.slept(room)  # what was refused may have told the ledger that it is awake

    def may_step(self, room: Room) -> bool:
        """Whether the ledger has heard of the room's next tick; not asked for while it is lost.

        Unless servers share it: another one may take the room over from where it last heard. Nor
        is it asked of a room that it does not know: what moves there has moved since it began.
        """
        record = self.runs.of(room)
        if not record.known or room.world.tick < record.horizon:
            return True
        return not self.ledger.up and self.leases is None

    def landed(self, room: Room, landed: messages.Landed) -> None:
        """A ball has landed; the ledger hears of it with the next news."""
        result = room.format.result(self.runs.of(room).number, landed)
        if result is not None:
            self.runs.add_results([result])

    def slept(self, room: Room) -> None:
        self.runs.slept(room)

    def ticked(self, ticks: int, awake: Iterable[Room]) -> None:
        """So many ticks have passed; now and then the ledger hears how far the rooms have come."""
        self._since_renewal += ticks
        if self._since_renewal < _RENEW * self._tick_rate:
            return
        self._since_renewal = 0
        if not self.ledger.up:
            return  # what has landed is kept; that more has not can wait
        for room in awake:
            record = self.runs.of(room)
            if record.known and record.underway < _UNDERWAY:
                record.underway += 1
                tick = record.marked = max(record.marked, room.world.tick + self._ahead)
                done = functools.partial(self._renewed, room, record.number, record.version, tick)
                self.runs.report([self._mark(room, record, tick)], done)

    def _mark(self, room: Room, record: RoomRun, tick: int) -> Mark:
        """How far the room may tick; now and then with a checkpoint."""
        if room.world.tick - record.checkpoint_tick < _CHECKPOINT * self._tick_rate:
            return Mark(record.number, tick, True, self.now())
        record.checkpoint_tick = room.world.tick
        return self.runs.mark(room, record, tick, awake=True)

    def _renewed(
        self, room: Room, number: int, version: int, tick: int, error: LedgerError | None
    ) -> None:
        record = self.runs.find(room, number)
        if record is None:
            return
        record.underway -= 1
        if error is None and record.version == version:
            record.horizon = max(record.horizon, tick)


async def _noted(record: RoomRun, kept: "asyncio.Future[None]", tick: int, *, first: bool) -> None:
    """Wait until an input is kept, and note how far its room may then tick; raises LedgerError."""
    try:
        await kept
    except LedgerError:
        if first:
            record.known = False  # the next drop brings its row
        raise
    record.horizon = max(record.horizon, tick)
