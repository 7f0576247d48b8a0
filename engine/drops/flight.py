"""A ball's whole flight: its path, its digest and when it ends. A live ball is nothing more.

Balls of the exact solver do not touch each other, so the start x alone decides the flight.
"""

from dataclasses import dataclass
from functools import cached_property
from math import ceil

from plinko.engine.board.model import Board
from plinko.engine.drops.trajectory import Trajectory, at_start, digest_of, follow
from plinko.engine.exact.outcome import LANDED, REASONS
from plinko.engine.parameters import Exact
from plinko.engine.physics import body


@dataclass(frozen=True, eq=False, repr=False)
class Flight:
    """The path of a ball on a board, and how it ended."""

    board: Board
    trajectory: Trajectory

    @property
    def x_start(self) -> float:
        """x of the centre at the start, m."""
        return float(self.trajectory.start[body.X])

    @property
    def bin(self) -> int | None:
        """Number of the bin from the left, or None if the ball did not land."""
        return None if self.unsettled else self.trajectory.bin

    @property
    def unsettled(self) -> str | None:
        """Why the ball did not land, or None if it did."""
        outcome = self.trajectory.outcome
        return None if outcome == LANDED else REASONS[outcome]

    @property
    def score(self) -> float:
        """The bin's multiplier; 1, the stake back, if the ball did not land."""
        return self.board.bins.score_of(self.bin)

    @property
    def duration(self) -> float:
        """Time from the start to the landing (or to the end of the simulation), s."""
        return float(self.trajectory.end[body.T])

    @property
    def x_end(self) -> float:
        """x of the centre at the landing (or at the end of the simulation), m."""
        return float(self.trajectory.end[body.X])

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the drop, 64 hex digits; `plinko.engine.drops.digest` lists its bytes."""
        return digest_of(self.board.digest, self.trajectory)

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
    """The flight of a ball that starts at rest at (x, drop.y), x in m, with the exact solver."""
    return Flight(board, follow(board, at_start(board, x), Exact()))
