"""The events of an arena, read from its kernels' log: impacts, landings and departures."""

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from plinko.engine.multibody.solver.layout import step_log
from plinko.engine.multibody.solver.layout.array_types import Floats, Ints
from plinko.engine.multibody.solver.layout.step_log import StepLog

ROOM_PER_BALL: Final = 4
"""Impacts per ball for which a step's log has room; a collapsing heap may have a few more."""

KEPT_STEPS: Final = 600
"""Most steps whose impacts wait in the queue; then the oldest are dropped."""


@dataclass(frozen=True, slots=True)
class Touch:
    """An impact of ball `a` at (x, y) in m with ball `b`, or with a peg or a wall (b is -1).

    tick: of the step. t: the arena's time in s. index: of the peg or wall, -1 for a ball.
    speed: before the impact, along the normal, in m/s.
    """

    tick: int
    t: float
    a: int
    b: int
    kind: Literal["ball", "peg", "wall"]
    index: int
    x: float
    y: float
    speed: float


@dataclass(frozen=True, slots=True)
class Landed:
    """A ball's centre crossed the bins' line at x in m and at t, the arena's time in s."""

    tick: int
    t: float
    ball: int
    bin: int
    x: float


@dataclass(frozen=True, slots=True)
class Left:
    """A ball went too far away to simulate it further."""

    tick: int
    t: float
    ball: int


class _StepTouches(NamedTuple):
    """The impacts of the step `tick`, which began at `start` in s; rows as in `StepLog`."""

    tick: int
    start: float
    floats: Floats
    ints: Ints


ArenaEvent = Touch | Landed | Left


def new_log(balls: int) -> StepLog:
    """A log for steps of this many balls."""
    rows = ROOM_PER_BALL * balls + 16
    return StepLog(
        floats=np.empty((rows, 4)),
        ints=np.empty((rows, 2), np.int32),
        landings=np.empty((balls + 1, 2)),
        landed=np.empty(balls + 1, np.int32),
        counts=np.zeros(step_log.COUNTS, np.int64),
    )


class EventQueue:
    """Events until they are taken."""

    def __init__(self) -> None:
        self.lost = 0
        """Impacts that were dropped: too many in a step, or not taken in time."""
        self._touches: list[_StepTouches] = []
        self._ends: list[Landed | Left] = []

    def add_touches(self, log: StepLog, tick: int, start: float) -> None:
        """Add copies of a step's impacts, because the next step overwrites the log."""
        count = int(log.counts[step_log.TOUCHES])
        touches = _StepTouches(tick, start, log.floats[:count].copy(), log.ints[:count].copy())
        self.lost += count - len(touches.floats)
        self._touches.append(touches)
        if len(self._touches) > KEPT_STEPS:
            self.lost += len(self._touches.pop(0).floats)

    def add_end(self, end: Landed | Left) -> None:
        self._ends.append(end)

    def take(self, peg_count: int) -> list[ArenaEvent]:
        """All events since the last call, in order of time; items below `peg_count` are pegs."""
        found: list[ArenaEvent] = []
        for touches in self._touches:
            found += _touch_events(touches, peg_count)
        self._touches = []
        found += self.take_ends()
        found.sort(key=lambda event: (event.t, not isinstance(event, Touch)))
        return found

    def take_ends(self) -> list[Landed | Left]:
        """Only the landings and departures since the last call; impacts stay in the queue."""
        ends, self._ends = self._ends, []
        return sorted(ends, key=lambda event: (event.t, event.ball))

    def copy(self) -> "EventQueue":
        other = EventQueue()
        other.lost, other._touches, other._ends = self.lost, self._touches[:], self._ends[:]
        return other

    def drop(self) -> None:
        self._touches, self._ends = [], []


def _touch_events(touches: _StepTouches, peg_count: int) -> list[Touch]:
    assert (step_log.A, step_log.B) == (0, 1)
    found = []
    for row, (a, b) in zip(touches.floats.tolist(), touches.ints.tolist(), strict=True):
        kind: Literal["ball", "peg", "wall"] = "ball"
        index = -1
        if b < 0:
            item = -1 - b
            kind = "peg" if item < peg_count else "wall"
            index = item if item < peg_count else item - peg_count
        found.append(
            Touch(
                tick=touches.tick,
                t=touches.start + row[step_log.T],
                a=a,
                b=max(b, -1),
                kind=kind,
                index=index,
                x=row[step_log.X],
                y=row[step_log.Y],
                speed=row[step_log.SPEED],
            )
        )
    return found
