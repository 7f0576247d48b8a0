"""The parts of a board that a ball touches, as exact numbers: circles and faces of walls."""

from dataclasses import dataclass
from typing import TypeAlias

from flint import arb

from engine.certified.balls import ZERO
from engine.constants import KIND_PEG


@dataclass(frozen=True, slots=True)
class Pair:
    """What an impact needs to know of the ball and a surface: restitution and friction."""

    restitution: arb
    friction: arb


@dataclass(frozen=True, slots=True, eq=False)
class Circle:
    """The ball's centre may not come nearer than `reach` to (x, y): a peg, or the end of a wall."""

    x: arb
    y: arb
    reach: arb
    kind: int
    index: int
    rank: int  # its surface number, which decides between simultaneous impacts
    pair: Pair

    @property
    def curvature(self) -> arb:
        """Of the centre's path over the surface, 1/m."""
        return 1 / self.reach

    def normal(self, x: arb, y: arb) -> tuple[arb, arb]:
        """Unit vector towards a ball at (x, y) that touches; one that does not is no question."""
        return unit_vector((x - self.x) / self.reach, (y - self.y) / self.reach)

    def at_contact(self, x: arb, y: arb, nx: arb, ny: arb) -> tuple[arb, arb]:
        """The centre of a ball that touches at (x, y), where the normal is (nx, ny)."""
        return self.x + self.reach * nx, self.y + self.reach * ny

    @property
    def name(self) -> str:
        """For people: which part of the board this is."""
        return f"peg {self.index}" if self.kind == KIND_PEG else f"an end of wall {self.index}"


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """One side of a wall: from (x, y) along (tx, ty), with the normal (nx, ny) on that side."""

    x: arb
    y: arb
    tx: arb
    ty: arb
    length: arb
    nx: arb
    ny: arb
    reach: arb
    kind: int
    index: int
    rank: int
    pair: Pair
    ends: tuple[Circle, Circle]

    @property
    def curvature(self) -> arb:
        """Of the centre's path over the surface, 1/m."""
        return ZERO

    def normal(self, x: arb, y: arb) -> tuple[arb, arb]:
        """Unit vector towards the ball; the place does not matter."""
        return self.nx, self.ny

    def at_contact(self, x: arb, y: arb, nx: arb, ny: arb) -> tuple[arb, arb]:
        """The centre of a ball that touches at (x, y)."""
        gap = self.reach - ((x - self.x) * nx + (y - self.y) * ny)
        return x + gap * nx, y + gap * ny

    def along(self, x: arb, y: arb) -> arb:
        """How far along the wall the foot of (x, y) is from its first end, m."""
        return (x - self.x) * self.tx + (y - self.y) * self.ty

    @property
    def name(self) -> str:
        """For people: which part of the board this is."""
        return f"wall {self.index}"


Surface: TypeAlias = Circle | Face


def unit_vector(nx: arb, ny: arb) -> tuple[arb, arb]:
    """(nx, ny), known to have length one, with the larger part made sharper by the smaller."""
    if abs(nx) < abs(ny):
        other = (1 - nx * nx).sqrt()
        return nx, other if ny > 0 else -other
    if abs(ny) < abs(nx):
        other = (1 - ny * ny).sqrt()
        return other if nx > 0 else -other, ny
    return nx, ny
