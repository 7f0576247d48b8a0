"""A board as exact numbers: circles and wall faces grown by the ball's radius R.

The ball's centre moves among them as a point. A peg of radius r is a circle of radius r + R. A wall
is a stadium: two faces at distance R from its segment and a circle of radius R about each end. The
board's float64 values are taken as exact.
"""

from collections.abc import Sequence
from functools import lru_cache

from flint import arb

from engine.board.fields import BoardFields
from engine.board.materials import Material
from engine.certified.screen import Screen
from engine.certified.surfaces import Circle, Face, Pair
from engine.constants import KIND_PEG, KIND_WALL


class Scene:
    """Everything on a board that decides where a ball goes, at the current precision."""

    def __init__(self, board: BoardFields, others: Sequence[Circle] = ()) -> None:
        """`others`: circles in addition to the board's; their numbers need not be float64."""
        self.gravity, self.drag = arb(board.gravity), arb(board.drag)
        self.radius = arb(board.ball.radius)
        self.start_y, self.bins_y = arb(board.drop.y), arb(board.bins.y)
        self.edges = tuple(arb(edge) for edge in board.bins.edges)
        self.circles: list[Circle] = []
        self.faces: list[Face] = []
        self.lines_at: dict[Circle, list[tuple[Face, int]]] = {}
        """The faces that end in a circle, each with the number of that end, 0 or 1."""
        peg = _pair(board.ball.material, board.peg_material)
        wall = _pair(board.ball.material, board.wall_material)
        for index, p in enumerate(board.pegs):
            reach = arb(p.radius) + self.radius
            self.circles.append(Circle(arb(p.x), arb(p.y), reach, KIND_PEG, index, index, peg))
        self._add_walls(board, wall)
        self.circles += others
        self.screen = Screen(self.circles, self.faces, board)

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


def _pair(ball: Material, other: Material) -> Pair:
    """The larger restitution, and the geometric mean of the frictions."""
    friction = (arb(ball.friction) * arb(other.friction)).sqrt()
    return Pair(arb(max(ball.restitution, other.restitution)), friction)


@lru_cache(maxsize=16)
def scene_of(board: BoardFields, bits: int) -> Scene:
    """The board at a precision of `bits`, which must be the current one."""
    return Scene(board)
