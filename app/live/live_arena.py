"""A running room of touching balls, which stays a simulation: its motion depends on every input.

1. plan: the pure room validates the input and gives it a tick.
2. commit: the ledger makes it durable and gives it a number, or refuses it.
3. admit: at its tick, the pure room carries it out.
4. announce: every client receives the events, and the caller gets its answer.

No client sees an input that the ledger may still refuse. Nothing is staked here, so what clients
have seen need not survive a crash: the room goes on from its last checkpoint and its inputs.
"""

import asyncio
from dataclasses import dataclass
from typing import Final

from plinko.app.errors import AppError
from plinko.app.live.broadcast.audience import NOBODY, Player
from plinko.app.live.live_room import LiveRoom, RoomContext
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.protocol import messages
from plinko.app.protocol.touching_messages import Change
from plinko.app.rooms.outcome import Outcome
from plinko.app.rooms.pending import DropCommand, Entered, Pending
from plinko.app.rooms.touching.room import TouchingRoom

_UNWATCHED_SECONDS: Final = 10.0
"""s for which a scene moves on without spectators, so that reloading the page does not stop it."""


@dataclass(eq=False)
class _Caller:
    """A caller that waits for its input to enter."""

    player: Player
    entered: "asyncio.Future[messages.Event | None]"
    left: AppError | None = None
    """Set when the room has ended or left this server, so that the input will not enter here."""


class LiveArena(LiveRoom):
    """One running room of touching balls, for the event loop's thread."""

    room: TouchingRoom

    def __init__(self, room: TouchingRoom, context: RoomContext) -> None:
        self._callers: dict[Pending, _Caller] = {}
        self._unwatched = 0  # ticks for which a scene had no spectator
        self._behind = 0  # due ticks that wait for another thread
        super().__init__(room, context)

    @property
    def busy(self) -> bool:
        return bool(self.room.planned)

    # Inputs.

    async def _drop(
        self, command: DropCommand, player: Player, session: FairSession | None
    ) -> Outcome:
        self._check()
        self._runner.check_memory(self.room)
        self.room.check_drop(command, fair=session is not None)
        if session is not None:
            session.check(self.room, practice=command.practice)
        pending = self.room.plan_drop(command, self._persistence.lead)
        accepted = await self._carry_out(pending, player)
        assert isinstance(accepted, messages.Accepted)
        return Outcome(accepted)

    async def change(self, change: Change, player: Player = NOBODY) -> messages.Event | None:
        return await self._persistence.ledger.decided(self._change(change, player))

    async def _change(self, change: Change, player: Player) -> messages.Event | None:
        self._check()
        pending = self.room.plan_change(change, self._persistence.lead)
        return await self._carry_out(pending, player)

    async def _carry_out(self, pending: Pending, player: Player) -> messages.Event | None:
        """Commit a planned input and wait until it has entered; returns its first event.

        While this waits for the ledger, the room may end or leave, or be reset, which replaces
        `self.room`. The caller's `left` is then set.
        """
        room = self.room
        caller = _Caller(player, asyncio.get_running_loop().create_future())
        self._callers[pending] = caller
        try:
            await self._persistence.submit(room, pending, player.idempotency_key)
        except AppError:
            self._callers.pop(pending, None)
            room.refuse(pending)
            if caller.left is None and not room.awake:
                # The input's mark may have said that it is awake.
                self._persistence.runs.slept(room)
            raise
        if caller.left is not None:
            raise caller.left
        pending.durable = True
        self._runner.guarded(self, self.admit)
        return await caller.entered

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
        caller = self._callers.pop(entered.pending, None)
        player = NOBODY if caller is None else caller.player
        first = None
        for seq, event in enumerate(entered.events, number):
            own = self._announce(seq, player, event)
            first = first or own
        if entered.restarts:
            self.audience.begin(self.room, self._context.new_id())
        if caller is None or caller.entered.done():
            return
        if entered.failed is None:
            caller.entered.set_result(first)
        else:
            caller.entered.set_exception(entered.failed)

    # Ticks.

    async def cut_paths(self) -> None:
        """Do nothing: no path is known in advance here."""

    def wake(self) -> None:
        self._unwatched = 0
        super().wake()

    def advance(self, due: int, until: float) -> None:
        """Run the `due` ticks, as many as fit until the time `until` of the runner's clock.

        The others are skipped, except those that wait for another thread: they run when it is done.
        """
        room, runner = self.room, self._runner
        watched = self._context.audiences.hub.count(self.id, messages.SNAPSHOTS) > 0
        events: list[messages.Event] = []
        before = room.world.tick
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
            if room.held or not room.awake:
                break
            if not room.ready:
                self._behind = wanted - number
                break
            events += room.step(watched=watched)
        stepped = room.world.tick > before
        if stepped:
            self.tick_time = runner.clock()
        self._publish(events, with_snapshot=stepped or room.touched)
        self.audience.diagnose(before)
        if not room.awake or self._is_abandoned(due):
            self._sleep()
            return
        self._persistence.ticked(room)
        if room.held:
            self.admit()
        self._begin_step()

    def _leave_runner(self) -> None:
        super()._leave_runner()
        self._unwatched = self._behind = 0

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

    def _begin_step(self) -> None:
        """Start computing the next tick on another thread, if it is a long one."""
        compute = self.room.begin_step()
        if compute is not None:
            self._runner.compute(self, compute)

    def computed(self) -> None:
        if self._behind and self.ticks:
            self._runner.take_turn(self)

    # Its end.

    async def settled(self) -> None:
        """Return at once: inputs that have not entered when the run ends are in its log."""

    def land_all(self) -> None:
        """Do nothing: these balls have no results of their own."""

    def _leave_behind(self, error: AppError) -> None:
        super()._leave_behind(error)
        for pending, caller in list(self._callers.items()):
            del self._callers[pending]
            caller.left = error
            if pending.durable and not caller.entered.done():
                caller.entered.set_exception(error)
