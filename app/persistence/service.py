"""Writes to the ledger what happens in rooms: each input before it is announced, and results."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Final

from plinko.app.errors import LedgerError
from plinko.app.persistence.clock import SteadyClock
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.recovery.recovery import Recovery
from plinko.app.persistence.room_runs import RoomRun, RoomRuns
from plinko.app.rooms.keys import IdempotencyKey, KeyUse
from plinko.app.rooms.kinds import BallLimits
from plinko.app.rooms.pending import Pending
from plinko.app.rooms.records import Close, ListedRoom, NewDrop, ResultRow, Void, Write
from plinko.app.rooms.room import Room
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.settings import TICK_RATE

_CHECKPOINT: Final = 10.0  # s of ticks between two checkpoints: limits the replay after a crash
_RESULTS_WAIT: Final = 0.25  # s
_LONGEST_LEAD: Final = 0.5  # s, the longest that a drop waits for its tick


class PersistenceService:
    """Decides what to write to the ledger, and when; for the event loop's thread.

    `now` returns Unix time in seconds and never goes back.
    """

    def __init__(
        self,
        ledger: Ledger,
        *,
        limits: BallLimits,
        now: Callable[[], float] | None = None,
    ) -> None:
        self.ledger = ledger
        self.runs = RoomRuns(ledger, now or SteadyClock())
        self.leases = self.runs.leases
        self.recovery = Recovery(self.runs, limits)
        self.limits = limits

    @property
    def lead(self) -> int:
        """Ticks from a request to its start: time enough for the ledger to commit it."""
        longest = math.ceil(_LONGEST_LEAD * TICK_RATE)
        return min(max(1, math.ceil(self.ledger.lag * TICK_RATE)), longest)

    def now(self) -> float:
        """Unix time in seconds."""
        return self.runs.now()

    # The begin and end of runs.

    async def create(
        self,
        room: Room,
        creator: str | None,
        imported: Sequence[Pending],
        use: KeyUse,
    ) -> None:
        """Write a new room that belongs to `creator` (a mark), if the `use` of the key is new.

        imported: the inputs of an imported room. Raises LedgerError, KeyReusedError.
        """
        record = await self.runs.new_run(room.id, owned=True, known=True)
        record.creator = creator
        self.runs.begin(room.id, record)
        use.run, use.fact = record.number, room.id
        rows = self.runs.rows(room, record, imported)
        made = False
        try:
            await self.ledger.commit(*rows, use=use)
            made = use.is_new
        finally:
            if not made:
                self.runs.forget(room)

    async def replace(
        self,
        old: Room,
        new: Room,
        results: Sequence[ResultRow],
        use: KeyUse,
    ) -> None:
        """End a room's run and begin its next in one transaction, if the `use` of the key is new.

        `results` are those of the balls in flight. Raises LedgerError, KeyReusedError.
        """
        record = self.runs.of(old)
        following = await self.runs.new_run(old.id, owned=record.owned, known=True)
        following.creator = record.creator
        use.run, use.fact = following.number, old.id
        self.runs.report([])
        rows = (*self.runs.closing(old, results), *self.runs.rows(new, following))
        await self.ledger.commit(*rows, use=use)
        if use.is_new:
            self.runs.begin(new.id, following)

    async def end(self, room: Room, results: Sequence[ResultRow]) -> None:
        """Close the room's run for good; raises LedgerError. `results` are as in `replace`."""
        self.runs.report([])
        await self.ledger.commit(*self.runs.closing(room, results))
        self.runs.forget(room)

    def abandon(self, room: Room, results: Sequence[ResultRow], why: str) -> None:
        """End the run of a room that failed. Drops without a result get their stake back."""
        record = self.runs.of(room)
        if record.known:
            tick = max((each.tick for each in results), default=room.world.tick)
            void, close = Void(record.number, tick, why), Close(record.number, tick, self.now())
            self.runs.report([*results, void, close])
        self.runs.forget(room)

    def close(self, room: ListedRoom) -> None:
        """End the run of a room that is not in memory."""
        self.leases.book.note(room.number, room.id)
        self.runs.report([Close(room.number, room.tick, self.now())])

    # Rooms that leave memory.

    def park(self, room: Room) -> None:
        """Forget a sleeping room, and release its lease."""
        record = self.runs.of(room)
        if record.known:
            # The mark has the time of the last use, by which unused rooms are found.
            mark = self.runs.mark(room, record, awake=False)
            self.runs.report([replace(mark, used=record.used)])
        self.runs.forget(room)
        self.leases.let_go(room.id)

    def touch(self, room: Room) -> None:
        self.runs.of(room).used = self.now()

    def leave(self, awake: Iterable[Room]) -> None:
        """Write where awake rooms of touching balls stand, as the server stops or gives them up."""
        marks: list[Write] = []
        for room in awake:
            record = self.runs.of(room)
            if record.known and isinstance(room, TouchingRoom):
                marks.append(self.runs.mark(room, record, awake=True))
        self.runs.report(marks)

    # Events in rooms.

    async def drop(self, room: Room, request: NewDrop) -> NewDrop:
        """Make a drop a fact of the room's run; returns the request with the fact.

        Raises LedgerError, and the errors with which the writer's turn refuses a drop.
        """
        record = self.runs.of(room)
        request.room = record.number
        first = self._first_rows(room, record)
        try:
            return await self.ledger.drop(request, *first)
        except LedgerError:
            record.known = record.known and not first  # the next input writes the rows again
            raise

    async def submit(
        self, room: TouchingRoom, pending: Pending, key: IdempotencyKey | None
    ) -> None:
        """Return when a planned input is durable and has its number.

        Raises LedgerError, and the errors with which the writer's turn refuses an input.
        """
        record = self.runs.of(room)
        first = self._first_rows(room, record)
        new = room.format.new(record.number, pending, key)
        mark = self.runs.mark(room, record, awake=True, checkpoint=False)
        try:
            await self.ledger.submit(*first, mark, new)
        except LedgerError:
            record.known = record.known and not first
            raise
        if new.error is not None:
            raise new.error
        pending.number = new.number

    def _first_rows(self, room: Room, record: RoomRun) -> list[Write]:
        """The rows that the ledger must have before an input."""
        rows = [] if record.known else self.runs.rows(room, record)
        record.known = True
        record.used = self.now()
        return rows

    def ticked(self, room: TouchingRoom) -> None:
        """Write a checkpoint of an awake room of touching balls, if one is due."""
        record = self.runs.of(room)
        due = record.checkpoint_tick + _CHECKPOINT * TICK_RATE
        if record.known and self.ledger.up and room.world.tick >= due:
            self.runs.report([self.runs.mark(room, record, awake=True)])

    def keep_results(self, results: list[ResultRow]) -> None:
        """Write results with the next write, or alone after a while without one."""
        self.runs.add_results(results)
        if self.ledger.up and self.runs.results_since + _RESULTS_WAIT < self.now():
            self.runs.report([])
