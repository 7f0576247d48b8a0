"""Boards are refused for overlaps, bad starts, traps, and if a ball cannot get out."""

import copy
import math
from collections.abc import Callable
from typing import Any
from unittest import mock

import mpmath
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from plinko.engine import drop
from plinko.engine.board.checks import playable
from plinko.engine.board.checks.obstacles import Obstacles, close_discs, obstacles
from plinko.engine.board.checks.playable import fall_time
from plinko.engine.board.checks.reach import free_intervals
from plinko.engine.board.checks.separators import separators
from plinko.engine.board.model import Board
from plinko.engine.constants import KIND_WALL
from plinko.engine.drops.trajectory import at_start, follow
from plinko.engine.errors import BoardError
from plinko.engine.parameters import Exact
from tests.engine.board.forms import EXAMPLE, Form, box, changed, mirrored, wild_forms
from tests.long import tries

R = 0.1  # the ball's radius in `box`


def refusal(form: Form) -> BoardError:
    """The error that `form` raises."""
    with pytest.raises(BoardError) as caught:
        Board.from_json(form)
    return caught.value


def verdict(form: Form) -> str:
    """A keyword of the error that `form` raises; empty if it is playable."""
    try:
        Board.from_json(form)
    except BoardError as error:
        words = (
            *("overlaps", "inside or touching", "cannot pass", "miss the bins", "wedge in"),
            *("come to rest there", "even in free fall"),
        )
        return next(word for word in words if word in str(error))
    return ""


HELD, WEDGED, REST = "inside or touching", "wedge in", "come to rest there"
SHUT, MISSED = "cannot pass", "miss the bins"
SHELF = (-1.0, 3.0, 1.0, 3.0)
BESIDE = box([(-0.3, 0.15, 0.1)])
V = [(-1.0, 2.0, 0.0, 3.0), (0.0, 3.0, 1.0, 2.0)]
TRAP = [(1.75, 3.0, 0.2), (2.25, 3.0, 0.2)]
CHAMBER = [(1.0, 2.0, 3.0, 2.0), (1.0, 4.0, 3.0, 4.0), (1.0, 2.0, 1.0, 4.0), (3.0, 2.0, 3.0, 4.0)]
CUP = [(-1.0, 2.0, 1.0, 2.0), (-1.0, 2.0, -1.0, 0.05), (1.0, 2.0, 1.0, 0.05)]
LOWER = [CUP[0], (-1.0, 2.0, -1.0, 0.15), (1.0, 2.0, 1.0, 0.15)]
ROW = [(-4.0 + 0.5 * i, 3.0, 0.2) for i in range(17)]
# Each floor runs down to a gap on alternating sides; closing one closes the maze.
MAZE = [
    (-4.0, y, 3.7, y + 0.1) if i % 2 else (-3.7, y + 0.1, 4.0, y)
    for i, y in enumerate(np.arange(0.5, 5.5, 0.5).tolist())
]
ROOFS = {
    "a peg": box([(0.0, 2.0, 0.1)], [SHELF]),
    "a wall": box(walls=[SHELF, (-0.2, 1.0, 0.3, 1.2)]),
    "two walls": box(walls=[SHELF, (-0.2, 1.0, 0.0, 1.2), (0.0, 1.2, 0.3, 2.0)]),
    "an upright": box(walls=[SHELF, (0.0, 0.5, 0.0, 2.9)]),
}
ONE = box([(0.0, 3.0, 0.1)])


def pair(half: float) -> Form:
    """Two level pegs of radius 0.2 m, whose centres are twice `half` apart."""
    return box([(-half, 3.0, 0.2), (half, 3.0, 0.2)])


def tilted(more: float) -> Form:
    """Two pegs 0.45 m apart, both 0.3 m from the ball; tilted by `more` than it rolls off at."""
    tilt = math.asin(0.5 * 0.45 / 0.3) + more
    dx, dy = 0.5 * 0.45 * math.cos(tilt), 0.5 * 0.45 * math.sin(tilt)
    return box([(-dx, 3.0 - dy, 0.2), (dx, 3.0 + dy, 0.2)])


def overhang(angle: float) -> Form:
    """A wall whose left side faces left and down, and a peg `angle` left of below the ball.

    The pushes balance the weight for 0 < tan(angle) < 2; beyond straight below, the peg pushes
    the ball out, as the wall does.
    """
    x, y = -0.5 - R * 2.0 / math.sqrt(5.0), 3.0 + R / math.sqrt(5.0)
    peg = (x - 0.15 * math.sin(angle), y + 0.15 * math.cos(angle), 0.05)
    return box([peg], [(0.0, 4.0, -1.0, 2.0)])


def started(form: Form, **zone: Any) -> Form:
    return {**form, "drop": zone}


def shelf(**zone: Any) -> Form:
    return started(box(walls=[SHELF]), **zone)


def funnel(gap: float) -> Form:
    return box(walls=[(-4.0, 1.0, -0.5 * gap, 3.0), (0.5 * gap, 3.0, 4.0, 1.0)])


def fence(gap: float) -> Form:
    """Pegs at both sides in place of walls, with such gaps."""
    pitch = gap + 2 * 0.05
    count = int(7.0 / pitch) + 1
    pegs = [(s * 4.0, -0.5 + i * pitch, 0.05) for s in (-1, 1) for i in range(count)]
    return box([(0.0, 3.0, 0.1), *pegs], sides=False)


def thrown(y: float, more: float) -> Form:
    """No walls: a peg whose contact is h below the start throws no farther than 2 sqrt(6 h) m."""
    far = 0.2 + 2.0 * math.sqrt(6.0 * (y + 0.2))
    form = box([(0.0, y, 0.1)], sides=False)
    return changed(form, ("bins", "edges"), [-far - more, 0.0, far + 1e-6])


VERDICTS: list[tuple[str, Form, str]] = [
    ("a peg within a peg", box([(0.0, 3.0, 1.0), (0.1, 3.0, 0.1)]), "overlaps"),
    ("a peg in a peg's place", box([(0.0, 3.0, 0.1), (0.0, 3.0, 0.1)]), "overlaps"),
    ("pegs that touch hold a ball", box([(0.0, 3.0, 0.25), (0.5, 3.0, 0.25)]), WEDGED),
    ("not one above the other", box([(0.5, 3.0, 0.25), (0.5, 3.5, 0.25)]), ""),
    ("pegs half within walls", box([(-4.0, 3.0, 0.2), (4.0, 3.0, 0.2)]), ""),
    ("a wall beside the start", box(walls=[(0.5, -0.5, 0.6, 0.5)]), ""),
    ("a start that touches", box([(0.0, R + 0.3, 0.3)]), HELD),
    ("a start a micrometre away", box([(0.0, R + 0.3 + 1e-6, 0.3)]), ""),
    ("a peg beside the start", BESIDE, ""),
    ("within the jitter", started(BESIDE, jitter=0.2), HELD),
    ("well within the jitter", started(BESIDE, jitter=1.0), HELD),
    ("beside, mirrored", mirrored(BESIDE), ""),
    ("within the jitter, mirrored", started(mirrored(BESIDE), jitter=0.2), HELD),
    ("well within the jitter, mirrored", started(mirrored(BESIDE), jitter=1.0), HELD),
    ("a ball that fits between pegs", pair(R + 1e-6 + 0.2), ""),
    ("a pair not steep enough", tilted(-0.05), WEDGED),
    ("a pair off which the ball rolls", tilted(0.05), ""),
    ("a peg so far from a wall", box([(-4.0 + R + 0.01, 3.0, 0.05)]), WEDGED),
    ("so close leads the ball away", box([(-4.0 + R - 0.01, 3.0, 0.05)]), ""),
    ("passing a peg and a wall", box([(-4.0 + 0.1 + 2 * R + 1e-6, 3.0, 0.1)]), ""),
    ("a roof of two walls", box(walls=[(x1, 5 - y1, x2, 5 - y2) for x1, y1, x2, y2 in V]), ""),
    *(
        (
            f"ends of walls {half} from the middle",
            box(walls=[(-1.0, 2.0, -half, 3.0), (half, 3.0, 1.0, 2.0)]),
            answer,
        )
        for half, answer in ((R - 0.001, WEDGED), (R + 0.001, ""))
    ),
    ("an overhang, pushed out", overhang(-0.3), ""),
    ("an overhang, pushed out a little", overhang(-0.1), ""),
    ("an overhang, pushed in a little", overhang(0.1), WEDGED),
    ("an overhang, pushed in", overhang(1.05), WEDGED),
    ("balance on a level wall", box(walls=[(1.0, 3.0, 2.0, 3.0)]), ""),
    ("balance on a level wall to the side", box(walls=[(1.0, 3.0, 4.0, 3.0)]), ""),
    *(
        (f"out of reach at {x}, {y}", box([(x - 0.25, y, 0.2), (x + 0.25, y, 0.2)]), "")
        for x, y in ((-6.0, 3.0), (0.0, 7.0), (0.0, -1.0))
    ),
    ("a trap in a closed chamber", box(TRAP, CHAMBER), ""),
    ("a trap in an open chamber", box(TRAP, CHAMBER[1:]), WEDGED),
    *(
        (f"a wall that rises by {rise}", box(walls=[(-1.0, 3.0, 1.0, 3.0 + rise)]), "")
        for rise in (1e-6, -0.01, 0.5)
    ),
    *(
        (f"level but for rounding to {x}, {y}", box(walls=[(1e-9, 3.0, x, y)]), answer)
        for x, y, answer in ((3.0, 3.0 + 1e-12, ""), (-1.0, 3.0, REST), (3.0, 3.0, ""))
    ),
    *(
        (
            f"level but for rounding to {x}, {y}, with jitter",
            started(box(walls=[(1.0, 3.0, x, y)]), x=0.5, jitter=0.6),
            REST,
        )
        for x, y in ((3.0, 3.0 + 1e-12), (-1.0, 3.0), (3.0, 3.0))
    ),
    ("a start before the end of a shelf", shelf(x=1.0 - 1e-6), REST),
    ("a start beside it", shelf(x=1.0 + 1e-6), ""),
    ("jitter beside a shelf", shelf(x=2.0, jitter=0.9), ""),
    ("jitter over a shelf", shelf(x=2.0, jitter=1.1), REST),
    ("reach over a shelf", shelf(x=2.0, jitter=0.9, reach=1.1), REST),
    ("slots beside a shelf", shelf(x=2.0, slots=[1.5, 3.0]), ""),
    ("a slot over a shelf", shelf(x=2.0, slots=[1.5, 0.5]), REST),
    *((f"a roof of {name}", started(roof, jitter=0.05), "") for name, roof in ROOFS.items()),
    *((f"more than {name}", started(roof, jitter=0.5), REST) for name, roof in ROOFS.items()),
    ("as far as the ball is wide", started(ROOFS["a peg"], jitter=0.1 + R), ""),
    ("a little farther", started(ROOFS["a peg"], jitter=0.1 + R + 1e-6), REST),
    (
        "what is above the start covers nothing",
        box([(0.0, -1.0, 0.1)], [SHELF, (-1.0, -0.5, 1.0, -0.6)]),
        REST,
    ),
    (
        "level above the start or below the bins",
        box(walls=[(-1.0, -1.0, 1.0, -1.0), (-1.0, 6.1, 1.0, 6.1)]),
        "",
    ),
    ("a slit narrower than the ball", funnel(2 * R - 1e-6), SHUT),
    ("a slit wider than the ball", funnel(2 * R + 1e-6), ""),
    ("a row from wall to wall", box(ROW), SHUT),
    ("a row that a small ball passes", box(ROW, radius=0.04), ""),
    ("a hole beside a floor", box(walls=[(-4.0, 2.9, 4.0 - 2.1 * R, 3.0)]), ""),
    ("a narrow hole beside a floor", box(walls=[(-4.0, 2.9, 4.0 - 1.9 * R, 3.0)]), SHUT),
    ("a way that leads above the start", box(walls=CUP), SHUT),
    ("a cup that a ball bounces out of", box(walls=LOWER), REST),
    ("a maze", box(walls=MAZE), ""),
    ("a closed maze", box(walls=[*MAZE[:-1], (-4.0, 5.1, 4.0, 5.1)]), SHUT),
    ("a wall almost down to the bins", changed(ONE, ("walls", 1, "y2"), 5.95), ""),
    ("a wall that ends above them", changed(ONE, ("walls", 1, "y2"), 5.5), MISSED),
    ("a wall almost up to the start", changed(ONE, ("walls", 0, "y1"), 0.05), ""),
    ("a wall that begins below it", changed(ONE, ("walls", 0, "y1"), 2.0), MISSED),
    *(
        (
            f"a gap of {gap} in a wall",
            changed(
                box([(0.0, 1.0, 0.1)], [(-4.0, 3.0 + gap, -4.0, 6.0)]), ("walls", 0, "y2"), 3.0
            ),
            answer,
        )
        for gap, answer in ((2 * R - 0.001, ""), (2 * R + 0.001, MISSED))
    ),
    ("a fence dense enough", fence(2 * R - 0.001), ""),
    ("a fence that a ball gets through", fence(2 * R + 0.001), MISSED),
    ("no walls, straight down", box(sides=False), ""),
    ("no walls, beside the bins", started(box(sides=False), x=3.0, jitter=1.5), MISSED),
    *((f"as far as {y} m throws", thrown(y, 1e-6), "") for y in (0.3, 0.4, 0.5)),
    *((f"farther than {y} m throws", thrown(y, -1e-3), MISSED) for y in (0.3, 0.4, 0.5)),
    ("the example, without a right wall", EXAMPLE, ""),
    ("with bins too narrow", changed(EXAMPLE, ("bins", "edges"), [-4.0, -3.5, 3.5]), MISSED),
]


@pytest.mark.parametrize(
    ("form", "answer"), [pytest.param(form, answer, id=name) for name, form, answer in VERDICTS]
)
def test_a_board_is_refused_exactly_if_it_is_unplayable(form: Form, answer: str) -> None:
    assert verdict(form) == answer


STARTS = box(walls=[(0.5, -0.5, 0.6, 0.5)])
HEIGHT = math.sqrt(0.3**2 - 0.25**2)
HALVES = [(-0.25, 3.0, 0.2), (0.25, 3.0, 0.2)]
NAMED: list[tuple[str, Form, str, str]] = [
    (
        "both pegs that overlap",
        box([(-2.0, 3.0, 0.2), (1.0, 3.0, 0.2), (1.3, 3.0, 0.2)]),
        "pegs[2]",
        "pegs[2] at (1.3, 3.0) overlaps pegs[1] at (1.0, 3.0).*at least 0.4 m apart",
    ),
    (
        "a start inside a peg",
        box([(0.0, 0.05, 0.2)]),
        "drop",
        "drop.x = 0.0 with drop.jitter = 0.0 at drop.y = 0.0.*pegs[0]",
    ),
    ("jitter across a wall", started(STARTS, jitter=1.0), "drop", "walls[2]:"),
    ("the end of a wall", box(walls=[(0.05, 0.0, 2.0, 2.0)]), "drop", "walls[2]'s first end"),
    ("a start on a wall", box(walls=[(-1.0, 0.05, 1.0, 0.05)]), "drop", "walls[2]:"),
    ("a start at a side wall", started(box(), x=-3.95), "drop", "walls[0]:"),
    (
        "a slot inside a peg",
        started(box([(2.0, 0.0, 0.1)]), slots=[0.0, 1.9]),
        "drop.slots[1]",
        "drop.slots[1] = 1.9",
    ),
    *(
        (
            f"a start at {y}, not above the bins",
            started(box(), y=y),
            "drop.y",
            f"drop.y is {y}: the start must be above the bins",
        )
        for y in (6.0, 6.5)
    ),
    *(
        (f"pegs {gap} apart", pair(0.5 * gap + 0.2), "pegs[0]", "gap between pegs[0] and pegs[1]")
        for gap in (0.01, R, 2 * R - 1e-6)
    ),
    ("where the ball rests", box(HALVES), "pegs[0]", f"at (0, {3.0 - HEIGHT:.6g})"),
    ("a third peg in the gap", box([*HALVES, (0.0, 2.84, 0.05)]), "pegs[1]", "and pegs[2]: "),
    ("a peg beside a wall", box([(-3.75, 3.0, 0.1)]), "pegs[0]", "between pegs[0] and walls[0]"),
    ("walls that meet in a V", box(walls=V), "walls[2]", "walls[2] and walls[3]"),
    (
        "a level wall under the start",
        box([(3.0, 3.0, 0.1)], [(-3.0, 2.0, -2.0, 2.0), SHELF]),
        "walls[3]",
        "walls[3] is level: a ball that starts above it, at x = 0, can come to rest",
    ),
    (
        "the ball's diameter",
        box(walls=[(-4.0, 3.0, 4.0, 3.0)]),
        "ball.radius",
        "the ball (diameter 0.2 m) cannot pass",
    ),
    (
        "a slot over a closed shaft",
        started(box(walls=[(2.0, -1.0, 2.0, 3.0), (2.0, 3.0, 4.0, 3.0)]), slots=[0.0, 3.0]),
        "ball.radius",
        "cannot pass from drop.slots[1] = 3.0",
    ),
    ("a ball too small to check", box(radius=0.001), "ball.radius", "too small for a board of"),
    *(
        (
            f"the bin's edge {edges[index]}, not at the wall",
            changed(ONE, ("bins", "edges"), edges),
            f"bins.edges[{index}]",
            f"bins.edges[{index}] is {edges[index]}: a ball can miss the bins",
        )
        for edges, index in (([-3.0, 0.0, 4.0], 0), ([-4.0, 0.0, 3.0], 2))
    ),
]


@pytest.mark.parametrize(
    ("form", "field", "said"), [pytest.param(*row, id=name) for name, *row in NAMED]
)
def test_the_error_names_what_makes_a_board_unplayable(form: Form, field: str, said: str) -> None:
    error = refusal(form)
    assert error.field == field
    first, _, last = said.partition(".*")
    assert first in str(error)
    assert last in str(error)


class TestShelves:
    # Most wild forms have another fault; which ones come depends on the modules that are loaded.
    @settings(
        max_examples=tries(25, 1000),
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
    )
    @given(wild_forms(), st.floats(0.5, 5.5), st.floats(-3.0, 3.0), st.floats(0.0, 2.0))
    def test_a_level_wall_is_refused_if_a_ball_hits_it_first(
        self, form: Form, y: float, x: float, jitter: float
    ) -> None:
        """The board is refused exactly if some ball hits the top of the level wall first."""
        form = copy.deepcopy(form)
        form["walls"].append({"x1": -1.0, "y1": y, "x2": 1.0, "y2": y})
        form |= {"drop": {"x": x, "jitter": jitter}, "bins": {"y": 6.0, "edges": [-99.0, 99.0]}}
        assume(verdict(form) in {"", "come to rest there"})
        with mock.patch.object(playable, "check"):
            board = Board.from_json(form)
        level = len(board.walls) - 1
        direct = 0
        for start in np.linspace(x - jitter, x + jitter, 41)[1:-1].tolist():
            first = follow(board, at_start(board, start), Exact(), max_events=1)
            on_top = first.marks.tolist()[0] == [KIND_WALL, level] and abs(start) < 1.0 - 1e-9
            direct += on_top and first.events[0, 2] < y
        if verdict(form) == "":
            assert direct == 0
        elif direct == 0:  # such a start exists between those that were tried
            told = str(refusal(form))
            at = told.split("at x = ")[1].split(",", maxsplit=1)[0]
            # Another wall may be level as well.
            named = int(told.split("walls[")[1].split("]", maxsplit=1)[0])
            first = follow(board, at_start(board, float(at)), Exact(), max_events=1)
            # The ball may touch a peg at the same instant, and that impact is listed first.
            rest = board.walls[named].y1 - board.ball.radius
            at_rest = first.events[0, 2] == pytest.approx(rest, rel=0.0, abs=1e-9)
            assert first.marks.tolist()[0] == [KIND_WALL, named] or at_rest

    def test_a_board_that_was_kept_before_is_not_refused(self) -> None:
        form = box(walls=[SHELF])
        kept = Board.kept(form)
        assert kept.to_dict() == Board.kept(kept.to_dict()).to_dict()
        with pytest.raises(BoardError, match="gravity"):
            Board.kept({**form, "gravity": -1.0})
        with pytest.raises(BoardError, match="level"):
            Board.of(kept)


class TestTime:
    @pytest.mark.parametrize(
        ("gravity", "drag", "field", "least"),
        [
            (1e-6, 0.0, "gravity", "3464.1 s"),
            (1.19e-5, 0.0, "gravity", "1004.19 s"),
            (1e-6, 1000.0, "gravity", "6e+09 s"),
            (5.0, 1000.0, "drag", "1200 s"),
        ],
    )
    def test_a_board_on_which_no_ball_lands_in_time_is_refused(
        self, gravity: float, drag: float, field: str, least: str
    ) -> None:
        error = refusal({**box(), "gravity": gravity, "drag": drag})
        assert error.field == field
        value = {"gravity": gravity, "drag": drag}[field]
        assert str(error) == (
            f"{field} is {value!r}: even in free fall a ball takes {least} from drop.y = 0.0 to "
            "bins.y = 6.0, and a drop ends after 1000 s"
        )

    def test_a_board_on_which_a_ball_lands_in_time_is_fine(self) -> None:
        for values in ({"gravity": 1.21e-5}, {"gravity": 6.1, "drag": 1000.0}, {"drag": 1000.0}):
            board = Board.from_json({**box(), **values})
            assert drop(board, 1).unsettled is None or board.drag > 0.0, values

    @pytest.mark.parametrize("drag", [0.0, 1e-300, 1e-9, 1e-3, 0.1, 1.0, 10.0])
    @pytest.mark.parametrize("gravity", [1e-6, 0.01, 9.81, 1e4])
    def test_the_least_time_is_that_of_the_closed_form(self, gravity: float, drag: float) -> None:
        with mpmath.workdps(1000):
            g, k = mpmath.mpf(gravity), mpmath.mpf(drag)
            for way in (1e-9, 1.0, 6.0, 1e6):
                t = mpmath.mpf(fall_time(gravity, drag, way))
                fallen = g / k * (t - (1 - mpmath.exp(-k * t)) / k) if drag else g * t * t / 2
                assert abs(fallen / way - 1) < 1e-8


@pytest.mark.parametrize("excess", [0.0, 5e-10, -5e-10])
@pytest.mark.parametrize(
    "gap",
    [
        lambda gap: box([(-0.5 - 0.5 * gap, 3.0, 0.5), (0.5 + 0.5 * gap, 3.0, 0.5)]),
        lambda gap: box([(0.0, 3.0, 0.5), (0.0, 4.0 + gap, 0.5)]),
        lambda gap: box([(4.0 - 0.5 - gap, 3.0, 0.5)]),
        lambda gap: box(walls=[(-1.0, 2.0, -1.0, 4.0), (-1.0 + gap, 3.0, -1.0 + gap, 5.0)]),
    ],
    ids=["pegs", "pegs above each other", "peg and wall", "walls"],
)
def test_a_gap_as_wide_as_the_ball_is_refused(gap: Callable[[float], Form], excess: float) -> None:
    """Rounding would decide whether the ball wedges there."""
    assert verdict(gap(2.0 * R * (1.0 + excess))) == "wedge in"
    assert verdict(gap(2.0 * R * (1.0 + 1e-6))) == ""


@given(wild_forms())
def test_a_mirrored_board_is_as_good_as_the_board(form: Form) -> None:
    assert verdict(mirrored(form)) == verdict(form)


@given(wild_forms())
def test_the_order_of_pegs_and_walls_does_not_change_the_verdict(form: Form) -> None:
    turned = {**form, "pegs": form["pegs"][::-1], "walls": form["walls"][::-1]}
    assert verdict(turned) == verdict(form)


@given(wild_forms())
def test_separators_lie_wholly_where_no_ball_can_be(form: Form) -> None:
    obs = _obstacles(form)
    lines = separators(obs, close_discs(obs), 0.0, 6.0)
    for s in np.linspace(0.0, 1.0, 21):
        x = lines[:, 0] + s * (lines[:, 2] - lines[:, 0])
        y = lines[:, 1] + s * (lines[:, 3] - lines[:, 1])
        inside = (y > 0.0) & (y < 6.0)
        assert not _free(obs, x[inside], y[inside], 1.0 - 1e-9).any()


@given(wild_forms(), st.floats(0.1, 5.9))
def test_free_intervals_are_those_of_dense_sampling(form: Form, y: float) -> None:
    obs = _obstacles(form)
    intervals = free_intervals(obs, y)
    x = np.linspace(-7.0, 7.0, 2001)
    claimed = ((x[:, None] > intervals[:, 0]) & (x[:, None] < intervals[:, 1])).any(axis=1)
    ends = np.concatenate((intervals[1:, 0], intervals[:-1, 1]))
    clear = np.abs(x[:, None] - ends).min(axis=1, initial=1.0) > 1e-6
    assert (claimed == _free(obs, x, np.full_like(x, y), 1.0))[clear].all()


@given(wild_forms())
@settings(max_examples=tries(15, 200))
def test_a_ball_passes_exactly_if_dense_sampling_finds_a_way(form: Form) -> None:
    answer = verdict(form)
    assume(answer != "inside or touching")
    obs = _obstacles(form)
    # Skip ways that the margin of 5 % decides; all others are wider than the sampling.
    x, y = np.meshgrid(np.arange(-6.0, 6.0, 0.02), np.linspace(0.0, 6.0, 301))
    surely, perhaps = (_passes(_free(obs, x, y, scale), x) for scale in (1.05, 0.95))
    assume(surely == perhaps)
    assert (answer != "cannot pass") == surely


def _obstacles(form: Form) -> Obstacles:
    """The obstacles of `form`, even if it is not a valid board."""
    parts: dict[str, Any] = dict(form)
    board = Board.from_json({**parts, "pegs": [], "walls": []})
    pegs = [type("P", (), peg)() for peg in form["pegs"]]
    walls = [type("W", (), wall)() for wall in form["walls"]]
    stand_in = type("B", (), {"ball": board.ball, "pegs": pegs, "walls": walls})()
    return obstacles(stand_in)


def _free(obs: Obstacles, x: Any, y: Any, scale: float) -> Any:
    """Whether a ball at (x, y) overlaps nothing, with all reaches multiplied by `scale`."""
    free = np.ones(np.shape(x), dtype=np.bool_)
    for cx, cy, reach in zip(obs.x, obs.y, obs.reach * scale, strict=True):
        free &= (x - cx) ** 2 + (y - cy) ** 2 > reach * reach
    for k in range(len(obs.length)):
        dx, dy = x - obs.x1[k], y - obs.y1[k]
        along = dx * obs.tx[k] + dy * obs.ty[k]
        across = np.abs(dy * obs.tx[k] - dx * obs.ty[k])
        free &= (along < 0) | (along > obs.length[k]) | (across > obs.radius * scale)
    return free


def _passes(free: Any, x: Any) -> bool:
    """Whether a way leads from the start, x = 0 in the first row, to the last row."""
    reached = np.zeros_like(free)
    reached[0, np.abs(x[0]).argmin()] = True
    while True:
        before = int(reached.sum())
        for rows in (range(1, len(free)), range(len(free) - 2, -1, -1)):
            step = -1 if rows.step > 0 else 1
            for row in rows:
                reached[row] |= reached[row + step] & free[row]
                reached[row] = _spread(reached[row], free[row])
        if int(reached.sum()) == before:
            return bool(reached[-1].any())


def _spread(reached: Any, free: Any) -> Any:
    """Mark the whole of each free run in a row if any part of it is reached."""
    runs = np.cumsum(~free)
    return free & np.isin(runs, runs[reached & free])


@pytest.mark.parametrize("radius", [0.02, 0.03])
def test_the_wedges_of_ten_thousand_pegs_are_found(radius: float) -> None:
    pegs = [
        (-3.96 + 0.08 * i + 0.02 * (j % 2), 0.5 + 0.05 * j, 0.005)
        for j in range(100)
        for i in range(100)
    ]
    assert verdict(box(pegs, radius=radius)) == "wedge in"


def test_a_heap_of_tiny_pegs_is_refused_and_not_computed_forever() -> None:
    pegs = [(0.01 * i - 0.75, 3.0 + 0.01 * j, 0.004) for i in range(141) for j in range(141)]
    error = refusal(box(pegs, radius=0.5))
    assert error.field == "pegs"
    assert "too close together" in str(error)
