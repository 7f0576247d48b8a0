"""A board as exact numbers: circles and wall faces grown by the ball's radius; it is a point.

A peg is a circle of radius r + R. A wall is the stadium about its segment: two faces at distance R
and a circle of radius R about each end. The board's float64 values are taken as they stand.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf, sqrt
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from flint import arb

from engine.board.fields import BoardFields
from engine.board.materials import Material
from engine.certified.balls import ZERO
from engine.constants import KIND_PEG, KIND_WALL

SCREEN_MARGIN = 1e-9
"""Relative. What float64 rounds off of a screen is a millionth of this; a larger one only makes
more surfaces be looked at by proof."""


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


class Scene:
    """All of a board that decides where a ball goes, at the precision that was set."""

    def __init__(self, board: BoardFields, others: Sequence[Circle] = ()) -> None:
        """`others`: circles besides those of the board, whose numbers need not be float64."""
        self.gravity, self.drag = arb(board.gravity), arb(board.drag)
        self.radius = arb(board.ball.radius)
        self.start_y, self.bins_y = arb(board.drop.y), arb(board.bins.y)
        self.edges = tuple(arb(edge) for edge in board.bins.edges)
        self.circles: list[Circle] = []
        self.faces: list[Face] = []
        self.lines_at: dict[Circle, list[tuple[Face, int]]] = {}
        """The faces that end in a circle, and which end of them it is, 0 or 1."""
        peg = _pair(board.ball.material, board.peg_material)
        wall = _pair(board.ball.material, board.wall_material)
        for index, p in enumerate(board.pegs):
            reach = arb(p.radius) + self.radius
            self.circles.append(Circle(arb(p.x), arb(p.y), reach, KIND_PEG, index, index, peg))
        self._add_walls(board, wall)
        self.circles += others
        self._screen = _Screen(self.circles, self.faces)
        self.smallest = min([float(c.reach) for c in self.circles], default=board.ball.radius)
        self.box = _box(board)

    def _add_walls(self, board: BoardFields, pair: Pair) -> None:
        ends: dict[tuple[float, float], Circle] = {}
        for index, w in enumerate(board.walls):
            rank = len(board.pegs) + 3 * index
            both = []
            for nth, place in enumerate(((w.x1, w.y1), (w.x2, w.y2))):
                if place not in ends:
                    x, y = arb(place[0]), arb(place[1])
                    kind = KIND_WALL
                    ends[place] = Circle(x, y, self.radius, kind, index, rank + 1 + nth, pair)
                    self.circles.append(ends[place])
                both.append(ends[place])
            first, last = both
            dx, dy = last.x - first.x, last.y - first.y
            length = (dx * dx + dy * dy).sqrt()
            tx, ty = dx / length, dy / length
            for side in (1, -1):
                face = Face(
                    first.x, first.y, tx, ty, length, -side * ty, side * tx,
                    self.radius, KIND_WALL, index, rank, pair, (first, last),
                )  # fmt: skip
                self.faces.append(face)
                for nth, end in enumerate(both):
                    self.lines_at.setdefault(end, []).append((face, nth))

    def near(self, a: tuple[float, float], b: tuple[float, float], bulge: float) -> list[Surface]:
        """The surfaces that a path from a to b may touch which stays within `bulge` of the chord.

        A screen in float64: its margin is a million times what rounding can do to it.
        """
        return [*self._screen.circles(a, b, bulge), *self._screen.faces(a, b, bulge)]


def _pair(ball: Material, other: Material) -> Pair:
    """The pair rules: the larger restitution, the geometric mean of the frictions."""
    friction = (arb(ball.friction) * arb(other.friction)).sqrt()
    return Pair(arb(max(ball.restitution, other.restitution)), friction)


def _box(board: BoardFields) -> tuple[float, float, float]:
    """x_min, x_max and y_min, m: a ball beyond these has left the board for good."""
    left, right, top, _ = board.extent
    size = max(right - left, board.bins.y - top)
    return left - size, right + size, top - size


class _Screen:
    """Rough places of all surfaces as float64."""

    def __init__(self, circles: list[Circle], faces: list[Face]) -> None:
        self._circles, self._faces = circles, faces
        rows = [(float(c.x), float(c.y), float(c.reach)) for c in circles]
        self._places = np.array(rows).reshape(-1, 3)
        lines = [(float(f.x), float(f.y), float(f.nx), float(f.ny), float(f.reach)) for f in faces]
        self._lines = np.array(lines).reshape(-1, 5)
        size = max([1.0, *np.abs(self._places).ravel().tolist()])
        self._margin = SCREEN_MARGIN * size

    def circles(
        self, a: tuple[float, float], b: tuple[float, float], bulge: float
    ) -> list[Surface]:
        """Circles nearer to the chord than their reach and the bulge."""
        place = self._places
        qx, qy = place[:, 0] - a[0], place[:, 1] - a[1]
        ex, ey = b[0] - a[0], b[1] - a[1]
        square = ex * ex + ey * ey
        if square > 0.0:
            share = np.clip((qx * ex + qy * ey) / square, 0.0, 1.0)
            qx, qy = qx - share * ex, qy - share * ey
        limit = place[:, 2] + (bulge + self._margin)
        close: npt.NDArray[np.intp] = np.flatnonzero(qx * qx + qy * qy < limit * limit)
        return [self._circles[i] for i in close]

    def faces(self, a: tuple[float, float], b: tuple[float, float], bulge: float) -> list[Surface]:
        """Faces whose endless line comes within the bulge of the chord."""
        line = self._lines
        at_a = (a[0] - line[:, 0]) * line[:, 2] + (a[1] - line[:, 1]) * line[:, 3] - line[:, 4]
        at_b = (b[0] - line[:, 0]) * line[:, 2] + (b[1] - line[:, 1]) * line[:, 3] - line[:, 4]
        slack = bulge + self._margin
        crossed = (np.minimum(at_a, at_b) < slack) & (np.maximum(at_a, at_b) > -slack)
        return [self._faces[i] for i in np.flatnonzero(crossed)]


@lru_cache(maxsize=16)
def scene_of(board: BoardFields, bits: int) -> Scene:
    """The board at a precision of `bits`, which must be the one that is set."""
    return Scene(board)


def travel_time(speed: float, pull: float, smallest: float) -> float:
    """A stretch of flight in s that bends by a quarter of the smallest reach at most."""
    by_bend = sqrt(2.0 * smallest / pull) if pull > 0.0 else inf
    by_way = 8.0 * smallest / speed if speed > 0.0 else inf
    return min(by_bend, by_way, 1.0)
