"""One running room: its requests, its ticks, its audience and its end.

The room itself is pure (app/rooms); a LiveRoom connects it to time, the ledger and the clients. It
treats each input in this order:

1. plan: the pure room validates the input and gives it a number and a tick.
2. commit: the ledger makes it durable, or refuses it.
3. admit: at its tick, the pure room carries it out.
4. announce: every client receives the events, and the caller gets its answer.

No client sees an input that the ledger may still refuse. Inputs have consecutive numbers. If the
ledger refuses one, it therefore also refuses those planned after it, and reports the latest first,
so that the room can take back each from the end of its plan.
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
from app.live.broadcast.audience import NOBODY, Audience, AudienceContext, Player
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
from engine.exact.outcome import FALSE_PATH, REASONS

Taken = TypeVar("Taken", messages.Accepted, Outcome)
"""The result of a drop: of a first request, or of one that may be a repetition."""

_UNWATCHED_SECONDS: Final = 10.0
"""s for which a scene moves on without spectators, so that reloading the page does not stop it."""

_LOOK_AHEAD_SECONDS: Final = 0.002
"""s in a turn for computing paths ahead; the path of a typical drop takes 0.1 ms."""


@dataclass(frozen=True)
class RoomContext:
    """What all live rooms of a server share.

    new_id: makes an id for a room run, as clients see it.
    filmed: whether a room is watched by others than clients of the hub.
    draw: returns a random seed.
    """

    audiences: AudienceContext
    persistence: PersistenceService
    halts: Halts
    runner: Runner
    new_id: Callable[[], str]
    filmed: Callable[[str], bool]
    draw: Callable[[], int]


@dataclass(eq=False)
class _Waiter:
    """A caller that waits for its input to enter; `taken` if it is a drop of a fair session."""

    player: Player
    taken: TakenDrop | None
    entered: "asyncio.Future[messages.Event | None]"
    left: AppError | None = None
    """Set when the room has ended or left this server, so that the input will not enter here."""


class LiveRoom:
    """One running room, for the event loop's thread. A reset replaces the pure `room`."""

    def __init__(self, room: Room, context: RoomContext) -> None:
        self.id = room.id
        self.room = room
        self.audience = Audience(context.audiences, room, context.new_id())
        self.landings = Landings()
        self.tick_time = 0.0  # time of the last tick, s of the server's clock
        self._context = context
        self._persistence = context.persistence
        self._runner = context.runner
        self._waiters: dict[Pending, _Waiter] = {}
        # Drops in progress that a client may repeat, by key.
        self._under_way: dict[str, asyncio.Task[messages.Accepted | Outcome]] = {}
        self._refusals: list[AppError] = []  # why requests are refused for now; the last one counts
        self.gone: AppError | None = None  # why this server no longer has the room
        self._unwatched = 0  # ticks for which a scene had no spectator
        self._behind = 0  # due ticks that wait for another thread
        self._missed = 0  # due ticks in a row that did not run
        self.queue = self._new_queue()
        self._begin()

    def _begin(self) -> None:
        self.room.owned = self.owned
        self._runner.wake(self)

    def _new_queue(self) -> RoomQueue:
        """The queue of the current room run."""
        record = self._persistence.runs.of(self.room)
        return RoomQueue(
            self._persistence.ledger,
            record.number,
            drop=self.drop_once,
            flying=lambda: {ball.ball for ball in self.room.balls},
            landing=self.landings.next,
            draw=self._context.draw,
            tell=self.audience.notify,
            empty=not record.known,
        )

    @property
    def owned(self) -> bool:
        """Whether the room has an owner: then only the owner may change it."""
        return self._persistence.runs.of(self.room).owned

    @property
    def watched(self) -> bool:
        return self._context.audiences.hub.count(self.id) > 0 or self._context.filmed(self.id)

    def tell_waiting(self, client: Client) -> None:
        """Send a newly greeted client the state of the queue, unless the queue is empty."""
        if self.queue.items:
            client.post(WireMessage.of_text(messages.encode_event(self.queue.event)))

    # Requests.

    async def drop(
        self,
        command: DropCommand,
        player: Player = NOBODY,
        session: FairSession | None = None,
    ) -> messages.Accepted:
        """Take a drop; returns when it is durable, has entered, and clients have been sent it.

        In a fair `session` the drop gets the session's next seed, and its receipt is committed
        with it. Raises HaltedError, BallLimitError, BusyError, SessionStateError,
        InvalidValueError, LedgerError, UndecidedError and the engine's errors.
        """
        work = self._begin_drop(player.again, self._drop(command, player, session))
        return await self._persistence.ledger.decided(work)

    async def drop_once(
        self,
        command: DropCommand,
        player: Player,
        session: FairSession | None = None,
    ) -> Outcome:
        """Take a drop unless one with the key `player.again` was taken; returns its outcome.

        Raises what `drop` raises, and RepeatedError if that drop is one of touching balls, whose
        outcome only the room's log has.
        """
        decided, before = self._persistence.ledger.decided, self._under_way.get(player.again or "")
        if before is None:
            drop = self._drop_unless_kept(command, player, session)
            return await decided(self._begin_drop(player.again, drop))
        try:
            found = await decided(before)
        except UndecidedError as undecided:
            undecided.outcome = None  # for the first caller only; a repetition may be repeated
            raise
        outcome = found if isinstance(found, Outcome) else Outcome(found)
        return replace(outcome, earlier=True)

    def _begin_drop(
        self, again: str | None, drop: Coroutine[None, None, Taken]
    ) -> "asyncio.Task[Taken]":
        """Start a drop in its own task, which finishes even if the caller disconnects."""
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
                "a drop with this key was accepted before: look for it in the room's log",
                field="key",
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
        """Take a change of a room of touching balls, as `drop` takes a drop.

        Returns its first event, if any. Raises InvalidValueError, MissingBallError, BallLimitError,
        HaltedError, LedgerError, UndecidedError.
        """
        return await self._persistence.ledger.decided(self._change(change, player))

    async def _change(self, change: Change, player: Player) -> messages.Event | None:
        self._check()
        pending = self.room.plan_change(change, self._persistence.lead)
        return await self._carry_out(pending, player, None)

    def _check(self) -> None:
        """Raise an AppError if the room currently takes no inputs."""
        self._context.halts.check(self.id)
        self._check_here()

    def _check_here(self) -> None:
        """Raise an AppError if the room is ending, leaving this server, or gone."""
        if self.gone is not None:
            raise self.gone
        if self._refusals:
            raise self._refusals[-1]

    async def _carry_out(
        self, pending: Pending, player: Player, taken: TakenDrop | None
    ) -> messages.Event | None:
        """Commit a planned input and wait until it has entered; returns its first event.

        While this waits for the ledger, the room may end or leave (`_leave_behind`), or be reset,
        which replaces `self.room`. The waiter's `left` is then set: nothing is taken back from the
        old run, and only the fair session still has to know whether the ledger took the drop.
        """
        room, persistence = self.room, self._persistence
        number = persistence.runs.of(room).number
        waiter = _Waiter(player, taken, asyncio.get_running_loop().create_future())
        self._waiters[pending] = waiter
        try:
            kept = persistence.submit(room, pending, None if taken is None else taken.leaf)
        except LedgerError:
            self._take_back(room, pending)
            raise
        try:
            await kept
        except LedgerError:
            if waiter.left is None:
                self._take_back(room, pending)
            elif taken is not None:
                taken.settled(refused=True)
            # The last refused input has been taken back: the ledger may accept new ones.
            if not room.planned or room.planned[-1].durable:
                persistence.taken_back(room, number)
            raise
        if taken is not None:
            pending.receipt = taken.settled(refused=False)
        if waiter.left is not None:
            raise waiter.left
        pending.durable = True
        self._runner.admit(self)
        return await waiter.entered

    def _take_back(self, room: Room, pending: Pending) -> None:
        """Remove the last planned input; the next one gets its number."""
        waiter = self._waiters.pop(pending)
        if waiter.taken is not None:
            waiter.taken.settled(refused=True)
        room.refuse(pending)

    # Ticks.

    @property
    def ticks(self) -> bool:
        """Whether the runner gives it turns."""
        return self._runner.runs(self)

    def admit(self) -> None:
        """Carry out the durable inputs whose tick has come, and announce their events."""
        number = self.room.seq + 1
        for entered in self.room.enter():
            self._tell(entered, number)
            number += len(entered.events)
            self._runner.run(self)
        self._begin_step()

    def _tell(self, entered: Entered, number: int) -> None:
        """Announce an input's events, the first of which has `number`, and answer the caller."""
        waiter = self._waiters.pop(entered.pending, None)
        player = NOBODY if waiter is None else waiter.player
        first = None
        for seq, event in enumerate(entered.events, number):
            own = self.audience.announce(seq, player, event)
            self._runner.counts.accepted += isinstance(event, messages.Accepted)
            first = first or own
        if entered.restarts:
            self.audience.begin(self.room, self._context.new_id())
        if waiter is None or waiter.entered.done():
            return
        if entered.failed is None:
            waiter.entered.set_result(first)
        else:
            waiter.entered.set_exception(entered.failed)

    def wake(self) -> None:
        """A client has come: make sure that the room ticks if anything moves."""
        self._unwatched = 0
        self._runner.wake(self)

    def advance(self, due: int, until: float) -> None:
        """Run the `due` ticks, as many as fit until the time `until` of the runner's clock.

        The others are skipped, except those that wait for another thread: they run when it is done.
        """
        room, runner = self.room, self._runner
        # Only the snapshot stream has contacts and flags bounces.
        watched = self._context.audiences.hub.count(self.id, messages.SNAPSHOTS) > 0
        events: list[messages.Event] = []
        before = room.world.tick
        look_until = min(until, runner.clock() + _LOOK_AHEAD_SECONDS)
        wanted = min(due + self._behind, runner.catch_up)
        runner.counts.skipped += due + self._behind - wanted
        self._behind = 0
        for number in range(wanted):
            if number and runner.clock() > until:
                runner.counts.skipped += wanted - number
                break
            if room.held:
                self._publish(events)
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
        self._publish(events, with_snapshot=stepped or room.touched)
        self.audience.diagnose(before)
        if not room.awake or self._is_abandoned(due):
            self._sleep()
            return
        if room.held:
            self.admit()
        self._begin_step()

    def miss(self, ticks: int) -> None:
        """Count due ticks that did not run; those after the runner's patience count as late."""
        before, patience = self._missed, self._runner.patience
        self._missed += ticks
        self._runner.counts.late += max(0, self._missed - max(before, patience))

    def _sleep(self) -> None:
        self._leave_runner()
        self._persistence.slept(self.room)

    def _leave_runner(self) -> None:
        self._runner.drop_out(self)
        self._unwatched = self._behind = self._missed = 0

    def _is_abandoned(self, due: int) -> bool:
        """Whether a scene has moved without spectators for a while.

        Its clock then stops until a client comes. No player waits for a result of a scene, and
        without friction its balls would move for ever.
        """
        if not self.room.is_scene or self.room.planned or self.watched:
            self._unwatched = 0
            return False
        self._unwatched += due
        return self._unwatched > _UNWATCHED_SECONDS * self.room.tick_rate

    def _prepared(self, until: float) -> bool:
        """Compute ahead until that time, at least once; returns whether the room can step."""
        while self.room.look_ahead() and self._runner.clock() < until:
            pass
        return self.room.ready

    def _begin_step(self) -> None:
        """Start computing the next tick on another thread, if it is a long one."""
        compute = self.room.begin_step()
        if compute is not None:
            self._runner.compute(self, compute)

    def computed(self) -> None:
        """Called when another thread has computed the next tick: run it if it is due."""
        if self._behind and self.ticks:
            self._runner.take_turn(self)

    def _publish(
        self,
        events: list[messages.Event],
        *,
        with_snapshot: bool = False,
        kept: bool = False,
    ) -> None:
        """Send events and perhaps a snapshot, and record the landings.

        With `kept` the ledger has the landings already.
        """
        self.audience.broadcast(events, with_snapshot=with_snapshot)
        for event in events:
            if isinstance(event, messages.Landed):
                self._runner.counts.landed += 1
                self._runner.counts.solver_errors += event.unsettled == REASONS[FALSE_PATH]
                if not kept:
                    self._persistence.landed(self.room, event)
                self.landings.landed(event)

    # Its end.

    @contextlib.contextmanager
    def taking_nothing(self, why: AppError) -> Iterator[None]:
        """Refuse all requests meanwhile, with this error."""
        self._refusals.append(why)
        try:
            yield
        finally:
            self._refusals.remove(why)

    @contextlib.asynccontextmanager
    async def ending(self) -> AsyncIterator[Settled | None]:
        """Refuse new requests, and compute where the balls in flight will land.

        Yields None if the balls touch: such drops have no result of their own. An error leaves the
        room running: LedgerError if earlier inputs cannot be committed, BusyError if a ball falls
        too long to compute, UndecidedError if the room is already being closed or reset. Raises
        ClosedRoomError if the room has been closed meanwhile.
        """
        try:
            self._check_here()
        except ResetError as ending:
            raise UndecidedError(str(ending), field="room", retry_after=1.0) from ending
        what = f"room {self.id!r} is being closed or reset"
        with self.taking_nothing(ResetError(what, field="room", retry_after=1.0)):
            room, settled = self.room, None
            if room.format.has_results:
                await self._persistence.ledger.commit()  # decides all earlier inputs
                saved, planned = room.checkpoint(), list(room.planned)
                settled = await asyncio.to_thread(settle, room, saved, planned)
            if self.gone is not None:
                raise ClosedRoomError(f"room {self.id!r} was closed meanwhile")
            yield settled

    def tell_settled(self, settled: Settled | None) -> None:
        """Announce the landings of the balls that were in flight when the room ended.

        While `settle` ran on a copy, the room went on: some of these inputs have entered and some
        of these balls have landed. Only the others are announced.
        """
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
        self._publish(list(landed), kept=True)

    def restart(self, room: Room, why: AppError) -> None:
        """Put `room` in place of the current one; callers that wait get `why`."""
        self._leave_behind(why)
        self.room = room
        self.audience.begin(room, self._context.new_id())
        self.queue = self._new_queue()
        self._begin()

    def give_up(self, why: str) -> None:
        """Announce that the room has failed and pays back the stakes of the balls in flight."""
        self.audience.broadcast(list(self.room.give_up(why)), with_snapshot=False)

    def leave(self, error: AppError) -> None:
        """The room is no longer at this server: callers that wait, and later ones, get `error`."""
        self.gone = error
        self._leave_behind(error)
        self.audience.release()

    def _leave_behind(self, error: AppError) -> None:
        """Stop ticking, and answer all callers that wait with `error`."""
        self.queue.end()
        self._leave_runner()
        self.landings.end(error)
        for pending, waiter in list(self._waiters.items()):
            del self._waiters[pending]
            waiter.left = error
            if pending.durable and not waiter.entered.done():
                waiter.entered.set_exception(error)
