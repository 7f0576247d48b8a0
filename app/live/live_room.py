"""One room while it is played in: its balls, who watches, what is asked of it and its ticks.

The room itself is pure (app/rooms). Here it meets time, the ledger and the audience: what is asked
is planned, kept, carried out at its tick and told, in this order, whoever asks.
"""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from dataclasses import dataclass, replace
from typing import Final, TypeVar, cast

from app.errors import (
    AppError,
    ClosedRoomError,
    LedgerError,
    RepeatedError,
    ResetError,
    UndecidedError,
)
from app.live.broadcast.audience import NOBODY, Audience, Means, Player
from app.live.broadcast.hub import Client
from app.live.halts import Halts
from app.live.queue import RoomQueue
from app.live.sessions.fair_session import FairSession, TakenDrop
from app.live.ticking.landings import Landings
from app.live.ticking.runner import Runner
from app.persistence.service import PersistenceService
from app.persistence.statements import store
from app.protocol import messages
from app.protocol.touching_messages import Change
from app.protocol.wire import WireMessage
from app.rooms.outcome import Outcome, outcome_of
from app.rooms.pending import DropCommand, Entered, Pending
from app.rooms.records import InputRow
from app.rooms.room import Room
from app.rooms.settling import Settled, settle

Taken = TypeVar("Taken", messages.Accepted, Outcome)
"""What comes of a drop, for who asks anew and for who asks again."""

_ALONE: Final = 10.0  # s; who reloads the page finds the scene going on

_LOOK: Final = 0.002  # s that a room may follow paths in a turn; those of most drops take 0.1 ms


@dataclass(frozen=True)
class Around:
    """What all live rooms of a server share. `new_id` names a life of a room, `draw` gives a seed.

    `filmed` says whether a room is watched by others than clients of the hub.
    """

    audiences: Means
    persistence: PersistenceService
    halts: Halts
    runner: Runner
    new_id: Callable[[], str]
    filmed: Callable[[str], bool]
    draw: Callable[[], int]


@dataclass(eq=False)
class _Asked:
    """Who waits for an input to enter, and its place in a fair session, if it has one."""

    player: Player
    taken: TakenDrop | None
    entered: "asyncio.Future[messages.Event | None]"
    left: AppError | None = None
    """The error for who waits, once its room has ended or gone: then it does not enter."""


class LiveRoom:
    """For the event loop's thread. `room` is what stands there now: a reset puts another there."""

    def __init__(self, room: Room, around: Around) -> None:
        self.id = room.id
        self.room = room
        self.audience = Audience(around.audiences, room, around.new_id())
        self.landings = Landings()
        self.tick_time = 0.0  # of the last tick, s of the server's clock
        self._around = around
        self._persistence = around.persistence
        self._runner = around.runner
        self._asked: dict[Pending, _Asked] = {}
        # Drops under way that may be asked for again, by key.
        self._under_way: dict[str, asyncio.Task[messages.Accepted | Outcome]] = {}
        self._shut: list[AppError] = []  # why nothing is taken for now
        self.gone: AppError | None = None  # why it is not here any more
        self._alone = 0  # ticks for which nobody watched a scene
        self._behind = 0  # ticks by which it waits for another thread
        self._missed = 0  # ticks in a row that were due and did not run
        self.queue = self._new_queue()
        self._begin()

    def _begin(self) -> None:
        self.room.owned = self.owned
        self._runner.wake(self)

    def _new_queue(self) -> RoomQueue:
        """What waits in the run that begins or goes on now."""
        record = self._persistence.runs.of(self.room)
        return RoomQueue(
            self._persistence.ledger,
            record.number,
            drop=self.drop_once,
            flying=lambda: {ball.ball for ball in self.room.balls},
            landing=self.landings.next,
            draw=self._around.draw,
            tell=self.audience.notify,
            empty=not record.known,
        )

    @property
    def owned(self) -> bool:
        """Whether the room has a creator, who alone may change it."""
        return self._persistence.runs.of(self.room).owned

    @property
    def watched(self) -> bool:
        return self._around.audiences.hub.count(self.id) > 0 or self._around.filmed(self.id)

    def tell_waiting(self, client: Client) -> None:
        """Send a client that was greeted just now what waits in the queue, if anything does."""
        if self.queue.items:
            client.post(WireMessage.of_text(messages.encode_event(self.queue.event)))

    # What is asked.

    async def drop(
        self,
        command: DropCommand,
        player: Player = NOBODY,
        session: FairSession | None = None,
    ) -> messages.Accepted:
        """Take a drop; return once it is durable, its tick has come, and the room was told.

        In a `session` the seed is that of its next drop, and its receipt is kept with the drop.
        Raises HaltedError, BallLimitError, BusyError, SessionStateError, InvalidValueError,
        LedgerError, UndecidedError and the engine's errors.
        """
        work = self._begin_drop(player.again, self._drop(command, player, session))
        return await self._persistence.ledger.decided(work)

    async def drop_once(
        self,
        command: DropCommand,
        player: Player,
        session: FairSession | None = None,
    ) -> Outcome:
        """What came of the last drop that `player.again` names; takes a drop if there is none.

        Raises what `drop` raises, and RepeatedError where only the room's log can say.
        """
        decided, before = self._persistence.ledger.decided, self._under_way.get(player.again or "")
        if before is None:
            drop = self._drop_unless_kept(command, player, session)
            return await decided(self._begin_drop(player.again, drop))
        try:
            found = await decided(before)
        except UndecidedError as undecided:
            undecided.outcome = None  # it is for who asked first; who asks again may do so again
            raise
        outcome = found if isinstance(found, Outcome) else Outcome(found)
        return replace(outcome, earlier=True)

    def _begin_drop(
        self, again: str | None, drop: Coroutine[None, None, Taken]
    ) -> "asyncio.Task[Taken]":
        """Begin a drop, which goes on to its end whoever waits for it."""
        work = asyncio.create_task(drop)
        if again is not None:
            self._under_way[again] = work

            def ended(_: object) -> None:
                if self._under_way.get(again) is work:
                    del self._under_way[again]

            work.add_done_callback(ended)
        return work

    async def _drop_unless_kept(
        self, command: DropCommand, player: Player, session: FairSession | None
    ) -> Outcome:
        number = self._persistence.runs.of(self.room).number
        read = self._persistence.ledger.read
        found = await read(store.keyed, room=number, key=player.again or "")
        if isinstance(found, InputRow):
            raise RepeatedError(
                "a drop with this key was taken before: the room's log has it", field="key"
            )
        if found is not None:
            return outcome_of(self.room.ground, *found)
        return Outcome(await self._drop(command, player, session))

    async def _drop(
        self, command: DropCommand, player: Player, session: FairSession | None
    ) -> messages.Accepted:
        self._check()
        self._runner.check_memory()
        self.room.check_drop(command, fair=session is not None)
        if session is not None:
            session.check(self.room, practice=command.practice)
            command = replace(command, seed=session.next_seed(self.room.draw))
        pending = self.room.plan_drop(command, self._persistence.lead, player.again)
        taken = None
        if session is not None:
            number = self._persistence.runs.of(self.room).number
            taken = session.take(pending, number, self._persistence.now())
        return cast(messages.Accepted, await self._carry_out(pending, player, taken))

    async def change(self, change: Change, player: Player = NOBODY) -> messages.Event | None:
        """Take an input of a room whose balls touch each other, as `drop` takes a drop.

        Returns the first event that came of it, if any. Raises InvalidValueError,
        MissingBallError, BallLimitError, HaltedError, LedgerError, UndecidedError.
        """
        return await self._persistence.ledger.decided(self._change(change, player))

    async def _change(self, change: Change, player: Player) -> messages.Event | None:
        self._check()
        pending = self.room.plan_change(change, self._persistence.lead)
        return await self._carry_out(pending, player, None)

    def _check(self) -> None:
        """Raise what stands in the way of everything that is asked now."""
        self._around.halts.check(self.id)
        self._check_here()

    def _check_here(self) -> None:
        """Raise what stands in the way while the room goes or ends, and once it has."""
        if self.gone is not None:
            raise self.gone
        if self._shut:
            raise self._shut[-1]

    async def _carry_out(
        self, pending: Pending, player: Player, taken: TakenDrop | None
    ) -> messages.Event | None:
        """Have a planned input kept, and wait until it has entered; returns its first event."""
        room, persistence = self.room, self._persistence
        number = persistence.runs.of(room).number
        asked = _Asked(player, taken, asyncio.get_running_loop().create_future())
        self._asked[pending] = asked
        try:
            kept = persistence.submit(room, pending, None if taken is None else taken.leaf)
        except LedgerError:
            self._take_back(room, pending)
            raise
        try:
            await kept
        except LedgerError:
            if asked.left is None:
                self._take_back(room, pending)
            elif taken is not None:
                taken.settled(refused=True)
            if not room.planned or room.planned[-1].durable:
                persistence.taken_back(room, number)
            raise
        if taken is not None:
            pending.receipt = taken.settled(refused=False)
        if asked.left is not None:
            raise asked.left
        pending.durable = True
        self._runner.admit(self)
        return await asked.entered

    def _take_back(self, room: Room, pending: Pending) -> None:
        """What was planned last was never asked for: its numbers are the next one's."""
        asked = self._asked.pop(pending)
        if asked.taken is not None:
            asked.taken.settled(refused=True)
        room.refuse(pending)

    # Ticks.

    @property
    def ticks(self) -> bool:
        """Whether the runner has turns for it."""
        return self._runner.runs(self)

    def admit(self) -> None:
        """Carry out what is planned for this tick and durable, and tell everyone."""
        number = self.room.seq + 1
        for entered in self.room.enter():
            self._tell(entered, number)
            number += len(entered.events)
            self._runner.run(self)
        self._begin_step()

    def _tell(self, entered: Entered, number: int) -> None:
        """Tell everyone what came of an input: events from this `number` of the room's on."""
        asked = self._asked.pop(entered.pending, None)
        player = NOBODY if asked is None else asked.player
        first = None
        for seq, event in enumerate(entered.events, number):
            own = self.audience.announce(seq, player, event)
            self._runner.counts.accepted += isinstance(event, messages.Accepted)
            first = first or own
        if entered.restarts:
            self.audience.begin(self.room, self._around.new_id())
        if asked is None or asked.entered.done():
            return
        if entered.failed is None:
            asked.entered.set_result(first)
        else:
            asked.entered.set_exception(entered.failed)

    def wake(self) -> None:
        """See to it that it ticks, if something moves: somebody has come."""
        self._alone = 0
        self._runner.wake(self)

    def advance(self, due: int, until: float) -> None:
        """Run the `due` ticks as far as there is time, which `until` says by the runner's clock.

        Ticks that do not fit are given up, but for those that wait for another thread.
        """
        room, runner = self.room, self._runner
        # Only this stream tells of contacts, and flags bounces.
        watched = self._around.audiences.hub.count(self.id, messages.SNAPSHOTS) > 0
        events: list[messages.Event] = []
        before = room.world.tick
        look_until = min(until, runner.clock() + _LOOK)
        wanted = min(due + self._behind, runner.catch_up)
        runner.counts.skipped += due + self._behind - wanted
        self._behind = 0
        for number in range(wanted):
            if number and runner.clock() > until:
                runner.counts.skipped += wanted - number
                break
            if room.held:
                self._pass_on(events)
                events = []
                self.admit()
            if room.held or not room.awake or not self._persistence.may_step(room):
                break
            if not self._prepared(look_until):
                if room.steps_aside:
                    self._behind = wanted - number
                else:
                    runner.counts.skipped += wanted - number
                break
            events += room.step(watched=watched)
        stepped = room.world.tick > before
        if stepped:
            self.tick_time = runner.clock()
            self._missed = 0
        else:
            self.miss(due)
        self._pass_on(events, with_snapshot=stepped or room.touched)
        self.audience.diagnose(before)
        if not room.awake or self._is_left(due):
            self._sleep()
            return
        if room.held:
            self.admit()
        self._begin_step()

    def miss(self, ticks: int) -> None:
        """Ticks were due and none of them ran: after a while they count as late."""
        before, patience = self._missed, self._runner.patience
        self._missed += ticks
        self._runner.counts.late += max(0, self._missed - max(before, patience))

    def _sleep(self) -> None:
        self._leave_runner()
        self._persistence.slept(self.room)

    def _leave_runner(self) -> None:
        self._runner.drop_out(self)
        self._alone = self._behind = self._missed = 0

    def _is_left(self, due: int) -> bool:
        """Whether all that moves here moves for nobody, and has for a while.

        Its clock then stands still until somebody comes: in a scene nothing is waited for, and
        without friction it would move for ever.
        """
        if not self.room.is_scene or self.room.planned or self.watched:
            self._alone = 0
            return False
        self._alone += due
        return self._alone > _ALONE * self.room.tick_rate

    def _prepared(self, until: float) -> bool:
        """Compute ahead what the room needs, a piece at least; returns whether it can step."""
        while self.room.look_ahead() and self._runner.clock() < until:
            pass
        return self.room.ready

    def _begin_step(self) -> None:
        """Have the next tick computed, if that is for another thread."""
        compute = self.room.begin_step()
        if compute is not None:
            self._runner.compute(self, compute)

    def computed(self) -> None:
        """The next tick is there: run it, if it has been due."""
        if self._behind and self.ticks:
            self._runner.take_turn(self)

    def _pass_on(
        self,
        events: list[messages.Event],
        *,
        with_snapshot: bool = False,
        kept: bool = False,
    ) -> None:
        """Send events, and the snapshot of this moment; and settle who has landed.

        `kept`: the ledger has it already.
        """
        self.audience.broadcast(events, with_snapshot=with_snapshot)
        for event in events:
            if isinstance(event, messages.Landed):
                self._runner.counts.landed += 1
                if not kept:
                    self._persistence.landed(self.room, event)
                self.landings.landed(event)

    # Its end.

    @contextlib.contextmanager
    def taking_nothing(self, why: AppError) -> Iterator[None]:
        """Refuse all that is asked meanwhile, with this error."""
        self._shut.append(why)
        try:
            yield
        finally:
            self._shut.remove(why)

    @contextlib.asynccontextmanager
    async def ending(self) -> AsyncIterator[Settled | None]:
        """Take nothing more, and find out how what falls here ends.

        None where no ball has an end of its own. Raises LedgerError while what was taken cannot be
        written, and BusyError where a ball falls too long to compute: then the room goes on;
        ClosedRoomError where it has gone meanwhile.
        """
        try:
            self._check_here()
        except ResetError as ending:
            raise UndecidedError(str(ending), field="room", retry_after=1.0) from ending
        what = f"room {self.id!r} is being closed or begun anew"
        with self.taking_nothing(ResetError(what, field="room", retry_after=1.0)):
            room, settled = self.room, None
            if room.format.has_results:
                await self._persistence.ledger.commit()  # what was taken before is decided then
                saved, planned = room.checkpoint(), list(room.planned)
                settled = await asyncio.to_thread(settle, room, saved, planned)
            if self.gone is not None:
                raise ClosedRoomError(f"room {self.id!r} was closed meanwhile")
            yield settled

    def tell_settled(self, settled: Settled | None) -> None:
        """Tell everyone how the balls end that were in flight when the room did."""
        if settled is None:
            return
        room = self.room
        for entered in settled.entered:
            if entered.pending in room.planned:
                self._tell(entered, room.seq + 1)
                room.seq += len(entered.events)
        flying = {ball.ball for ball in room.balls} | {each.number for each in room.planned}
        landed = [event for event in settled.landed if event.ball in flying]
        room.planned.clear()
        room.seq += len(landed)
        self._pass_on(list(landed), kept=True)

    def begin_anew(self, room: Room, why: AppError) -> None:
        """Another room takes the place of this one; who waits for something hears why it fails."""
        self._leave_behind(why)
        self.room = room
        self.audience.begin(room, self._around.new_id())
        self.queue = self._new_queue()
        self._begin()

    def give_up(self, why: str) -> None:
        """The room failed: tell everyone that what was in flight gets its stake back."""
        self.audience.broadcast(list(self.room.give_up(why)), with_snapshot=False)

    def leave(self, error: AppError) -> None:
        """The room is here no more: `error` goes to all who wait for it or still ask it."""
        self.gone = error
        self._leave_behind(error)
        self.audience.release()

    def _leave_behind(self, error: AppError) -> None:
        """Tick no more, and tell all who wait for something here that it will not come."""
        self.queue.end()
        self._leave_runner()
        self.landings.end(error)
        for pending, asked in list(self._asked.items()):
            del self._asked[pending]
            asked.left = error
            if pending.durable and not asked.entered.done():
                asked.entered.set_exception(error)
