"""What an arena tells: impacts, landings and balls that left, from the log of its kernels."""

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from engine.multibody.solver.layout import (
    COUNTS,
    LOG_A,
    LOG_B,
    LOG_SPEED,
    LOG_T,
    LOG_X,
    LOG_Y,
    Floats,
    Ints,
    Log,
)

ROOM_PER_BALL: Final = 4
"""Impacts of a frame that are told, for each ball; a heap that collapses has some more."""

KEPT_FRAMES: Final = 600
"""Frames whose events are kept for one who does not ask for them."""


@dataclass(frozen=True, slots=True)
class Touch:
    """An impact of ball `a` at (x, y), in m, with ball `b`, or with a peg or a wall (b is -1).

    t in s of the arena, tick the frame's, index the peg's or wall's number (-1 for a ball), speed
    that of the approach along the normal in m/s.
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
    """A ball's centre crossed the bins' line at x, in m, and time t, in s of the arena."""

    tick: int
    t: float
    ball: int
    bin: int
    x: float


@dataclass(frozen=True, slots=True)
class Left:
    """A ball went too far to be followed."""

    tick: int
    t: float
    ball: int


class Told(NamedTuple):
    """Impacts of a frame; rows as in `Log`."""

    floats: Floats
    ints: Ints


ArenaEvent = Touch | Landed | Left


def new_log(balls: int) -> Log:
    """A log for frames of so many balls."""
    rows = ROOM_PER_BALL * balls + 16
    return Log(
        floats=np.empty((rows, 4)),
        ints=np.empty((rows, 2), np.int32),
        landings=np.empty((balls + 1, 2)),
        landed=np.empty(balls + 1, np.int32),
        counts=np.zeros(COUNTS, np.int64),
    )


def touches_of(told: Told, tick: int, start: float, peg_count: int) -> list[Touch]:
    """The impacts of the frame `tick`, which began at `start` s, in order of time."""
    found = []
    for row, (a, b) in zip(told.floats.tolist(), told.ints.tolist(), strict=True):
        kind: Literal["ball", "peg", "wall"] = "ball"
        index = -1
        if b < 0:
            item = -1 - b
            kind = "peg" if item < peg_count else "wall"
            index = item if item < peg_count else item - peg_count
        found.append(
            Touch(
                tick=tick,
                t=start + row[LOG_T],
                a=a,
                b=max(b, -1),
                kind=kind,
                index=index,
                x=row[LOG_X],
                y=row[LOG_Y],
                speed=row[LOG_SPEED],
            )
        )
    assert (LOG_A, LOG_B) == (0, 1)
    return found


def told_of(log: Log, touches: int) -> Told:
    """The impacts in a log, apart from the arrays that the next frame writes to."""
    return Told(log.floats[:touches].copy(), log.ints[:touches].copy())
