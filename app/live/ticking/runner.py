"""The rooms that are awake: ticks them, carries out what is due, and passes on what comes of it."""

import functools
import logging
import math
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from app.errors import BusyError
from app.live.broadcast.broadcaster import Broadcaster
from app.live.broadcast.hub import Hub
from app.live.public_tables import MAIN
from app.live.ticking.landings import Landings
from app.live.ticking.passes import Lateness, Pass
from app.live.ticking.step_threads import StepThreads
from app.live.ticking.ticker import Schedule, Ticker, Watcher
from app.persistence.service import PersistenceService
from app.protocol import messages
from app.rooms.pending import Entered
from app.rooms.room import Room
from app.settings import Settings

_ALONE: Final = 10.0  # s; who reloads the page finds the scene going on

_SHARE: Final = 0.5
"""Of the time that the due ticks stand for, for all rooms together and the requests that are heard
between them; other requests have the rest. A turn that has begun by then may end later. A late pass
has more ticks due and so more time: where the machine gives the server little of a core, a pass
takes long, and half a tick's time of it would be over after `main`."""

_SILENT: Final = 1.0
"""s without a tick after which those that a room still misses count as late. A player takes a
shorter pause for a slow connection; nothing that is in order takes longer."""

MOST_EVENTS: Final = 1_000_000
"""Events that all rooms together keep of their balls in flight and still take drops: 56 MB, and as
much again or twice of segments. 16,000 balls on presets have as many."""

_LOOK: Final = 0.002  # s that a room may follow paths in a turn; those of most drops take 0.1 ms

_TURN: Final = 0.002  # s after which rooms let the event loop have a turn, before the others' tick

_log = logging.getLogger("plinko")


class Runner:
    """Runs every room in which something moves, and none that sleeps.

    `failed` hears of a room whose step raised: it does not run any more; `renewed` of one that an
    input made begin anew. `watched` says whether somebody sees a room of this id.
    """

    def __init__(
        self,
        settings: Settings,
        hub: Hub,
        broadcaster: Broadcaster,
        persistence: PersistenceService,
        landings: Landings,
        *,
        clock: Callable[[], float],
        watchers: Sequence[Watcher],
        failed: Callable[[Room, Exception], None],
        renewed: Callable[[Room], None],
        watched: Callable[[str], bool],
    ) -> None:
        self.accepted = 0  # drops, in all rooms there ever were
        self.landed = 0
        self.skipped = 0  # ticks of rooms that were given up because there was no time for them
        schedule = Schedule(1.0 / settings.tick_rate, settings.max_catch_up)
        self.ticker = Ticker(schedule, self.tick, clock=clock, watchers=watchers)
        self._awake: OrderedDict[str, Room] = OrderedDict()  # the longest without a turn first
        self._events_kept: int | None = None  # as of the last tick, once somebody asked
        self._hub = hub
        self._broadcaster = broadcaster
        self._persistence = persistence
        self._landings = landings
        self._clock = clock
        self._failed = failed
        self._renewed = renewed
        self._watched = watched
        self._patience = math.ceil(_ALONE * settings.tick_rate)
        self._alone: dict[str, int] = {}  # ticks for which nobody watched a scene
        self._budget = _SHARE / settings.tick_rate
        self.lateness = Lateness(math.ceil(_SILENT * settings.tick_rate))
        self._threads = StepThreads()
        self._catch_up = settings.max_catch_up
        self._behind: dict[str, int] = {}  # ticks by which rooms wait for another thread

    @property
    def awake(self) -> list[Room]:
        """The rooms in which something moves."""
        return list(self._awake.values())

    def close(self) -> list[Room]:
        """Tick no more; the rooms that would have."""
        self._threads.close()
        return self.awake

    def check_memory(self) -> None:
        """Raise BusyError when all balls in flight have as many events as may be kept."""
        if self._events_kept is None:
            self._events_kept = sum(room.events_kept for room in self._awake.values())
        if self._events_kept > MOST_EVENTS:
            raise BusyError(
                f"the balls in all rooms have {self._events_kept} events, and no more are taken "
                f"in before they are fewer than {MOST_EVENTS}"
            )

    def wake(self, room: Room) -> None:
        """See to it that a room ticks in which something moves."""
        self._alone.pop(room.id, None)
        if room.awake:
            self._awake[room.id] = room
            self.ticker.wake()

    def runs(self, room: Room) -> bool:
        """Whether the room ticks."""
        return self._awake.get(room.id) is room

    def drop_out(self, room: Room) -> None:
        """Run a room no more."""
        self._awake.pop(room.id, None)
        self._behind.pop(room.id, None)
        self.lateness.ran(room.id)
        self._threads.forget(room.id)

    def admit(self, room: Room) -> None:
        """Carry out what is planned for this tick and durable, and tell everyone."""
        number = room.seq + 1
        for entered in room.enter():
            self.tell(room, entered, number)
            number += len(entered.events)
            self._awake[room.id] = room
            self.ticker.wake()
        self._begin_step(room)

    def tell(self, room: Room, entered: Entered, number: int) -> None:
        """Tell everyone what came of an input: events from this `number` of the room's on."""
        requester = entered.pending.requester
        first = None
        for seq, event in enumerate(entered.events, number):
            own = self._broadcaster.announce(room, seq, requester, event)
            self.accepted += isinstance(event, messages.Accepted)
            first = first or own
        if entered.begins_anew:
            self._renewed(room)
        if entered.failed is None:
            requester.carried_out(first)
        else:
            requester.refused(entered.failed)

    def admit_now(self, room: Room) -> None:
        """`admit` between two ticks; a room that cannot go on fails as it would in its tick."""
        try:
            self.admit(room)
        except Exception as error:  # noqa: BLE001 - as in `tick`
            self._fail(room, error)

    def _fail(self, room: Room, error: Exception) -> None:
        where = {"room": room.id, "tick": room.world.tick}
        _log.exception("room failed and is closed", extra=where)
        self._failed(room, error)

    def tick(self, due: int) -> Iterator[bool]:
        """Run `due` ticks of every room that is awake; yields whether one still is.

        It yields once at the end, and before that where the event loop should have a turn, so that
        frames leave and requests are heard: those of `main` never wait for other rooms.
        """
        self._events_kept = None
        rooms = Pass(self._awake, MAIN, self._clock(), due * self._budget)
        since = 0.0  # s of rooms' turns since the event loop had one
        while (turn := rooms.next(self._clock())) is not None:
            room = self._awake.get(turn.room_id)
            if room is None:  # it was closed since the pass began
                continue
            self._awake.move_to_end(room.id)
            since += self._take_turn(room, due, turn.until)
            if rooms.coming and (room.id == MAIN or since > _TURN):
                yield True
                since = 0.0
        for room_id in rooms.coming:
            if room_id in self._awake:
                self.skipped += due
                self.lateness.missed(room_id, due)
        self._persistence.ticked(due, self._awake.values())
        yield bool(self._awake)

    def _take_turn(self, room: Room, due: int, until: float) -> float:
        """Run what is due of a room; returns how many s that took."""
        began = self._clock()
        try:
            self._advance(room, due, until)
        except Exception as error:  # noqa: BLE001 - one room's fault must not stop the others' clock
            self._fail(room, error)
        return self._clock() - began

    def _begin_step(self, room: Room) -> None:
        """Have the next tick of a room computed, if that is for another thread."""
        compute = room.begin_step()
        if compute is not None:
            self._threads.submit(room.id, compute, functools.partial(self._computed, room))

    def _computed(self, room: Room) -> None:
        """The next tick of a room is there: run it, if it has been due."""
        if room.id in self._behind and self.runs(room):
            self._take_turn(room, 0, math.inf)

    def _advance(self, room: Room, due: int, until: float) -> None:
        # Only this stream tells of contacts, and flags bounces.
        watched = self._hub.count(room.id, messages.SNAPSHOTS) > 0
        events: list[messages.Event] = []
        before = room.world.tick
        look_until = min(until, self._clock() + _LOOK)
        behind = self._behind.pop(room.id, 0)
        wanted = min(due + behind, self._catch_up)
        self.skipped += due + behind - wanted
        for number in range(wanted):
            if number and self._clock() > until:
                self.skipped += wanted - number
                break
            if room.held:
                self.pass_on(room, events)
                events = []
                self.admit(room)
            if room.held or not room.awake or not self._persistence.may_step(room):
                break
            if not self._prepared(room, look_until):
                if room.steps_aside:
                    self._behind[room.id] = wanted - number
                else:
                    self.skipped += wanted - number
                break
            events += room.step(watched=watched)
        stepped = room.world.tick > before
        if stepped:
            room.tick_time = self._clock()
            self.lateness.ran(room.id)
        else:
            self.lateness.missed(room.id, due)
        self.pass_on(room, events, with_snapshot=stepped or room.touched)
        self._broadcaster.diagnose(room, before)
        if not room.awake or self._is_left(room, due):
            self.drop_out(room)
            self._alone.pop(room.id, None)
            self._persistence.slept(room)
            return
        if room.held:
            self.admit(room)
        self._begin_step(room)

    def _is_left(self, room: Room, due: int) -> bool:
        """Whether all that moves in a room moves for nobody, and has for a while.

        Its clock then stands still until somebody comes: in a scene nothing is waited for, and
        without friction it would move for ever.
        """
        if not room.is_scene or room.planned or self._watched(room.id):
            self._alone.pop(room.id, None)
            return False
        self._alone[room.id] = self._alone.get(room.id, 0) + due
        return self._alone[room.id] > self._patience

    def _prepared(self, room: Room, until: float) -> bool:
        """Compute ahead what a room needs, a piece at least; returns whether it can step."""
        while room.look_ahead() and self._clock() < until:
            pass
        return room.ready

    def pass_on(
        self,
        room: Room,
        events: list[messages.Event],
        *,
        with_snapshot: bool = False,
        kept: bool = False,
    ) -> None:
        """Send events, and the snapshot of this moment; and settle who has landed.

        `kept`: the ledger has it already.
        """
        self._broadcaster.broadcast(room, events, with_snapshot=with_snapshot)
        for event in events:
            if isinstance(event, messages.Landed):
                self.landed += 1
                if not kept:
                    self._persistence.landed(room, event)
                self._landings.landed(room, event)
