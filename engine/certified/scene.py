"""A board as exact numbers: circles and wall faces grown by the ball's radius R.

The ball's centre moves among them as a point. A peg of radius r is a circle of radius r + R. A wall
is a stadium: two faces at distance R from its segment and a circle of radius R about each end.

`plinko.engine.exact.surfaces` decides which surface owns each point of the boundary, for both
solvers. The float64 values of what owns a point are taken as exact, but for what that layout has
found equal within rounding: a wall begins and ends exactly at the circles of its ends, which it may
share with other walls, and a wall that is flush with a peg at its end is exactly tangent to it.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from flint import arb

from plinko.engine.board.fields import BoardFields
from plinko.engine.board.materials import Material
from plinko.engine.certified.balls import ZERO
from plinko.engine.certified.screen import Screen
from plinko.engine.certified.surfaces import Circle, Face, Law, Pair, Piece, Surface
from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.physics import surface
from plinko.engine.physics.surface import is_flush

SIDES = (1, -1)


class _Place(NamedTuple):
    """The centre of a line's end, and how far the line is off it to its left, m."""

    x: arb
    y: arb
    off: arb


class Scene:
    """Everything on a board that decides where a ball goes, at the current precision."""

    def __init__(self, board: BoardFields, others: Sequence[Circle] = ()) -> None:
        """`others`: circles in addition to the board's; their numbers need not be float64."""
        self.gravity, self.drag = arb(board.gravity), arb(board.drag)
        self.radius = arb(board.ball.radius)
        self.start_y, self.bins_y = arb(board.drop.y), arb(board.bins.y)
        self.edges = tuple(arb(edge) for edge in board.bins.edges)
        self.lines_at: dict[Circle, list[tuple[Face, int]]] = {}
        """The faces that continue as a circle, each with the number of that end, 0 or 1."""
        self._items, self._ball = arrays_of(board).items, board.ball.radius
        self._peg_count = len(board.pegs)
        circles = self._circles_of(board)
        self.faces: list[Face] = []
        pair = _pair(board.ball.material, board.wall_material)
        for item in range(self._peg_count, len(self._items), 3):
            if self._items[item, surface.OWNER] == item:
                self.faces += self._faces_of(item, circles, pair)
        self.circles = [c for c in circles if self._items[c.rank, surface.OWNER] == c.rank]
        self.circles += others
        self.screen = Screen(self.circles, self.faces, board)

    def _circles_of(self, board: BoardFields) -> list[Circle]:
        """The pegs, and all ends of walls: a ball passes even onto those that own nothing."""
        peg = _pair(board.ball.material, board.peg_material)
        wall = _pair(board.ball.material, board.wall_material)
        circles = []
        for i, p in enumerate(board.pegs):
            reach = arb(p.radius) + self.radius
            circles.append(Circle(arb(p.x), arb(p.y), reach, KIND_PEG, i, i, peg))
        for i, w in enumerate(board.walls):
            rank = len(board.pegs) + 3 * i
            first, last = (arb(w.x1), arb(w.y1)), (arb(w.x2), arb(w.y2))
            circles.append(Circle(*first, self.radius, KIND_WALL, i, rank + 1, wall))
            circles.append(Circle(*last, self.radius, KIND_WALL, i, rank + 2, wall))
        return circles

    def _faces_of(self, line: int, circles: list[Circle], pair: Pair) -> list[Face]:
        """Both faces of a straight wall."""
        ends = tuple(
            self._circle(circles, int(self._items[line, column]))
            for column in (surface.FIRST_END, surface.LAST_END)
        )
        first, last = ends
        begin, end = self._place(line, first), self._place(line, last)
        x, y, tx, ty, length = _common_tangent(begin, end)
        pieces = self._pieces_of(line, circles, (x, y), (tx, ty))
        faces = []
        for side in SIDES:
            face = Face(
                x, y, tx, ty, length, -side * ty, side * tx,
                self.radius, KIND_WALL, pieces, line, pair, (first, last), side,
            )  # fmt: skip
            faces.append(face)
            for nth, circle in enumerate(face.ends):
                if self.are_flush(face, circle):
                    self.lines_at.setdefault(circle, []).append((face, nth))
        return faces

    def _circle(self, circles: list[Circle], item: int) -> Circle:
        """The circle of an item: a peg, or an end of a wall."""
        if item < self._peg_count:
            return circles[item]
        wall, end = divmod(item - self._peg_count, 3)
        return circles[self._peg_count + 2 * wall + end - 1]

    def law_on(self, lower: Surface) -> Law:
        """The law of a ball's motion on a surface."""
        return Law(lower.curvature, self.gravity, self.drag, lower.pair.friction, self.radius)

    def _place(self, line: int, circle: Circle) -> _Place:
        off = ZERO
        if circle.kind == KIND_PEG:
            left = is_flush(self._items, self._ball, line, 1.0, circle.rank)
            off = (circle.reach - self.radius) * (1 if left else -1)
        return _Place(circle.x, circle.y, off)

    def _pieces_of(
        self, line: int, circles: list[Circle], start: tuple[arb, arb], along: tuple[arb, arb]
    ) -> tuple[Piece, ...]:
        pieces = []
        item = line
        while item >= 0:
            places = []
            for end in (item + 1, item + 2):
                circle = self._circle(circles, end)
                dx, dy = circle.x - start[0], circle.y - start[1]
                places.append(dx * along[0] + dy * along[1])
            index = (item - self._peg_count) // 3
            pieces.append(Piece(index, arb.min(*places), arb.max(*places)))
            item = int(self._items[item, surface.NEXT])
        return tuple(pieces)

    def are_flush(self, face: Face, circle: Circle) -> bool:
        """Whether a ball on the face passes the circle without an impact."""
        return is_flush(self._items, self._ball, face.rank, float(face.side), circle.rank)


def _common_tangent(begin: _Place, end: _Place) -> tuple[arb, arb, arb, arb, arb]:
    """First point, direction and length of the line that is `off` each of two places."""
    dx, dy, turn = end.x - begin.x, end.y - begin.y, end.off - begin.off
    square = dx * dx + dy * dy
    length = (square - turn * turn).sqrt()
    tx, ty = (length * dx - turn * dy) / square, (length * dy + turn * dx) / square
    return begin.x - begin.off * ty, begin.y + begin.off * tx, tx, ty, length


def _pair(ball: Material, other: Material) -> Pair:
    """The larger restitution, and the geometric mean of the frictions."""
    friction = (arb(ball.friction) * arb(other.friction)).sqrt()
    return Pair(arb(max(ball.restitution, other.restitution)), friction)


@lru_cache(maxsize=16)
def scene_of(board: BoardFields, bits: int) -> Scene:
    """The board at a precision of `bits`, which must be the current one."""
    return Scene(board)
