"""The rooms that are awake: whose turn it is in a pass of the ticker, and on which thread."""

import logging
import math
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

from app.errors import BusyError
from app.live.public_tables import MAIN
from app.live.ticking.passes import Pass
from app.live.ticking.step_threads import StepThreads
from app.live.ticking.ticker import Schedule, Ticker, Watcher
from app.persistence.service import PersistenceService
from app.rooms.room import Room
from app.settings import Settings

CATCH_UP: Final = 5  # ticks run at once after a pause; the rest is given up

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

_TURN: Final = 0.002  # s after which rooms let the event loop have a turn, before the others' tick

_log = logging.getLogger("plinko")


class Running(Protocol):
    """A room that has turns."""

    id: str
    room: Room

    def admit(self) -> None:
        """Carry out what is planned for this tick and durable."""

    def advance(self, due: int, until: float) -> None:
        """Run the `due` ticks as far as there is time."""

    def miss(self, ticks: int) -> None:
        """Ticks were due, and there was no turn."""

    def computed(self) -> None:
        """What it has asked another thread for is there."""


@dataclass(slots=True)
class Counts:
    """What has happened in all rooms that there ever were; counts only go up."""

    accepted: int = 0  # drops
    landed: int = 0
    skipped: int = 0  # ticks of rooms that were given up because there was no time for them
    late: int = 0  # ticks that rooms missed after a while without one


class Runner:
    """Runs every room in which something moves, and none that sleeps.

    `failed` hears of a room whose step raised: it does not run any more.
    """

    def __init__(
        self,
        settings: Settings,
        persistence: PersistenceService,
        *,
        clock: Callable[[], float],
        watchers: Sequence[Watcher],
        failed: Callable[[Running, Exception], None],
    ) -> None:
        self.counts = Counts()
        self.clock = clock
        self.catch_up = CATCH_UP
        self.patience = math.ceil(_SILENT * settings.tick_rate)
        schedule = Schedule(1.0 / settings.tick_rate, CATCH_UP)
        self.ticker = Ticker(schedule, self.tick, clock=clock, watchers=watchers)
        self._awake: OrderedDict[str, Running] = OrderedDict()  # the longest without a turn first
        self._events_kept: int | None = None  # as of the last tick, once somebody asked
        self._persistence = persistence
        self._failed = failed
        self._budget = _SHARE / settings.tick_rate
        self._threads = StepThreads()

    @property
    def awake(self) -> list[Room]:
        return [live.room for live in self._awake.values()]

    def close(self) -> list[Room]:
        """Tick no more; the rooms that would have."""
        self._threads.close()
        return self.awake

    def check_memory(self) -> None:
        """Raise BusyError when all balls in flight have as many events as may be kept."""
        if self._events_kept is None:
            self._events_kept = sum(room.events_kept for room in self.awake)
        if self._events_kept > MOST_EVENTS:
            raise BusyError(
                f"the balls in all rooms have {self._events_kept} events, and no more are taken "
                f"in before they are fewer than {MOST_EVENTS}"
            )

    def wake(self, live: Running) -> None:
        """See to it that a room ticks in which something moves."""
        if live.room.awake:
            self.run(live)

    def run(self, live: Running) -> None:
        """Give a room a turn, even one whose clock stands still: it has something to show."""
        self._awake[live.id] = live
        self.ticker.wake()

    def runs(self, live: Running) -> bool:
        return self._awake.get(live.id) is live

    def drop_out(self, live: Running) -> None:
        self._awake.pop(live.id, None)
        self._threads.forget(live.id)

    def admit(self, live: Running) -> None:
        """Let what is durable enter between two ticks; a room that cannot go on fails."""
        try:
            live.admit()
        except Exception as error:  # noqa: BLE001 - as in `take_turn`
            self._fail(live, error)

    def compute(self, live: Running, work: Callable[[], None]) -> None:
        """Have the next tick of a room computed on another thread."""
        self._threads.submit(live.id, work, live.computed)

    def _fail(self, live: Running, error: Exception) -> None:
        where = {"room": live.id, "tick": live.room.world.tick}
        _log.exception("room failed and is closed", extra=where)
        self._failed(live, error)

    def tick(self, due: int) -> Iterator[bool]:
        """Run `due` ticks of every room that is awake; yields whether one still is.

        It yields once at the end, and before that where the event loop should have a turn, so that
        frames leave and requests are heard: those of `main` never wait for other rooms.
        """
        self._events_kept = None
        rooms = Pass(self._awake, MAIN, self.clock(), due * self._budget)
        since = 0.0  # s of rooms' turns since the event loop had one
        while (turn := rooms.next(self.clock())) is not None:
            live = self._awake.get(turn.room_id)
            if live is None:  # it was closed since the pass began
                continue
            self._awake.move_to_end(live.id)
            since += self.take_turn(live, due, turn.until)
            if rooms.coming and (live.id == MAIN or since > _TURN):
                yield True
                since = 0.0
        for room_id in rooms.coming:
            if room_id in self._awake:
                self.counts.skipped += due
                self._awake[room_id].miss(due)
        self._persistence.ticked(due, self.awake)
        yield bool(self._awake)

    def take_turn(self, live: Running, due: int = 0, until: float = math.inf) -> float:
        """Run what is due of a room; returns how many s that took."""
        began = self.clock()
        try:
            live.advance(due, until)
        except Exception as error:  # noqa: BLE001 - one room's fault must not stop the others' clock
            self._fail(live, error)
        return self.clock() - began
