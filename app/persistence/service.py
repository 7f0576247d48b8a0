"""Writes to the ledger what happens in rooms: each drop before it is announced, and progress.

The ledger has a mark of how far each room may tick, half a second ahead. A room that is rebuilt
after a crash continues from its mark. So it repeats no tick that clients have seen before the
crash, and no drop enters at such a tick.
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

AHEAD: Final = 0.5  # s from a room's tick to its mark: the most that a rebuilt room skips
_RENEW: Final = 0.25  # s between two marks of an awake room
_CHECKPOINT: Final = 10.0  # s of ticks between two checkpoints: limits the replay after a crash
_LONGEST_LEAD: Final = 0.5  # s, the longest that a drop waits for its tick
_UNDERWAY: Final = 8
"""Marks of one room that may wait for a slow ledger: two seconds of them. Further marks are left
out, because the next one covers them, so that the queue stays short however long a commit takes."""


class PersistenceService:
    """Decides what to write to the ledger, and when; for the event loop's thread.

    `now` returns Unix time in seconds; `leases` are this server's leases if several servers share
    the ledger.
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
        """Ticks from planning a drop to its start: time enough for the ledger to commit it."""
        longest = math.ceil(_LONGEST_LEAD * self._tick_rate)
        return min(max(1, math.ceil(self.ledger.lag * self._tick_rate)), longest)

    @property
    def _ahead(self) -> int:
        return math.ceil(AHEAD * self._tick_rate)

    def now(self) -> float:
        """Unix time in seconds."""
        return self.runs.now()

    def lease_of(self, room_id: str) -> Lease | None:
        """This server's lease of a room; None if it has none or no other server exists."""
        return None if self.leases is None else self.leases.book.of(room_id)

    # The begin and end of runs.

    async def create(
        self,
        room: Room,
        creator: str | None = None,
        taken: Sequence[Pending] = (),
        key: str | None = None,
    ) -> None:
        """Write a new room that belongs to `creator` (a mark); raises LedgerError.

        taken: the inputs of an imported room. key: the idempotency key of the request.
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
        """End a room's run and begin its next in one transaction; raises LedgerError.

        `settled` has the results of balls in flight, for rooms whose balls have results.
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
        """Close the room's run for good; raises LedgerError. `settled` is as in `replace`."""
        self.runs.report([])
        await self.ledger.commit(*self.runs.closing(room, settled))
        self.runs.forget(room)

    def abandon(self, room: Room, why: str) -> None:
        """End the run of a room that failed. Drops without a result get their stake back."""
        record = self.runs.of(room)
        if record.known:
            void = Void(record.number, room.world.tick, why)
            self.runs.report([void, *self.runs.closing(room)])
        self.runs.forget(room)

    def close(self, room: Parked) -> None:
        self.runs.note(room.number, room.id)
        self.runs.report([Close(room.number, room.tick, self.now())])

    # Rooms that leave memory.

    def parkable(self, room: Room) -> bool:
        """Whether a sleeping room may leave memory, because the ledger has all of it."""
        return self.runs.of(room).clean

    def park(self, room: Room) -> RoomRow | None:
        """Forget a sleeping room; returns the row to restore it from, if the ledger has one."""
        record = self.runs.of(room)
        self.runs.forget(room)
        return self.runs.restorable_row(room, record) if record.known else None

    def touch(self, room: Room) -> None:
        self.runs.of(room).used = self.now()

    def leave(self, awake: Iterable[Room]) -> None:
        """Write the awake rooms' exact ticks as the server stops, so that they skip nothing."""
        marks: list[Write] = []
        for room in awake:
            record = self.runs.of(room)
            if record.known:
                marks.append(self.runs.mark(room, record, room.world.tick, awake=True))
        self.runs.report(marks)

    # Events in rooms.

    def submit(
        self, room: Room, pending: Pending, leaf: LogLeaf | None = None
    ) -> Coroutine[None, None, None]:
        """Queue a planned input; the returned coroutine ends when the input is durable.

        Both raise LedgerError. If the coroutine does, all inputs that the room has planned and
        that are not durable are refused, the latest first. `leaf`: the receipt that is logged with
        the input.
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
        """Let the ledger accept inputs of run `number` again.

        Called when the room has taken back all inputs that the ledger refused.
        """
        self.ledger.reopen(number)
        if self.runs.find(room, number) is not None and not room.awake:
            self.slept(room)  # a refused input's mark may have said that the room is awake

    def may_step(self, room: Room) -> bool:
        """Whether the room may tick: whether a durable mark covers its next tick.

        A room that the ledger does not know needs no mark: it has had no input. While the ledger is
        unavailable, a server that has it for itself lets rooms tick on without marks. If servers
        share the ledger, the room waits, as another server may continue it from its last mark.
        """
        record = self.runs.of(room)
        if not record.known or room.world.tick < record.horizon:
            return True
        return not self.ledger.up and self.leases is None

    def landed(self, room: Room, landed: messages.Landed) -> None:
        """Keep a ball's result; it is written with the next write."""
        result = room.format.result(self.runs.of(room).number, landed)
        if result is not None:
            self.runs.add_results([result])

    def slept(self, room: Room) -> None:
        self.runs.slept(room)

    def ticked(self, ticks: int, awake: Iterable[Room]) -> None:
        """Count ticks, and every quarter of a second write a mark for each awake room."""
        self._since_renewal += ticks
        if self._since_renewal < _RENEW * self._tick_rate:
            return
        self._since_renewal = 0
        if not self.ledger.up:
            return  # results are kept in memory meanwhile, and marks can wait
        for room in awake:
            record = self.runs.of(room)
            if record.known and record.underway < _UNDERWAY:
                record.underway += 1
                tick = record.marked = max(record.marked, room.world.tick + self._ahead)
                done = functools.partial(self._renewed, room, record.number, record.version, tick)
                self.runs.report([self._mark(room, record, tick)], done)

    def _mark(self, room: Room, record: RoomRun, tick: int) -> Mark:
        """A mark up to `tick`, with a checkpoint if one is due."""
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
    """Wait until an input is durable, and then let its room tick further; raises LedgerError."""
    try:
        await kept
    except LedgerError:
        if first:
            record.known = False  # the next input writes the run's row again
        raise
    record.horizon = max(record.horizon, tick)
