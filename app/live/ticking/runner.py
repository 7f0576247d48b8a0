"""Runs the ticks of all awake rooms: gives each its turn, on the event loop or another thread."""

import logging
import math
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, Protocol

from plinko.app.errors import BusyError
from plinko.app.live.public_tables import MAIN
from plinko.app.live.ticking.step_threads import StepThreads
from plinko.app.live.ticking.ticker import Schedule, Ticked, Ticker
from plinko.app.rooms.room import Room
from plinko.app.settings import TICK_RATE, Settings

CATCH_UP: Final = 5  # due ticks run at once after a pause; the others are skipped

_SHARE: Final = 0.5
"""The share of the due ticks' time for all rooms, and for the requests served between their turns.
The rest is for other requests. A turn may begin within this time and end after it. A late pass has
more due ticks and so more time. That matters on a machine that gives the server little of a core:
there half a tick's time is used up after `main` alone."""

_PATIENCE: Final = TICK_RATE
"""Ticks, 1 s. If a room has missed as many in a row, further ones count as late. Players take a
shorter pause for a slow connection, and a healthy server makes no longer one."""

MOST_EVENTS: Final = 1_000_000
"""If all rooms together keep more path events than this, a room takes drops only while it keeps
less than its equal share: 56 MB, and half of that for paths. 16,000 balls on presets have as many.
So nobody can fill the memory with long flights and stop the tables of others."""

_EXCESS: Final = 4
"""Times MOST_EVENTS above which no room takes drops."""

_TURN: Final = 0.002  # s; when rooms' turns have taken this long, the event loop serves requests

_log = logging.getLogger("plinko")


class Running(Protocol):
    """A room as the runner needs it: `LiveRoom`."""

    id: str

    @property
    def room(self) -> Room:
        """The pure room."""

    @property
    def awake(self) -> bool:
        """Whether it needs ticks."""

    def advance(self, due: int, until: float) -> None:
        """Run the `due` ticks, as many as fit until that time."""

    def computed(self) -> None:
        """Called when another thread has finished the room's computation."""


@dataclass(slots=True)
class Counts:
    """Totals over all rooms since the server's start; they only grow."""

    accepted: int = 0  # drops
    refused: int = 0
    undecided: int = 0  # drops that the ledger had not decided in time
    landed: int = 0
    solver_errors: int = 0  # of these, drops that failed the solver's check
    skipped: int = 0  # ticks of rooms skipped for lack of time
    late: int = 0  # ticks that rooms missed after a second without one


class Runner:
    """Runs the rooms that are awake.

    `failed` is called for a room whose step raised an error; it must remove the room. `now` returns
    Unix time in s.
    """

    def __init__(
        self,
        settings: Settings,
        *,
        clock: Callable[[], float],
        now: Callable[[], float],
        ticked: Sequence[Ticked],
        failed: Callable[[Running, Exception], None],
    ) -> None:
        self.counts = Counts()
        self.clock = clock
        self.catch_up = CATCH_UP
        period = 1.0 / TICK_RATE
        schedule = Schedule(period, CATCH_UP)
        # Ticks are due when the clocks of tables tick.
        phase = lambda: now() % period  # noqa: E731
        self.ticker = Ticker(schedule, self.tick, clock=clock, ticked=ticked, phase=phase)
        self._awake: OrderedDict[str, Running] = (
            OrderedDict()
        )  # the room whose last turn is longest ago first
        self._events_kept: int | None = None  # of all rooms; None until needed after a tick
        self._missed: Counter[str] = Counter()  # due ticks in a row that did not run, by room
        self._failed = failed
        self._budget = _SHARE / TICK_RATE
        self._threads = StepThreads()

    @property
    def awake(self) -> list[Room]:
        return [live.room for live in self._awake.values()]

    def close(self) -> list[Room]:
        """Stop the step threads; returns the rooms that are awake."""
        self._threads.close()
        return self.awake

    def check_memory(self, room: Room) -> None:
        """Raise BusyError if a drop in this room would need memory that others have a right to."""
        if self._events_kept is None:
            self._events_kept = sum(each.events_kept for each in self.awake)
        kept, share = self._events_kept, MOST_EVENTS // max(1, len(self._awake))
        if kept > _EXCESS * MOST_EVENTS or (kept > MOST_EVENTS and room.events_kept > share):
            raise BusyError(
                f"the balls in all rooms have {kept} events, {room.events_kept} of them in room "
                f"{room.id!r}, which takes no drops now; try again when balls have landed"
            )

    def wake(self, live: Running) -> None:
        """Give a room turns if it is awake."""
        if live.awake:
            self.run(live)

    def run(self, live: Running) -> None:
        """Give a room a turn, even if its clock is stopped: it has a change to show."""
        self._awake[live.id] = live
        self.ticker.wake()

    def runs(self, live: Running) -> bool:
        return self._awake.get(live.id) is live

    def drop_out(self, live: Running) -> None:
        self._awake.pop(live.id, None)
        del self._missed[live.id]
        self._threads.forget(live.id)

    def guarded(self, live: Running, work: Callable[[], None]) -> None:
        """Do something in a room between two ticks; on an error the room fails."""
        try:
            work()
        except Exception as error:  # noqa: BLE001 - as in `take_turn`
            self.fail(live, error)

    def compute(self, live: Running, work: Callable[[], None]) -> None:
        """Run `work`, which computes a room's next tick, on another thread."""
        self._threads.submit(live.id, work, live.computed)

    def fail(self, live: Running, error: Exception) -> None:
        """Close a room that cannot go on."""
        where = {"room": live.id, "tick": live.room.world.tick}
        _log.exception("room failed and is closed", extra=where)
        self._failed(live, error)

    def tick(self, due: int) -> Iterator[bool]:
        """Run `due` ticks of every awake room; yields whether any room is still awake.

        It yields at the end, and before that whenever the event loop should send frames and serve
        requests: right after `main`, whose frames never wait for other rooms, and after each
        `_TURN`.
        """
        self._events_kept = None
        rooms = Pass(self._awake, MAIN, self.clock(), due * self._budget)
        since = 0.0  # s of rooms' turns since the last yield
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
                self._miss(room_id, due)
        yield bool(self._awake)

    def take_turn(self, live: Running, due: int = 0, until: float = math.inf) -> float:
        """Run the due ticks of a room; returns the time that they took, in s."""
        began, before = self.clock(), live.room.world.tick
        try:
            live.advance(due, until)
        except Exception as error:  # noqa: BLE001 - a failed room must not stop the others
            self.fail(live, error)
        if live.room.world.tick > before:
            del self._missed[live.id]
        elif self.runs(live):
            self._miss(live.id, due)
        return self.clock() - began

    def _miss(self, room_id: str, ticks: int) -> None:
        """Count due ticks that did not run; those after `_PATIENCE` count as late."""
        before = self._missed[room_id]
        self._missed[room_id] += ticks
        self.counts.late += max(0, self._missed[room_id] - max(before, _PATIENCE))


class Turn(NamedTuple):
    """A room, and the time until which it may begin further computations."""

    room_id: str
    until: float


class Pass:
    """One pass over the awake rooms, in the given order.

    The room `first` comes before all others and may take as long as it needs. Even if no time is
    left, one of the others has a turn; the rest are skipped. The caller puts the rooms that have
    waited longest first, so n rooms have all had a turn after at most n passes.
    """

    def __init__(self, rooms: Iterable[str], first: str, began: float, budget: float) -> None:
        self.coming = deque(rooms)
        """The rooms that have not had a turn yet."""
        self._end = began + budget
        self._first = first in self.coming
        self._others = 0  # other rooms that have had a turn
        if self._first:
            self.coming.remove(first)
            self.coming.appendleft(first)

    def next(self, now: float) -> Turn | None:
        """The next turn at `now`; None if all rooms have had one or the time is used up."""
        if not self.coming:
            return None
        if self._first:
            self._first = False
            return Turn(self.coming.popleft(), math.inf)
        left = self._end - now
        if left <= 0.0 and self._others > 0:
            return None
        self._others += 1
        return Turn(self.coming.popleft(), now + max(0.0, left) / (len(self.coming) + 1))
