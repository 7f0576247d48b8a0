"""A catalogue of hard boards, on which a ball touches two surfaces, hangs, or creeps.

Each kind is a recipe: a function that adds random surfaces to a `Draft`. The same recipes make
examples for hypothesis (`hard_boards`), which shrinks them, and any number of numbered boards
(`hard_board`). Recipes do not avoid traps or overlapping pegs; `playable` returns only the boards
that the validator accepts.

These boards go beyond the presets: restitution 0 to 0.5, friction 0 to 1, drag up to its limit.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from random import Random
from typing import Any, Final

from hypothesis import strategies as st

from plinko.engine.board.form import MAX_DRAG
from plinko.engine.board.model import Board
from plinko.engine.errors import BoardError

SIDE: Final = 1.0
"""m; the upright side walls are at -SIDE and SIDE."""

BOTTOM: Final = 2.5
"""m; the height of the bins, below starts at 0."""

RESTITUTIONS: Final = (0.0, 0.0, 0.0, 0.05, 0.1, 0.2, 0.5)
FRICTIONS: Final = (0.0, 0.1, 0.3, 0.6, 1.0)
DRAGS: Final = (0.0, 0.0, 0.0, 0.0, 0.005, 1.0, 1.0, 10.0, MAX_DRAG)

LEAST_SPEED: Final = 0.015
"""m/s; least terminal speed on a slope, so that no ball reaches the time limit."""

Point = tuple[float, float]


@dataclass
class Draft:
    """A board to which recipes add; metres, x right, y down. Balls start around `aim`."""

    choice: Random
    radius: float
    gravity: float
    drag: float
    pegs: list[tuple[float, float, float]] = field(default_factory=list)
    walls: list[tuple[float, float, float, float]] = field(default_factory=list)
    aim: float = 0.0
    spread: float = 0.3
    starts: list[float] = field(default_factory=list)

    @property
    def least_slope(self) -> float:
        """Sine of the flattest slope that a ball leaves within seconds."""
        return LEAST_SPEED * self.drag / self.gravity

    def angle(self, low: float, high: float) -> float:
        """An angle in rad: one of the two, hardly more than the least, or anywhere in between."""
        anywhere = self.choice.uniform(low, high)
        least: float = low + (high - low) * 10.0 ** self.choice.uniform(-4.0, 0.0)
        return self.choice.choice([low, high, least, least, least, anywhere, anywhere, anywhere])

    def peg_under(self, place: Point, lean: float, radius: float) -> None:
        """Add a peg that a ball at `place` touches; its normal leans from 'up' by `lean` rad."""
        far = self.radius + radius
        self.pegs.append((place[0] - far * math.sin(lean), place[1] + far * math.cos(lean), radius))

    def gap_beside(self, x: float, y: float, radius: float) -> float:
        """Gap in m between such a peg and everything else, side walls included."""
        gaps = [SIDE - abs(x) - radius]
        gaps += [math.hypot(x - px, y - py) - radius - other for px, py, other in self.pegs]
        for x1, y1, x2, y2 in self.walls:
            length = math.hypot(x2 - x1, y2 - y1)
            tx, ty = (x2 - x1) / length, (y2 - y1) / length
            along = min(max((x - x1) * tx + (y - y1) * ty, 0.0), length)
            gaps.append(math.hypot(x - x1 - along * tx, y - y1 - along * ty) - radius)
        return min(gaps)


Recipe = Callable[[Draft, float, float], None]
"""Adds surfaces to the draft around (x, y) in m, where a ball should pass."""


def _normals(draft: Draft, steepest: float) -> tuple[float, float]:
    """Angles in rad, the smaller first, of two normals that lean to the same side."""
    low = draft.angle(1e-3, 1.2)
    high = draft.angle(low + 0.05, max(low + 0.1, steepest))
    side = draft.choice.choice([-1.0, 1.0])
    return side * low, side * high


def _beside_another(draft: Draft, apart: float) -> float:
    """A peg's radius in m such that a ball can also touch another peg, `apart` rad around it."""
    half = math.sin(0.5 * min(apart, 2.0))
    return min(
        draft.choice.choice([0.01, 0.03, 0.1, 0.3]), 0.999 * draft.radius * half / (1.0 - half)
    )


def notch_of_pegs(draft: Draft, x: float, y: float) -> None:
    """Two pegs that a ball touches at once and that push it to the same side."""
    low, high = _normals(draft, steepest=2.2)
    for lean in (low, high):
        draft.peg_under((x, y), lean, _beside_another(draft, abs(high - low)))


def corner_of_walls(draft: Draft, x: float, y: float) -> None:
    """Two walls that meet in a corner: a slope that is bent, a slope under an overhang."""
    low, high = _normals(draft, steepest=2.6)
    half = draft.radius * math.tan(0.5 * abs(high - low))  # from the corner to where a ball touches
    middle = 0.5 * (low + high)
    far = draft.radius / math.cos(0.5 * (high - low))
    corner = x - far * math.sin(middle), y + far * math.cos(middle)
    side = math.copysign(1.0, low)
    for lean, way in ((low, side), (high, -side)):
        length = half + draft.choice.uniform(0.02, 0.3)
        end = corner[0] + way * length * math.cos(lean), corner[1] + way * length * math.sin(lean)
        draft.walls.append((*corner, *end))


def peg_on_a_wall(draft: Draft, x: float, y: float) -> None:
    """A peg on a slope, above it or half in it: the ball rolls down into both."""
    low, high = _normals(draft, steepest=2.0)
    for_wall, for_peg = draft.choice.choice([(low, high), (high, low)])
    draft.peg_under((x, y), for_peg, draft.choice.choice([0.01, 0.03, 0.1]))
    _slope_under(draft, (x, y), for_wall)


def _slope_under(draft: Draft, place: Point, lean: float) -> None:
    """A slope that a ball at `place` touches, which extends up and down from there."""
    x, y = place[0] - draft.radius * math.sin(lean), place[1] + draft.radius * math.cos(lean)
    tx, ty = math.copysign(1.0, lean) * math.cos(lean), abs(math.sin(lean))
    up, down = draft.choice.choice([1e-3, 0.01, 0.2]), draft.choice.uniform(0.02, 0.2)
    draft.walls.append((x - up * tx, y - up * ty, x + down * tx, y + down * ty))


def peg_in_a_side_wall(draft: Draft, x: float, y: float) -> None:
    """Pegs that stick out of the upright side walls: a ball that spins stays in the notch."""
    del x
    for side in (-1.0, 1.0):
        radius = draft.choice.choice([0.03, 0.05, 0.1, 0.3])
        out = (radius + draft.radius) * math.sin(draft.angle(1e-3, 1.0))
        at = side * (SIDE - draft.radius + out)
        draft.pegs.append((at, y + draft.choice.uniform(-0.2, 0.2), radius))
    draft.spread = SIDE - draft.radius - 0.02


def twins(draft: Draft, x: float, y: float) -> None:
    """Two pegs, or a peg and a wall, that a ball hits at the same instant, to the last bits."""
    low, high = _normals(draft, steepest=1.5)
    draft.peg_under((x, y), high, _beside_another(draft, abs(high - low)))
    if draft.choice.random() < 0.5:
        draft.peg_under((x, y), low, _beside_another(draft, abs(high - low)))
    else:
        _slope_under(draft, (x, y), low)
    draft.starts += [x, math.nextafter(x, -1.0), math.nextafter(x, 1.0), x - 1e-12, x + 1e-9]


def overhangs(draft: Draft, x: float, y: float) -> None:
    """A ramp that throws the ball against the undersides of leaning bars."""
    side = draft.choice.choice([-1.0, 1.0])
    slope, length = draft.choice.uniform(0.3, 1.0), draft.choice.uniform(0.1, 0.4)
    end = x + side * length * math.cos(slope), y + length * math.sin(slope) - 0.4
    draft.walls.append((x, y - 0.4, *end))
    draft.aim = 0.5 * (x + end[0])
    draft.spread = 0.5 * abs(end[0] - x)
    at = end[0] + side * draft.choice.uniform(2.1 * draft.radius, 0.3), end[1] - 0.2
    for _ in range(draft.choice.randint(1, 3)):
        lean, length = draft.angle(1e-3, 0.8), draft.choice.uniform(0.2, 0.5)
        foot = at[0] + side * length * math.sin(lean), at[1] + length * math.cos(lean)
        if abs(foot[0]) < SIDE - 2.0 * draft.radius:
            draft.walls.append((*at, *foot))
        at = draft.choice.uniform(-0.5, 0.5), foot[1] + 2.1 * draft.radius
        side = draft.choice.choice([-1.0, 1.0])


def shelves(draft: Draft, x: float, y: float) -> None:
    """Slopes from the side walls, some nearly level: the ball rolls from one to the next."""
    for row in range(draft.choice.randint(1, 3)):
        side = draft.choice.choice([-1.0, 1.0])
        slope = max(draft.choice.choice([1e-3, 0.03, 0.1, 0.3]), draft.least_slope)
        width = SIDE + side * 0.5 * x
        height = y + 0.45 * row
        draft.walls.append((side * SIDE, height, side * (SIDE - width), height + slope * width))


def funnel(draft: Draft, x: float, y: float) -> None:
    """Two slopes with a gap between them that is hardly wider than the ball."""
    mouth = draft.radius * draft.angle(1.0 + 1e-6, 1.5)
    for side in (-1.0, 1.0):
        lip = x + side * mouth
        rise = max(draft.angle(0.03, 1.2), draft.least_slope) * abs(side * SIDE - lip)
        draft.walls.append((side * SIDE, y - min(rise, 0.5), lip, y))


def chute(draft: Draft, x: float, y: float) -> None:
    """Two parallel bars, upright or leaning, with hardly room for a ball to bounce between."""
    lean = draft.angle(-0.8, 0.8)
    half = draft.radius * draft.angle(1.0 + 1e-7, 1.05)
    tx, ty = math.sin(lean), math.cos(lean)
    for side in (-1.0, 1.0):
        at = x + side * half * ty, y - side * half * tx
        length = draft.choice.uniform(0.1, 0.4)
        # The lower bar begins farther up, as a ramp into the chute.
        ahead = 0.15 if side * lean < 0.0 else 0.0
        draft.walls.append(
            (at[0] - ahead * tx, at[1] - ahead * ty, at[0] + length * tx, at[1] + length * ty)
        )


def stairs(draft: Draft, x: float, y: float) -> None:
    """A row of pegs that touch, steep enough to go down: in each notch the ball touches two."""
    radius = draft.choice.choice([0.01, 0.02, 0.05])
    lean = math.asin(radius / (draft.radius + radius))
    tilt = draft.angle(lean + 0.02, 1.3)
    side = draft.choice.choice([-1.0, 1.0])
    for step in range(draft.choice.randint(2, 6)):
        along = 2.0 * radius * step * (1.0 + 1e-9)
        at = x + side * along * math.cos(tilt), y + along * math.sin(tilt)
        draft.pegs.append((*at, radius))


def treacle(draft: Draft, x: float, y: float) -> None:
    """Pegs and high drag: a ball falls a few centimetres per second and takes minutes."""
    draft.gravity, draft.drag = 9.81, draft.choice.choice([100.0, 300.0, MAX_DRAG])
    for row in range(4):
        peg = x + draft.choice.uniform(-0.4, 0.4), y - 0.6 + 0.4 * row
        draft.pegs.append((*peg, draft.choice.choice([0.001, 0.03, 0.1])))


def thicket(draft: Draft, x: float, y: float) -> None:
    """Pegs and bars at random places that leave room for the ball between them."""
    for _ in range(draft.choice.randint(3, 9)):
        at = x + draft.choice.uniform(-0.8, 0.8), y + draft.choice.uniform(-0.3, 1.2)
        radius = draft.choice.choice([0.001, 0.03, 0.1, 0.2])
        if draft.gap_beside(*at, radius) > 2.0 * draft.radius + 1e-9:
            draft.pegs.append((*at, radius))
    for _ in range(draft.choice.randint(0, 3)):
        at = x + draft.choice.uniform(-0.6, 0.6), y + draft.choice.uniform(-0.3, 1.2)
        angle, length = draft.choice.uniform(0.1, 3.0), draft.choice.choice([0.05, 0.3])
        end = at[0] + length * math.cos(angle), at[1] + length * math.sin(angle)
        if draft.gap_beside(*at, length) > 2.0 * draft.radius:
            draft.walls.append((*at, *end))


KINDS: Final[dict[str, Recipe]] = {
    recipe.__name__: recipe
    for recipe in (
        notch_of_pegs, corner_of_walls, peg_on_a_wall, peg_in_a_side_wall, twins, overhangs,
        shelves, funnel, chute, stairs, treacle, thicket,
    )
}  # fmt: skip


@dataclass(frozen=True)
class HardBoard:
    """A board's JSON form, and starts in m that aim at its hard part, if any."""

    kind: str
    form: dict[str, Any]
    starts: tuple[float, ...]

    def playable(self) -> Board | None:
        """The board, or None if the validator refuses it."""
        try:
            return Board.from_json(self.form)
        except BoardError:
            return None


def _made(kind: str, choice: Random) -> HardBoard:
    radius = choice.choice([0.03, 0.05, 0.08])
    drag = choice.choice(DRAGS)
    gravity = max(9.81, drag * choice.choice([1.0, 10.0]) if drag > 10.0 else 0.0)
    draft = Draft(choice, radius, gravity, drag)
    x, y = choice.uniform(-0.4, 0.4), choice.uniform(1.0, 1.8)
    draft.aim = x
    KINDS[kind](draft, x, y)
    if kind not in {"twins", "overhangs"}:
        _deflect(draft, y - 0.2)
    contact = {"restitution": choice.choice(RESTITUTIONS), "friction": choice.choice(FRICTIONS)}
    wall = contact | {"friction": choice.choice([contact["friction"], choice.choice(FRICTIONS)])}
    room = SIDE - draft.radius - 0.01
    spread = min(draft.spread, room)
    form = {
        "name": kind,
        "width": 2.0 * SIDE,
        "height": BOTTOM,
        "gravity": draft.gravity,
        "drag": draft.drag,
        "ball": {"radius": radius, **contact},
        "peg_material": contact,
        "wall_material": wall,
        "pegs": [{"x": x, "y": y, "radius": r} for x, y, r in draft.pegs],
        "walls": [
            {"x1": x1, "y1": y1, "x2": x2, "y2": y2}
            for x1, y1, x2, y2 in (
                *draft.walls, (-SIDE, -0.3, -SIDE, BOTTOM), (SIDE, -0.3, SIDE, BOTTOM),
            )
        ],
        "bins": {"y": BOTTOM, "edges": [-SIDE, -0.5, 0.0, 0.5, SIDE]},
        "drop": {"x": min(max(draft.aim, spread - room), room - spread), "jitter": spread},
    }  # fmt: skip
    return HardBoard(kind, form, tuple(draft.starts))


def _deflect(draft: Draft, lowest: float) -> None:
    """Add pegs above, from which balls arrive from all directions and with spin."""
    for _ in range(draft.choice.randint(0, 5)):
        at = draft.choice.uniform(-0.8, 0.8), draft.choice.uniform(0.3, lowest)
        peg = *at, draft.choice.choice([0.03, 0.1])
        if draft.gap_beside(*peg) > 2.0 * draft.radius + 0.01:
            draft.pegs.append(peg)


def hard_board(kind: str, number: int) -> HardBoard:
    """Board `number` of a kind."""
    return _made(kind, Random(f"{kind} {number}"))


def numbered(kind: str) -> Iterator[HardBoard]:
    """All boards of a kind, an endless iterator."""
    number = 0
    while True:
        yield hard_board(kind, number)
        number += 1


hard_boards: Final = st.builds(
    _made, st.sampled_from(sorted(KINDS)), st.randoms(use_true_random=False)
)
