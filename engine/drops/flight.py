"""A ball's whole flight: its path, its digest and when it ends. A live ball is nothing more.

Balls of the exact solver do not touch each other, so the start x alone decides the flight.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from plinko.engine.board.model import Board
from plinko.engine.drops.sliced import Slice, SlicedPath
from plinko.engine.drops.trajectory import Trajectory, at_start, digest_of, follow
from plinko.engine.exact.outcome import LANDED, REASONS
from plinko.engine.parameters import Exact
from plinko.engine.physics import body


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """The path of a drop with the exact solver, and the digest of the drop."""

    board: Board
    path: Trajectory
    digest: str

    @classmethod
    def of(cls, board: Board, path: Trajectory) -> "Flight":
        return cls(board, path, digest_of(board.digest, path))

    @property
    def x(self) -> float:
        """Of the start, m."""
        return float(self.path.start[body.X])

    @property
    def duration(self) -> float:
        """Time from the start to the end, s."""
        return float(self.path.end[body.T])

    @property
    def x_end(self) -> float:
        """Of the centre at the end, m."""
        return float(self.path.end[body.X])

    @property
    def bin(self) -> int | None:
        """The bin, counted from 0 on the left; None if the ball did not land."""
        return self.path.bin if self.path.outcome == LANDED else None

    @property
    def score(self) -> float:
        """The bin's multiplier; 1, the stake back, if the ball did not land."""
        return self.board.bins.score_of(self.bin)

    @property
    def unsettled(self) -> str | None:
        """Why the ball did not land; None if it did."""
        return None if self.path.outcome == LANDED else REASONS[self.path.outcome]

    def ticks(self, dt: float) -> int:
        """Ticks of `dt` s from the start to the first one at which the flight is over."""
        return ticks_of(self.duration, dt)


def ticks_of(duration: float, dt: float) -> int:
    """The first tick of `dt` s, counted from 1, at or after `duration` s.

    The duration is compared with the rounded product of tick and `dt`, as when a state is sampled.
    """
    ticks = max(1, ceil(duration / dt))
    while ticks * dt < duration:
        ticks += 1
    while ticks > 1 and (ticks - 1) * dt >= duration:
        ticks -= 1
    return ticks


def fly(board: Board, x: float) -> Flight:
    """The flight of a ball that starts at rest at (x, drop.y), x in m."""
    return Flight.of(board, follow(board, at_start(board, x), Exact()))


class SlicedFlight:
    """A flight computed in slices, by a thread that others wait for; the same bits as `fly`."""

    def __init__(self, board: Board, x: float) -> None:
        self._path = SlicedPath(board, x)
        self._parts: list[Slice] = []

    def advance(self, events: int) -> bool:
        """Compute about `events` more events; returns whether the flight is complete.

        Raises EffortError if a single event takes too long.
        """
        self._parts.append(self._path.follow(events))
        return self._path.ended

    def flight(self) -> Flight:
        """The complete flight."""
        path, parts = self._path, self._parts
        return Flight.of(
            path.board,
            Trajectory(
                path.board,
                Exact(),
                path.start,
                path.state,
                path.outcome,
                path.bin,
                np.concatenate([part.impacts for part in parts]),
                np.concatenate([part.segments for part in parts]),
            ),
        )
