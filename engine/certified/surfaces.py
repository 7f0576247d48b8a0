"""The surfaces of a board as exact numbers: circles and faces of walls."""

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from flint import arb

from plinko.engine.certified.balls import ZERO
from plinko.engine.constants import KIND_PEG
from plinko.engine.physics.surface import ROUNDING


@dataclass(frozen=True, slots=True)
class Pair:
    """Restitution and friction between the ball and a surface."""

    restitution: arb
    friction: arb


class Piece(NamedTuple):
    """A part of a straight wall: an index, and where it begins and ends along the whole, m."""

    wall: int
    begin: arb
    end: arb


@dataclass(frozen=True, slots=True, eq=False)
class Circle:
    """A peg or an end of a wall: the ball's centre stays at least `reach` m from (x, y)."""

    x: arb
    y: arb
    reach: arb
    kind: int
    index: int
    rank: int  # the surface's number, which orders simultaneous impacts
    pair: Pair

    @property
    def curvature(self) -> arb:
        """Curvature of the centre's path along the surface, 1/m."""
        return 1 / self.reach

    def normal(self, x: arb, y: arb) -> tuple[arb, arb]:
        """Unit vector towards a ball at (x, y), which must touch the circle."""
        return unit_vector((x - self.x) / self.reach, (y - self.y) / self.reach)

    def at_contact(self, x: arb, y: arb, nx: arb, ny: arb) -> tuple[arb, arb]:
        """The centre of a ball that touches at (x, y), where the normal is (nx, ny)."""
        return self.x + self.reach * nx, self.y + self.reach * ny

    def is_touched(self, x: arb, y: arb, square: arb) -> bool:
        """Whether a ball at (x, y) is proven to be inside the circle, by less than rounding.

        `square` is |q|^2 - D^2 in m^2. The ball touches the circle then, as in the exact solver: on
        a line that is flush with the circle within rounding, it cannot have hit it before.
        """
        near = sum(map(abs, (x, y, self.x, self.y)), self.reach) * ROUNDING
        return bool(square < 0) and bool(square > -2 * self.reach * near)

    def index_at(self, x: arb, y: arb) -> int:
        """The index in events."""
        return self.index

    @property
    def name(self) -> str:
        """The surface's name in messages."""
        return f"peg {self.index}" if self.kind == KIND_PEG else f"an end of wall {self.index}"


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """One side of a wall: from (x, y) along (tx, ty), with the normal (nx, ny) on that side.

    A ball that touches it has its centre `reach` m off the segment.
    """

    x: arb
    y: arb
    tx: arb
    ty: arb
    length: arb
    nx: arb
    ny: arb
    reach: arb
    kind: int
    pieces: tuple[Piece, ...]  # by ascending index
    rank: int
    pair: Pair
    ends: tuple[Circle, Circle]  # the circles as which it continues
    side: int  # 1 if the normal is (-ty, tx), -1 if it is (ty, -tx)

    @property
    def curvature(self) -> arb:
        """Curvature of the centre's path along the surface, 1/m."""
        return ZERO

    def normal(self, x: arb, y: arb) -> tuple[arb, arb]:
        """Unit vector towards the ball, the same everywhere."""
        return self.nx, self.ny

    def at_contact(self, x: arb, y: arb, nx: arb, ny: arb) -> tuple[arb, arb]:
        """The centre of a ball that touches at (x, y)."""
        gap = self.reach - ((x - self.x) * nx + (y - self.y) * ny)
        return x + gap * nx, y + gap * ny

    def along(self, x: arb, y: arb) -> arb:
        """Distance of the foot of (x, y) from the wall's first end, along the wall, m."""
        return (x - self.x) * self.tx + (y - self.y) * self.ty

    def index_at(self, x: arb, y: arb) -> int:
        """The index in events: the first piece that covers the foot of a ball at (x, y).

        Where two pieces meet within the enclosure, it is the first of them. This index is a name,
        on which nothing depends.
        """
        foot = self.along(x, y)
        beyond = [arb.max(piece.begin - foot, foot - piece.end) for piece in self.pieces]
        for piece, distance in zip(self.pieces, beyond, strict=True):
            if not distance > 0:
                return piece.wall
        return min(zip(map(float, beyond), self.pieces, strict=True), key=lambda each: each[0])[
            1
        ].wall

    @property
    def name(self) -> str:
        """The surface's name in messages."""
        return f"wall {self.pieces[0].wall}"


Surface: TypeAlias = Circle | Face


class Law(NamedTuple):
    """What decides the motion of a ball of this radius, in m, on a surface.

    curvature in 1/m, gravity in m/s^2, drag in 1/s; friction is Coulomb's coefficient.
    """

    curvature: arb
    gravity: arb
    drag: arb
    friction: arb
    radius: arb

    def normal_force(self, ny: arb, u: arb) -> arb:
        """Per unit mass, m/s^2."""
        return -self.gravity * ny - self.curvature * u * u

    def drive(self, nx: arb, u: arb) -> arb:
        """The force along the surface without friction, per unit mass."""
        return self.gravity * nx - self.drag * u


def unit_vector(nx: arb, ny: arb) -> tuple[arb, arb]:
    """A sharper enclosure of (nx, ny), whose length is known to be one.

    The larger component follows from the smaller as sqrt(1 - n^2), whose error is the smaller
    one's times their ratio, which is less than one.
    """
    if abs(nx) < abs(ny):
        other = (1 - nx * nx).sqrt()
        return nx, other if ny > 0 else -other
    if abs(ny) < abs(nx):
        other = (1 - ny * ny).sqrt()
        return other if nx > 0 else -other, ny
    return nx, ny
