"""The parts a board is made of: ball, pegs, walls, bins, drop zone. Plain values, checked by Board.

Metres, x right, y down.
"""

import math
from dataclasses import dataclass

import msgspec

from engine.board.materials import Material


@dataclass(frozen=True, slots=True)
class BallSpec:
    """The disc that falls: radius in m, density in kg/m^2, and its surface."""

    radius: float = 0.08
    density: float = 1.0
    restitution: float = 0.6
    friction: float = 0.0

    @property
    def material(self) -> Material:
        """The ball's surface, to combine with a peg's or a wall's."""
        return Material(self.restitution, self.friction)

    @property
    def mass(self) -> float:
        """Mass in kg, rho pi R^2."""
        return self.density * math.pi * self.radius * self.radius

    @property
    def inertia(self) -> float:
        """Moment of inertia of a uniform disc about its centre in kg m^2, m R^2 / 2."""
        return 0.5 * self.mass * self.radius * self.radius


# A server keeps hundreds of thousands of pegs and walls, on which Python's garbage collector would
# spend more than a tick each time; of numbers alone, they can be no garbage that it has to find.


class Peg(msgspec.Struct, frozen=True, gc=False):
    """A disc that does not move: centre and radius in m."""

    x: float
    y: float
    radius: float


class Wall(msgspec.Struct, frozen=True, gc=False):
    """A segment without thickness that does not move, hit from either side, ends included; m."""

    x1: float
    y1: float
    x2: float
    y2: float


@dataclass(frozen=True, slots=True)
class Label:
    """What a bin is called: the prize that a ball in it wins. `colour`: #rrggbb, or None."""

    text: str
    colour: str | None = None


@dataclass(frozen=True, slots=True)
class Bins:
    """Where a drop ends: bin i spans [edges[i], edges[i+1]) on the line y and pays multipliers[i].

    A drop ends when the ball's centre first crosses `y` downward. labels: of each bin, None for
    one without; empty where no bin has one.
    """

    y: float
    edges: tuple[float, ...]
    multipliers: tuple[float, ...]
    labels: tuple[Label | None, ...] = ()

    @property
    def count(self) -> int:
        """Number of bins."""
        return len(self.multipliers)

    def label_of(self, number: int | None) -> str | None:
        """Text of the label of this bin, or None: it has none, or the ball is in no bin."""
        if number is None or not self.labels:
            return None
        label = self.labels[number]
        return None if label is None else label.text


@dataclass(frozen=True, slots=True)
class DropZone:
    """Where a drop starts, at rest: `y`, and `x` plus a uniform offset in [-jitter, jitter); m.

    slots: the only places that a player may aim at, often none. reach: how far from x a ball may
    start, where that is more than the jitter. aim: how far from x a player may aim; the aim takes
    the place of x, and the offset is drawn about it.
    """

    x: float = 0.0
    y: float = 0.0
    jitter: float = 0.0
    slots: tuple[float, ...] = ()
    reach: float = 0.0
    aim: float = 0.0

    @property
    def span(self) -> float:
        """How far from `x` a ball may start, m, slots aside."""
        return max(self.jitter, self.reach)

    @property
    def aim_span(self) -> float:
        """How far from `x` a player may aim, m: every start that a seed draws is within `span`."""
        return min(self.aim, self.span - self.jitter)
