"""The runs of the rooms in memory: how much of each the ledger has, and what to write next.

A run is one world of a room from tick 0 on; resetting a room begins a new run. Results of balls
wait here until something else is written.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import msgspec

from plinko.app.errors import ClosedRoomError
from plinko.app.persistence.clock import RunClock, SteadyClock
from plinko.app.persistence.leases import Leases
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import lease_store
from plinko.app.rooms.pending import Pending
from plinko.app.rooms.records import BoardRow, Close, DrawRow, Mark, ResultRow, RoomRow, Write
from plinko.app.rooms.room import Ground, Room
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.settings import TICK_RATE
from plinko.engine import PHYSICS_VERSION


@dataclass(slots=True)
class RoomRun:
    """A room's run, and how much of it the ledger has. Times are Unix times."""

    number: int
    owned: bool
    opened: float
    used: float
    clock: RunClock
    known: bool = False  # whether its row was handed to the ledger
    checkpoint_tick: int = 0
    creator: str | None = None  # a mark, see RoomRow


class RoomRuns:
    """All records, by room; for the event loop's thread. `now` returns Unix time in seconds."""

    def __init__(self, ledger: Ledger, now: Callable[[], float]) -> None:
        self.ledger = ledger
        self.now = now
        self.leases = Leases(ledger)
        self.next_number = 1
        self._records: dict[str, RoomRun] = {}
        self._results: list[Write] = []
        self.results_since = math.inf  # when the first of them came, Unix time in s

    def of(self, room: Room) -> RoomRun:
        """The record of a room's current run; raises ClosedRoomError after its end."""
        found = self._records.get(room.id)
        if found is None:
            raise ClosedRoomError(f"room {room.id!r} was closed meanwhile", field="room")
        return found

    async def new_run(self, room_id: str, *, owned: bool = False, known: bool = False) -> RoomRun:
        """The record of a run that begins now; raises LedgerError if it can get no number."""
        if self.leases.book.alone:
            number, self.next_number = self.next_number, self.next_number + 1
        else:
            number = await self.ledger.read(lease_store.reserve)
        self.leases.book.note(number, room_id)
        return self.made(number, owned=owned, known=known)

    def made(self, number: int, *, owned: bool = False, known: bool = False) -> RoomRun:
        """The record of the run of this number, which begins now."""
        now = self.now()
        return RoomRun(number, owned, now, now, self.clock(now), known)

    def _now(self) -> float:
        return self.now()

    async def follow_database(self) -> None:
        """Go by the database's time from now on: the servers' clocks may differ by seconds."""
        if isinstance(clock := self.now, SteadyClock):
            # Set on the ledger's thread: a busy event loop would get the time late.
            await self.ledger.read(lambda connection: clock.set(lease_store.unix_time(connection)))

    def clock(self, opened: float, least: int = 0) -> RunClock:
        return RunClock(self._now, TICK_RATE, opened, least)

    def begin(self, room_id: str, record: RoomRun) -> None:
        """Make this run the room's current one."""
        self._records[room_id] = record
        self.leases.book.note(record.number, room_id)

    def forget(self, room: Room) -> None:
        """Drop the record of a room that leaves memory. The ledger keeps its rows."""
        self._records.pop(room.id, None)

    def add_results(self, results: list[ResultRow]) -> None:
        """Keep results until the next write."""
        if results and not self._results:
            self.results_since = self.now()
        self._results += results

    def report(self, writes: list[Write]) -> None:
        """Hand the waiting results and `writes` to the ledger."""
        results, self._results = self._results, []
        self.results_since = math.inf
        self.ledger.defer([*results, *writes])

    def slept(self, room: Room) -> None:
        """Write that nothing moves in a room."""
        record = self.of(room)
        if record.known:
            self.report([self.mark(room, record, awake=False)])

    def mark(self, room: Room, record: RoomRun, *, awake: bool, checkpoint: bool = True) -> Mark:
        """A mark of a room's progress; for touching balls with a checkpoint, unless it is False."""
        mark = Mark(record.number, room.log_tick, awake, self.now())
        if not isinstance(room, TouchingRoom) or not checkpoint:
            return mark
        record.checkpoint_tick = room.world.tick
        return replace(mark, checkpoint=room.checkpoint(), checkpoint_drops=room.input_count)

    def closing(self, room: Room, results: Sequence[ResultRow]) -> list[Write]:
        """The writes that end a room's run, with the results of balls that were in flight."""
        tick = max((each.tick for each in results), default=room.log_tick)
        return [*results, Close(self.of(room).number, tick, self.now())]

    def board_row(self, origin: Ground) -> BoardRow:
        return BoardRow(origin.digest, origin.name, msgspec.json.encode(origin.to_dict()).decode())

    def rows(self, room: Room, record: RoomRun, imported: Sequence[Pending] = ()) -> list[Write]:
        """All rows that the ledger must have before a run's next input.

        imported: the inputs with which a room of touching balls begins.
        """
        draw, checkpoint, inputs = room.draw, None, list[Write]()
        if isinstance(room, TouchingRoom) and (room.world.tick or imported):
            record.checkpoint_tick, checkpoint = room.world.tick, room.checkpoint()
            inputs += [room.format.new(record.number, pending) for pending in imported]
        row = RoomRow(
            number=record.number,
            id=room.id,
            board=room.origin.digest,
            mode=room.mode,
            owned=record.owned,
            tick_rate=room.tick_rate,
            physics_version=PHYSICS_VERSION,
            opened=record.opened,
            used=record.used,
            tick=0 if checkpoint is None else room.log_tick,
            checkpoint=checkpoint,
            checkpoint_drops=0 if checkpoint is None else room.input_count,
            creator=record.creator,
            draw=None if draw is None else draw.digest,
        )
        drawn = [] if draw is None else [DrawRow(draw.digest, draw.to_json().decode())]
        board = BoardRow(room.origin.digest, room.origin.name, room.origin_json.decode())
        return [board, *drawn, row, *inputs]
