"""The parts of a board: ball, pegs, walls, bins, drop zone. Plain values, which `Board` checks.

Coordinates in m, x right, y down.
"""

import math
from dataclasses import dataclass

import msgspec

from plinko.engine.board.materials import Material


@dataclass(frozen=True, slots=True)
class BallSpec:
    """The falling disc: radius in m, density in kg/m^2, and its surface."""

    radius: float = 0.08
    density: float = 1.0
    restitution: float = 0.6
    friction: float = 0.0

    @property
    def material(self) -> Material:
        """The ball's surface, for `combine` with a peg's or a wall's."""
        return Material(self.restitution, self.friction)

    @property
    def mass(self) -> float:
        """Mass in kg, rho pi R^2."""
        return self.density * math.pi * self.radius * self.radius

    @property
    def inertia(self) -> float:
        """Moment of inertia of a uniform disc about its centre in kg m^2, m R^2 / 2."""
        return 0.5 * self.mass * self.radius * self.radius


# A server has hundreds of thousands of pegs and walls. Python's garbage collector would need more
# than a tick to visit them all. They contain only numbers, so they cannot be part of a cycle, and
# gc=False hides them from the collector.


class Peg(msgspec.Struct, frozen=True, gc=False):
    """A fixed disc: centre and radius in m."""

    x: float
    y: float
    radius: float


class Wall(msgspec.Struct, frozen=True, gc=False):
    """A fixed segment without thickness, ends in m. Balls hit either side and its ends."""

    x1: float
    y1: float
    x2: float
    y2: float


@dataclass(frozen=True, slots=True)
class Label:
    """A bin's name, such as the prize for landing there. colour: #rrggbb, or None."""

    text: str
    colour: str | None = None


@dataclass(frozen=True, slots=True)
class Bins:
    """Where a drop ends: bin i spans [edges[i], edges[i+1]) on the line y and pays multipliers[i].

    A drop ends when the ball's centre first crosses `y` downward. labels: one entry per bin, None
    for a bin without a label; empty if no bin has one.
    """

    y: float
    edges: tuple[float, ...]
    multipliers: tuple[float, ...]
    labels: tuple[Label | None, ...] = ()

    @property
    def count(self) -> int:
        """Number of bins."""
        return len(self.multipliers)

    def score_of(self, number: int | None) -> float:
        """What a landing in bin `number` pays for a stake of 1; None: no bin, the stake back."""
        return 1.0 if number is None else self.multipliers[number]

    def label_of(self, number: int | None) -> str | None:
        """The label text of bin `number`; None if it has no label or `number` is None."""
        if number is None or not self.labels:
            return None
        label = self.labels[number]
        return None if label is None else label.text


@dataclass(frozen=True, slots=True)
class DropZone:
    """Where a drop starts at rest, in m: at `y`, and at `x` plus an offset in [-jitter, jitter).

    slots: if not empty, the only x that a player may aim at. reach: largest distance of a start
    from x, if larger than the jitter. aim: largest distance from x at which a player may aim; the
    offset, which is uniformly distributed, is then added to the aim instead of to x.
    """

    x: float = 0.0
    y: float = 0.0
    jitter: float = 0.0
    slots: tuple[float, ...] = ()
    reach: float = 0.0
    aim: float = 0.0

    @property
    def span(self) -> float:
        """Largest distance of a start from `x` in m, slots not considered."""
        return max(self.jitter, self.reach)

    @property
    def aim_span(self) -> float:
        """Largest distance of an aim from `x` in m; it keeps every start within `span`."""
        return min(self.aim, self.span - self.jitter)
