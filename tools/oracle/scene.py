"""A board as exact numbers: discs and wall faces grown by the ball's radius, in one mpmath context.

The ball becomes a point. A peg becomes a circle of radius r + R, a wall the stadium around its
segment: two faces at distance R and a circle of radius R about each end.
"""

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

import mpmath
import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import KIND_PEG, KIND_WALL

Real: TypeAlias = Any  # an mpf; mpmath has no types
SCREEN = 1e-9  # m; far above the rounding of float64, far below any gap drawn on purpose
GUARD_DIGITS = 15  # in addition to the requested digits; cancellation in the drag terms costs fewer


@dataclass(frozen=True)
class Material:
    """The values of a pair for impacts: restitution (maximum) and friction (geometric mean)."""

    restitution: Real
    friction: Real


@dataclass(frozen=True, eq=False)
class Circle:
    """The centre may not come nearer than `reach` to (x, y): a peg, or the end of a wall.

    `out` is None for a peg; for a wall's end it is the unit vector that leaves the wall there.
    """

    x: Real
    y: Real
    reach: Real
    kind: int
    index: int
    material: Material
    out: tuple[Real, Real] | None = None

    def normal(self, x: Real, y: Real) -> tuple[Real, Real]:
        """Unit vector from the circle's middle towards the point (x, y)."""
        dx, dy = x - self.x, y - self.y
        distance = (dx * dx + dy * dy) ** 0.5
        return dx / distance, dy / distance

    def gap(self, x: Real, y: Real) -> Real:
        """Distance in metres from the point to the circle's line, negative inside."""
        dx, dy = x - self.x, y - self.y
        return (dx * dx + dy * dy) ** 0.5 - self.reach


@dataclass(frozen=True, eq=False)
class Face:
    """One side of a wall: from (x, y) along the unit vector (dx, dy), outward normal (nx, ny)."""

    x: Real
    y: Real
    dx: Real
    dy: Real
    length: Real
    nx: Real
    ny: Real
    reach: Real
    kind: int
    index: int
    material: Material

    def normal(self, x: Real, y: Real) -> tuple[Real, Real]:
        """The face's outward normal; the point does not matter."""
        return self.nx, self.ny

    def gap(self, x: Real, y: Real) -> Real:
        """Distance in metres from the point to the face's (endless) line, negative behind it."""
        return (x - self.x) * self.nx + (y - self.y) * self.ny - self.reach

    def along(self, x: Real, y: Real) -> Real:
        """The point's projection onto the wall, in metres from the first end."""
        return (x - self.x) * self.dx + (y - self.y) * self.dy


Body: TypeAlias = Circle | Face


class Scene:
    """The whole board in one context: bodies, gravity, drag, the bins' line."""

    def __init__(self, board: Board, dps: int) -> None:
        self.ctx = mpmath.MPContext()
        self.ctx.dps = dps + GUARD_DIGITS
        self.tiny = self.ctx.mpf(10) ** (-(7 * self.ctx.dps) // 10)
        real = self.ctx.mpf
        self.g, self.k = real(board.gravity), real(board.drag)
        self.radius = real(board.ball.radius)
        self.bins_y = real(board.bins.y)
        self.edges = tuple(real(edge) for edge in board.bins.edges)
        self.start_y = real(board.drop.y)
        self.circles: list[Circle] = []
        self.faces: list[Face] = []
        peg = self._pair(board, board.peg_material)
        wall = self._pair(board, board.wall_material)
        for index, p in enumerate(board.pegs):
            reach = real(p.radius) + self.radius
            self.circles.append(Circle(real(p.x), real(p.y), reach, KIND_PEG, index, peg))
        for index, w in enumerate(board.walls):
            self._add_wall(index, (real(w.x1), real(w.y1)), (real(w.x2), real(w.y2)), wall)
        self.smallest = min((c.reach for c in self.circles), default=self.radius)
        self.middles: npt.NDArray[np.float64] = np.array(
            [(float(c.x), float(c.y), float(c.reach)) for c in self.circles]
        ).reshape(-1, 3)
        self.lines: npt.NDArray[np.float64] = np.array(
            [
                [float(a) for a in (f.x, f.y, f.nx, f.ny, f.reach, f.length, f.dx, f.dy)]
                for f in self.faces
            ]
        ).reshape(-1, 8)

    def _pair(self, board: Board, other: Any) -> Material:
        real = self.ctx.mpf
        return Material(
            max(real(board.ball.restitution), real(other.restitution)),
            self.ctx.sqrt(real(board.ball.friction) * real(other.friction)),
        )

    def _add_wall(
        self, index: int, a: tuple[Real, Real], b: tuple[Real, Real], pair: Material
    ) -> None:
        ex, ey = b[0] - a[0], b[1] - a[1]
        length = self.ctx.sqrt(ex * ex + ey * ey)
        dx, dy = ex / length, ey / length
        size = self.radius
        for nx, ny in ((-dy, dx), (dy, -dx)):
            face = Face(a[0], a[1], dx, dy, length, nx, ny, size, KIND_WALL, index, pair)
            self.faces.append(face)
        for (x, y), out in ((a, (-dx, -dy)), (b, (dx, dy))):
            self.circles.append(Circle(x, y, size, KIND_WALL, index, pair, out))

    def near(self, x: Real, y: Real, far: float) -> tuple[list[Circle], list[Face]]:
        """Circles that the point is at most `far` m outside of, and faces by whose line it is.

        A safe screen in float64, if `far` is well above rounding.
        """
        to_circle = self._away(x, y) - self.middles[:, 2]
        to_line = np.abs(self._across(x, y) - self.lines[:, 4])
        return (
            [self.circles[i] for i in np.flatnonzero(to_circle <= far)],
            [self.faces[i] for i in np.flatnonzero(to_line <= far)],
        )

    def touching(self, x: Real, y: Real) -> list[Body]:
        """All bodies that the ball touches when its centre is at (x, y)."""
        circles, faces = self.near(x, y, SCREEN)
        found: list[Body] = [c for c in circles if abs(c.gap(x, y)) < self.tiny]
        for face in faces:
            inside = -self.tiny < face.along(x, y) < face.length + self.tiny
            if inside and abs(face.gap(x, y)) < self.tiny:
                found.append(face)
        return found

    def depth(self, x: Real, y: Real) -> float:
        """How deep in m the point is in the deepest body, to some 1e-15 m; negative outside."""
        in_circle = (self.middles[:, 2] - self._away(x, y)).max(initial=-math.inf)
        dx, dy = float(x) - self.lines[:, 0], float(y) - self.lines[:, 1]
        along = dx * self.lines[:, 6] + dy * self.lines[:, 7]
        beside = (along >= 0.0) & (along <= self.lines[:, 5])
        deep = (self.lines[:, 4] - np.abs(self._across(x, y)))[beside]
        return float(max(in_circle, deep.max(initial=-math.inf)))

    def _away(self, x: Real, y: Real) -> npt.NDArray[np.float64]:
        dx, dy = float(x) - self.middles[:, 0], float(y) - self.middles[:, 1]
        return np.hypot(dx, dy)

    def _across(self, x: Real, y: Real) -> npt.NDArray[np.float64]:
        dx, dy = float(x) - self.lines[:, 0], float(y) - self.lines[:, 1]
        across: npt.NDArray[np.float64] = dx * self.lines[:, 2] + dy * self.lines[:, 3]
        return across

    def bin_of(self, x: Real) -> int | None:
        """Index of the bin that contains x; None if no bin does."""
        if not self.edges[0] <= x < self.edges[-1]:
            return None
        return sum(1 for edge in self.edges if edge <= x) - 1
