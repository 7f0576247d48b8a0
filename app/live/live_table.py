"""A running table of independent balls. A drop goes through this file from top to bottom:

1. The request is checked: the table's limits, the player's session, the start.
2. The writer's turn makes it a fact: number, tick, seed and receipt, committed together.
3. Its flight is computed from the fact. Nothing that could refuse the drop has seen the result.
4. The ball enters at the fact's tick, or late, at the place where it would be; it is announced.

A tick samples the flights at the tick of the run's clock and announces the landings since the last
one. A tick that is late shows the present; nothing is caught up.
"""

import asyncio
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, cast

from plinko.app.errors import AppError, ResetError
from plinko.app.live.broadcast.audience import Player
from plinko.app.live.live_room import LiveRoom, RoomContext
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.persistence.clock import RunClock
from plinko.app.persistence.statements import store
from plinko.app.protocol import messages
from plinko.app.protocol.paths import LONG, Path, path_of
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.keys import KeyUse
from plinko.app.rooms.outcome import Outcome, outcome_of
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import DropRow, NewDrop, ResultRow
from plinko.app.rooms.room import Room
from plinko.engine import Board
from plinko.engine.drops.flight import Flight
from plinko.engine.drops.sliced import SlicedFlight
from plinko.engine.errors import EngineError

_ASIDE: Final = 4096  # events of a slice on a thread
_LARGE: Final = 500  # pegs and walls of a board whose arrays take more than 1 ms to make


@dataclass(eq=False)
class _Coming:
    """A fact whose ball is about to enter; its caller waits for `entered`."""

    fact: DropRow
    receipt: messages.SignedReceipt | None
    flight: Flight
    path: Path | None
    player: Player
    entered: "asyncio.Future[messages.Accepted]"


class LiveTable(LiveRoom):
    """One running table, for the event loop's thread."""

    room: IndependentRoom
    clock: RunClock

    def __init__(self, room: IndependentRoom, context: RoomContext) -> None:
        self._coming: deque[_Coming] = deque()
        self._under_way = 0  # drops that have not entered yet
        self._none_under_way = asyncio.Event()
        self._none_under_way.set()
        self._in_order = asyncio.Lock()  # balls enter in the order of their numbers
        super().__init__(room, context)

    def _begin(self, room: Room) -> None:
        self.clock = self._persistence.runs.of(room).clock
        super()._begin(room)

    @property
    def busy(self) -> bool:
        return self._under_way > 0

    @property
    def awake(self) -> bool:
        return self.room.awake or bool(self._coming)

    # A drop.

    async def _drop(
        self, command: DropCommand, player: Player, session: FairSession | None
    ) -> Outcome:
        room = self.room
        try:
            self._check_drop(command, session)
        except (AppError, EngineError):
            # A drop that the table has taken before needs no place, and no session that is open.
            outcome = await self._repeated(player)
            if outcome is None:
                raise
            return outcome
        self._under_way += 1
        self._none_under_way.clear()
        try:
            request = await self._persistence.drop(room, self._request(command, player, session))
            assert request.fact is not None
            if session is not None:
                session.took(request)
            if request.earlier:
                return await self._earlier(request.fact, request.receipt, request.result)
            return Outcome(await self._enter(room, request, player))
        finally:
            self._under_way -= 1
            if not self._under_way:
                self._none_under_way.set()
                if self.room is room and self.gone is None and not self.awake:
                    self._persistence.runs.slept(room)  # the drop was refused, or is an earlier one

    def _check_drop(self, command: DropCommand, session: FairSession | None) -> None:
        """Raise the error for which the table refuses a drop now."""
        room, fair = self.room, session is not None
        self._check()
        self._runner.check_memory(room)
        room.check_drop(command, fair=fair)
        room.check_place(self._under_way)
        if session is not None:
            session.check(room, practice=command.practice)
        room.check_start(command, fair=fair)

    def _request(
        self, command: DropCommand, player: Player, session: FairSession | None
    ) -> NewDrop:
        now = self._persistence.now()
        return NewDrop(
            room=0,
            tick=self.clock.tick + (self._persistence.lead if self.awake else 0),
            command=command,
            used=now,
            key=player.idempotency_key,
            session=None if session is None else session.turn(self.room.draw, now),
        )

    async def _repeated(self, player: Player) -> Outcome | None:
        """The outcome of the drop that the player has sent with this key before, if any."""
        ledger = self._persistence.ledger
        found = await ledger.look_up(KeyUse(player.idempotency_key))
        if found is None:
            return None
        rows = await ledger.read(store.drop, run=found.run, ball=int(found.fact))
        return await self._earlier(*rows)

    async def _earlier(
        self, fact: DropRow, receipt: messages.SignedReceipt | None, result: ResultRow | None
    ) -> Outcome:
        """The outcome of a drop that the player has sent before; its flight says if it is over."""
        room = self.room
        if fact.room != self._persistence.runs.of(room).number:  # the room was reset since
            board = await self._persistence.recovery.board_of(fact.room)
            return outcome_of(board, fact, receipt, result)
        if result is None:
            computed = room.result(fact, await fly(room.board, room.start_of(fact)))
            result = computed if computed.tick <= room.world.tick else None
        return outcome_of(room.board, fact, receipt, result)

    async def _enter(
        self, room: IndependentRoom, request: NewDrop, player: Player
    ) -> messages.Accepted:
        """Compute the flight of a new fact, let its ball enter, and announce it."""
        fact = request.fact
        assert fact is not None
        async with self._in_order:
            try:
                flight = await fly(room.board, room.start_of(fact))
                path = await cut(fact, flight, room.tick_rate)
            except Exception as error:
                self._runner.fail(self, error)
                raise (self.gone or error) from error
            if self.gone is not None:
                raise self.gone
            if self.room is not room:
                raise ResetError(f"room {self.id!r} was reset", field="room")
            entered = asyncio.get_running_loop().create_future()
            self._coming.append(_Coming(fact, request.receipt, flight, path, player, entered))
        self._catch_up(fact.tick)
        self._runner.guarded(self, self._admit)
        self._runner.run(self)
        return await cast("asyncio.Future[messages.Accepted]", entered)

    def _admit(self) -> None:
        """Let the balls enter whose tick has come, and announce them."""
        room = self.room
        while self._coming and self._coming[0].fact.tick <= room.world.tick:
            coming = self._coming[0]
            accepted = room.enter(coming.fact, coming.flight, coming.receipt, coming.path)
            self._coming.popleft()
            own = cast(messages.Accepted, self._announce(room.seq, coming.player, accepted))
            if not coming.entered.done():
                coming.entered.set_result(own)

    # Ticks.

    def _catch_up(self, tick: int) -> None:
        """Let a table at rest, which does not tick, go to this tick or to the present one."""
        if not self.room.awake:
            self.room.advance(min(tick, self.clock.tick))
            self.tick_time = self._runner.clock()

    def wake(self) -> None:
        self._catch_up(self.clock.tick)
        super().wake()

    def advance(self, due: int, until: float) -> None:
        """Show the state at the clock's tick, and announce what has happened since the last one."""
        room, before, now = self.room, self.room.world.tick, self.clock.tick
        # Only the snapshot stream has contacts and flags bounces.
        watched = self._context.audiences.hub.count(self.id, messages.SNAPSHOTS) > 0
        while self._coming and (entry := self._coming[0].fact.tick) <= now:
            self._publish(room.advance(entry, watched=watched))
            self._admit()
        events = room.advance(now, watched=watched)
        moved = room.world.tick > before
        if moved:
            self.tick_time = self._runner.clock()
        self._publish(events, with_snapshot=moved)
        if not self.awake:
            self._sleep()

    def _publish(self, events: Sequence[messages.Event], *, with_snapshot: bool = False) -> None:
        self._persistence.keep_results(self.room.take_results())
        super()._publish(events, with_snapshot=with_snapshot)

    async def cut_paths(self) -> None:
        room = self.room
        for ball in room.uncut:
            room.cut_path(ball)
            await asyncio.sleep(0)

    def _sleep(self) -> None:
        self._leave_runner()
        if not self._under_way:  # else the next drop will wake it, and its row says so already
            self._persistence.runs.slept(self.room)

    # Its end.

    async def settled(self) -> None:
        if self._under_way:
            await self._persistence.ledger.commit()  # decides all earlier drops
            await self._none_under_way.wait()

    def open_results(self) -> list[ResultRow]:
        # Only a room that has failed still has balls that could not enter, or results not kept.
        room = self.room
        late = [room.result(each.fact, each.flight) for each in self._coming]
        known = [*late, *room.take_results(), *room.open_results()]
        return list({each.ball: each for each in known}.values())

    def land_all(self) -> None:
        landed = self.room.land_all()
        self.room.take_results()  # the ledger has them
        self._publish(landed)

    def _leave_behind(self, error: AppError) -> None:
        super()._leave_behind(error)
        for coming in self._coming:
            if not coming.entered.done():
                coming.entered.set_exception(error)
        self._coming.clear()


async def fly(board: Board, x: float) -> Flight:
    """The flight of a ball that starts at x, in m; raises EffortError if an event takes too long.

    The event loop never computes a hundred thousand impacts, nor the arrays of a large board.
    """
    flight = SlicedFlight(board, x)
    if len(board.pegs) + len(board.walls) < _LARGE and flight.advance(LONG):
        return flight.flight()
    return await asyncio.to_thread(_finish, flight)


async def cut(fact: DropRow, flight: Flight, rate: int) -> Path | None:
    """The path of a long flight; None for a short one, which the room cuts when a client needs it.

    rate: ticks a second.
    """
    if len(flight.trajectory.impacts) <= LONG:
        return None
    return await asyncio.to_thread(path_of, fact.ball, fact.tick, rate, flight.trajectory)


def _finish(flight: SlicedFlight) -> Flight:
    while not flight.advance(_ASIDE):
        pass
    return flight.flight()
