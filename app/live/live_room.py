"""One running room: what tables and rooms of touching balls have in common.

The room itself is pure (app/rooms); a LiveRoom connects it to time, the ledger and the clients. How
a drop or another input is taken, and what a tick does, is in live_table.py and live_arena.py.
"""

import asyncio
import contextlib
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from plinko.app.concurrency.single_flight import Signal
from plinko.app.errors import AppError, ClosedRoomError, ResetError, UndecidedError
from plinko.app.live.broadcast.audience import NOBODY, Audience, AudienceContext, Player
from plinko.app.live.broadcast.hub import Client
from plinko.app.live.orders import Orders
from plinko.app.live.queue import RoomQueue
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.live.ticking.runner import Runner
from plinko.app.persistence.service import PersistenceService
from plinko.app.protocol import messages
from plinko.app.protocol.touching_messages import Change
from plinko.app.protocol.wire import WireMessage
from plinko.app.rooms.outcome import Outcome
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import ResultRow
from plinko.app.rooms.room import Room
from plinko.engine.errors import PlinkoError
from plinko.engine.exact.outcome import FALSE_PATH, REASONS

_LAST: Final = 256  # landings that a wait may have missed


@dataclass(frozen=True)
class RoomContext:
    """What all live rooms of a server share.

    new_id: makes an id for a room run, as clients see it.
    filmed: whether a room is watched by others than clients of the hub.
    draw: returns a random seed.
    """

    audiences: AudienceContext
    persistence: PersistenceService
    orders: Orders
    runner: Runner
    new_id: Callable[[], str]
    filmed: Callable[[str], bool]
    draw: Callable[[], int]


class Landings:
    """The waits of one room, by ball; for the event loop's thread."""

    def __init__(self) -> None:
        self._waiting: dict[int, list[asyncio.Future[messages.Landed | None]]] = {}
        self._any = Signal()
        self._last: dict[int, messages.Landed] = {}  # a ball may land before its wait begins

    @property
    def waiting(self) -> int:
        return len(self._waiting)

    async def wait(self, ball: int, seconds: float) -> messages.Landed | None:
        """Wait until the ball lands; returns None if that takes longer than `seconds`.

        Raises the error given to `end`.
        """
        if ball in self._last:
            return self._last[ball]
        future: asyncio.Future[messages.Landed | None] = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(ball, []).append(future)
        try:
            return await asyncio.wait_for(future, seconds)
        except TimeoutError:
            return None
        finally:
            waiting = self._waiting.get(ball, [])
            if future in waiting:
                waiting.remove(future)
            if not waiting:
                self._waiting.pop(ball, None)

    async def next(self) -> None:
        """Wait until any ball lands."""
        await self._any.wait()

    def landed(self, landed: messages.Landed) -> None:
        self._any.send()
        self._last[landed.ball] = landed
        if len(self._last) > _LAST:
            del self._last[next(iter(self._last))]
        for future in self._waiting.pop(landed.ball, ()):
            if not future.done():
                future.set_result(landed)

    def end(self, error: AppError) -> None:
        for future in self._all():
            future.set_exception(error)

    def leave(self) -> None:
        """End all waits as if they had timed out: the balls land at another server, or later."""
        for future in self._all():
            future.set_result(None)

    def _all(self) -> list["asyncio.Future[messages.Landed | None]"]:
        found = [each for futures in self._waiting.values() for each in futures if not each.done()]
        self._waiting.clear()
        self._last.clear()
        return found


class LiveRoom(ABC):
    """One running room, for the event loop's thread. A reset replaces the pure `room`."""

    room: Room

    def __init__(self, room: Room, context: RoomContext) -> None:
        self.id = room.id
        self.audience = Audience(context.audiences, room, context.new_id())
        self.landings = Landings()
        self.tick_time = 0.0  # time of the last tick, s of the server's clock
        self.gone: AppError | None = None  # why this server no longer has the room
        self._context = context
        self._persistence = context.persistence
        self._runner = context.runner
        self._refusals: list[AppError] = []  # why requests are refused for now; the last one counts
        self._begin(room)

    def _begin(self, room: Room) -> None:
        """Go on with a run of the room."""
        self.room = room
        self.queue = self._new_queue()
        room.owned = self.owned
        self._runner.wake(self)

    def _new_queue(self) -> RoomQueue:
        record = self._persistence.runs.of(self.room)
        return RoomQueue(
            self._persistence.ledger,
            record.number,
            drop=self.drop,
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

    @property
    @abstractmethod
    def busy(self) -> bool:
        """Whether inputs are on their way into the room."""

    @property
    def awake(self) -> bool:
        """Whether the room needs ticks."""
        return self.room.awake

    @abstractmethod
    async def cut_paths(self) -> None:
        """Prepare the hello of a client of the stream `paths`, a ball at a time."""

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
    ) -> Outcome:
        """Take a drop, unless the player has sent it before; returns its outcome.

        When this returns, the drop is durable, has entered, and clients have been sent it. In a
        fair `session` it gets the session's next seed, and its receipt is committed with it. Raises
        HaltedError, BallLimitError, BusyError, SessionStateError, KeyReusedError,
        InvalidValueError, LedgerError, UndecidedError and the engine's errors; RepeatedError if the
        player has sent a drop of touching balls before, whose outcome only the room's log has.
        """
        try:
            self._context.orders.check_banned(command.who)
            return await self._persistence.ledger.decided(self._drop(command, player, session))
        except UndecidedError:
            self._runner.counts.undecided += 1
            raise
        except PlinkoError:
            self._runner.counts.refused += 1
            raise

    @abstractmethod
    async def _drop(
        self, command: DropCommand, player: Player, session: FairSession | None
    ) -> Outcome:
        """As `drop`, however long the ledger takes."""

    async def change(self, change: Change, player: Player = NOBODY) -> messages.Event | None:
        """Take a change of a room of touching balls, as `drop` takes a drop.

        Returns its first event, if any. Raises InvalidValueError, MissingBallError, BallLimitError,
        HaltedError, LedgerError, UndecidedError.
        """
        self.room.check_changeable()
        raise NotImplementedError

    def _check(self) -> None:
        """Raise an AppError if the room currently takes no inputs."""
        self._context.orders.check(self.id)
        self._check_here()

    def _check_here(self) -> None:
        """Raise an AppError if the room is ending, leaving this server, or gone."""
        if self.gone is not None:
            raise self.gone
        if self._refusals:
            raise self._refusals[-1]

    def _announce(self, number: int, player: Player, event: messages.Event) -> messages.Event:
        """Send all clients event `number`; returns the player's own copy."""
        own = self.audience.announce(number, player, event)
        self._runner.counts.accepted += isinstance(event, messages.Accepted)
        return own

    # Ticks.

    @property
    def ticks(self) -> bool:
        """Whether the runner gives it turns."""
        return self._runner.runs(self)

    def wake(self) -> None:
        """A client has come: make sure that the room ticks if anything moves."""
        self._runner.wake(self)

    @abstractmethod
    def advance(self, due: int, until: float) -> None:
        """Run the ticks that are due, until the time `until` of the runner's clock."""

    def computed(self) -> None:
        """Called when another thread has finished the room's computation."""
        raise NotImplementedError

    def _sleep(self) -> None:
        self._leave_runner()
        self._persistence.runs.slept(self.room)

    def _leave_runner(self) -> None:
        self._runner.drop_out(self)

    def _publish(
        self,
        events: Sequence[messages.Event],
        *,
        with_snapshot: bool = False,
    ) -> None:
        """Send events and perhaps a snapshot, and wake callers that wait for a landing."""
        self.audience.broadcast(list(events), with_snapshot=with_snapshot)
        for event in events:
            if isinstance(event, messages.Landed):
                self._runner.counts.landed += 1
                self._runner.counts.solver_errors += event.unsettled == REASONS[FALSE_PATH]
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
    async def ending(self) -> AsyncIterator[list[ResultRow]]:
        """Refuse new requests, and yield the results of the balls in flight.

        An error in the block leaves the room running. Raises LedgerError if earlier inputs cannot
        be committed, UndecidedError if the room is already being closed or reset, and
        ClosedRoomError if it has been closed meanwhile.
        """
        try:
            self._check_here()
        except ResetError as ending:
            raise UndecidedError(str(ending), field="room", retry_after=1.0) from ending
        what = f"room {self.id!r} is being closed or reset"
        with self.taking_nothing(ResetError(what, field="room", retry_after=1.0)):
            await self.settled()
            if self.gone is not None:
                raise ClosedRoomError(f"room {self.id!r} was closed meanwhile")
            yield self.open_results()

    @abstractmethod
    async def settled(self) -> None:
        """Return when all inputs until now have entered or were refused; raises LedgerError."""

    def open_results(self) -> list[ResultRow]:
        """The results of the balls in flight; none where balls touch."""
        return []

    @abstractmethod
    def land_all(self) -> None:
        """Announce the landings of the balls in flight, as the ledger has ended their run."""

    def restart(self, room: Room, why: AppError) -> None:
        """Put `room` in place of the current one; callers that wait get `why`."""
        self._leave_behind(why)
        self._begin(room)
        self.audience.begin(room, self._context.new_id())

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
