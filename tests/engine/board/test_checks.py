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


class TestOverlap:
    def test_overlapping_pegs_are_named_both(self) -> None:
        error = refusal(box([(-2.0, 3.0, 0.2), (1.0, 3.0, 0.2), (1.3, 3.0, 0.2)]))
        assert error.field == "pegs[2]"
        assert "pegs[2] at (1.3, 3.0) overlaps pegs[1] at (1.0, 3.0)" in str(error)
        assert "at least 0.4 m apart" in str(error)

    def test_a_peg_within_a_peg_overlaps(self) -> None:
        assert verdict(box([(0.0, 3.0, 1.0), (0.1, 3.0, 0.1)])) == "overlaps"
        assert verdict(box([(0.0, 3.0, 0.1), (0.0, 3.0, 0.1)])) == "overlaps"

    def test_pegs_that_touch_do_not_overlap_but_hold_a_ball(self) -> None:
        assert verdict(box([(0.0, 3.0, 0.25), (0.5, 3.0, 0.25)])) == "wedge in"

    def test_pegs_that_touch_one_above_the_other_are_fine(self) -> None:
        assert verdict(box([(0.5, 3.0, 0.25), (0.5, 3.5, 0.25)])) == ""

    def test_pegs_may_be_half_within_a_wall(self) -> None:
        assert verdict(box([(-4.0, 3.0, 0.2), (4.0, 3.0, 0.2)])) == ""


class TestStart:
    def test_a_start_inside_a_peg_is_refused(self) -> None:
        error = refusal(box([(0.0, 0.05, 0.2)]))
        assert error.field == "drop"
        assert "drop.x = 0.0 with drop.jitter = 0.0 at drop.y = 0.0" in str(error)
        assert "pegs[0]" in str(error)

    @pytest.mark.parametrize(("gap", "answer"), [(0.0, "inside or touching"), (1e-6, "")])
    def test_touching_is_refused_and_a_micrometre_is_not(self, gap: float, answer: str) -> None:
        assert verdict(box([(0.0, R + 0.3 + gap, 0.3)])) == answer

    @pytest.mark.parametrize("side", [-1.0, 1.0])
    def test_the_whole_jitter_counts_not_only_its_ends(self, side: float) -> None:
        form = box([(side * 0.3, 0.15, 0.1)])
        assert verdict(form) == ""
        assert verdict({**form, "drop": {"jitter": 0.2}}) == "inside or touching"
        assert verdict({**form, "drop": {"jitter": 1.0}}) == "inside or touching"

    def test_a_start_on_a_wall_its_end_or_across_it_is_refused(self) -> None:
        across = box(walls=[(0.5, -0.5, 0.6, 0.5)])
        assert verdict(across) == ""
        error = refusal({**across, "drop": {"jitter": 1.0}})
        assert "walls[2]:" in str(error)
        assert "walls[2]'s first end" in str(refusal(box(walls=[(0.05, 0.0, 2.0, 2.0)])))
        assert "walls[2]:" in str(refusal(box(walls=[(-1.0, 0.05, 1.0, 0.05)])))
        assert "walls[0]:" in str(refusal({**box(), "drop": {"x": -3.95}}))

    def test_every_slot_counts(self) -> None:
        error = refusal({**box([(2.0, 0.0, 0.1)]), "drop": {"slots": [0.0, 1.9]}})
        assert error.field == "drop.slots[1]"
        assert "drop.slots[1] = 1.9" in str(error)

    @pytest.mark.parametrize("y", [6.0, 6.5])
    def test_a_start_must_be_above_the_bins(self, y: float) -> None:
        error = refusal({**box(), "drop": {"y": y}})
        assert error.field == "drop.y"
        assert f"drop.y is {y}: the start must be above the bins" in str(error)


class TestTraps:
    @pytest.mark.parametrize("gap", [0.01, R, 2 * R - 1e-6])
    def test_two_pegs_hold_a_ball_that_does_not_fit_between(self, gap: float) -> None:
        half = 0.5 * gap + 0.2
        error = refusal(box([(-half, 3.0, 0.2), (half, 3.0, 0.2)]))
        assert error.field == "pegs[0]"
        assert "the gap between pegs[0] and pegs[1]" in str(error)

    def test_two_pegs_let_a_ball_through_that_fits(self) -> None:
        half = R + 1e-6 + 0.2
        assert verdict(box([(-half, 3.0, 0.2), (half, 3.0, 0.2)])) == ""

    def test_the_trapped_ball_touches_both_pegs_and_rests_on_them(self) -> None:
        error = str(refusal(box([(-0.25, 3.0, 0.2), (0.25, 3.0, 0.2)])))
        height = math.sqrt(0.3**2 - 0.25**2)
        assert f"at (0, {3.0 - height:.6g})" in error

    def test_a_steep_pair_is_no_trap_as_the_ball_rolls_off_below(self) -> None:
        apart = 0.45  # between the pegs; the ball, 0.3 from both, does not fit between them
        touching = 0.3
        lean = math.asin(
            0.5 * apart / touching
        )  # angle of the ball's centre from the pair's middle line
        for tilt, answer in ((lean - 0.05, "wedge in"), (lean + 0.05, "")):
            dx, dy = 0.5 * apart * math.cos(tilt), 0.5 * apart * math.sin(tilt)
            assert verdict(box([(-dx, 3.0 - dy, 0.2), (dx, 3.0 + dy, 0.2)])) == answer

    def test_a_third_peg_in_the_gap_is_what_the_ball_rests_against(self) -> None:
        pair = [(-0.25, 3.0, 0.2), (0.25, 3.0, 0.2)]
        assert "pegs[0] and pegs[1]" in str(refusal(box(pair)))
        error = str(refusal(box([*pair, (0.0, 2.84, 0.05)])))
        assert "pegs[0] and pegs[1]" not in error
        assert "and pegs[2]: " in error

    def test_a_peg_beside_an_upright_wall_holds_a_ball(self) -> None:
        error = refusal(box([(-3.75, 3.0, 0.1)]))
        assert "the gap between pegs[0] and walls[0]" in str(error)
        assert verdict(box([(-4.0 + 0.1 + 2 * R + 1e-6, 3.0, 0.1)])) == ""

    def test_a_peg_close_to_an_upright_wall_leads_the_ball_away(self) -> None:
        assert verdict(box([(-4.0 + R + 0.01, 3.0, 0.05)])) == "wedge in"
        assert verdict(box([(-4.0 + R - 0.01, 3.0, 0.05)])) == ""

    def test_walls_that_meet_in_a_v_hold_a_ball(self) -> None:
        v = [(-1.0, 2.0, 0.0, 3.0), (0.0, 3.0, 1.0, 2.0)]
        error = refusal(box(walls=v))
        assert error.field == "walls[2]"
        assert "walls[2] and walls[3]" in str(error)
        assert verdict(box(walls=[(x1, 5 - y1, x2, 5 - y2) for x1, y1, x2, y2 in v])) == ""

    def test_two_walls_ends_hold_a_ball_that_does_not_fit_between(self) -> None:
        for half, answer in ((R - 0.001, "wedge in"), (R + 0.001, "")):
            v = [(-1.0, 2.0, -half, 3.0), (half, 3.0, 1.0, 2.0)]
            assert verdict(box(walls=v)) == answer

    @pytest.mark.parametrize(
        ("angle", "answer"), [(-0.3, ""), (-0.1, ""), (0.1, "wedge in"), (1.05, "wedge in")]
    )
    def test_an_overhang_holds_a_ball_on_a_peg_that_pushes_it_there(
        self, angle: float, answer: str
    ) -> None:
        # The wall's left side faces left and down, (-2, 1) / sqrt 5; the peg is `angle` left of
        # straight below the ball. The pushes balance the weight for 0 < tan(angle) < 2; beyond
        # straight below, the peg pushes the ball out, as the wall does.
        overhang = (0.0, 4.0, -1.0, 2.0)
        x, y = -0.5 - R * 2.0 / math.sqrt(5.0), 3.0 + R / math.sqrt(5.0)
        peg = (x - 0.15 * math.sin(angle), y + 0.15 * math.cos(angle), 0.05)
        assert verdict(box([peg], [overhang])) == answer

    def test_balance_on_a_level_wall_is_no_trap(self) -> None:
        assert verdict(box(walls=[(1.0, 3.0, 2.0, 3.0)])) == ""
        assert verdict(box(walls=[(1.0, 3.0, 4.0, 3.0)])) == ""

    def test_a_trap_that_no_ball_can_reach_does_not_matter(self) -> None:
        for x, y in ((-6.0, 3.0), (0.0, 7.0), (0.0, -1.0)):
            assert verdict(box([(x - 0.25, y, 0.2), (x + 0.25, y, 0.2)])) == ""

    def test_a_trap_in_a_closed_chamber_does_not_matter(self) -> None:
        chamber = [
            (1.0, 2.0, 3.0, 2.0),
            (1.0, 4.0, 3.0, 4.0),
            (1.0, 2.0, 1.0, 4.0),
            (3.0, 2.0, 3.0, 4.0),
        ]
        trap = [(1.75, 3.0, 0.2), (2.25, 3.0, 0.2)]
        assert verdict(box(trap, chamber)) == ""
        assert verdict(box(trap, chamber[1:])) == "wedge in"


SHELF = [(-1.0, 3.0, 1.0, 3.0)]


class TestShelves:
    def test_a_level_wall_under_the_start_is_named(self) -> None:
        error = refusal(box([(3.0, 3.0, 0.1)], [(-3.0, 2.0, -2.0, 2.0), *SHELF]))
        assert error.field == "walls[3]"
        assert "walls[3] is level: a ball that starts above it, at x = 0, can come to rest" in str(
            error
        )

    @pytest.mark.parametrize("rise", [1e-6, -0.01, 0.5])
    def test_a_sloping_wall_is_no_level_wall(self, rise: float) -> None:
        assert verdict(box(walls=[(-1.0, 3.0, 1.0, 3.0 + rise)])) == ""

    @pytest.mark.parametrize("end", [(3.0, 3.0 + 1e-12), (-1.0, 3.0), (3.0, 3.0)])
    def test_a_wall_that_is_level_but_for_rounding_is_level(self, end: tuple[float, float]) -> None:
        assert verdict(box(walls=[(1e-9, 3.0, *end)])) == (
            "come to rest there" if end[0] < 0.0 else ""
        )
        assert verdict({**box(walls=[(1.0, 3.0, *end)]), "drop": {"x": 0.5, "jitter": 0.6}}) == (
            "come to rest there"
        )

    @pytest.mark.parametrize(
        ("x", "answer"), [(1.0 - 1e-6, "come to rest there"), (1.0 + 1e-6, "")]
    )
    def test_a_start_beside_its_end_rolls_off(self, x: float, answer: str) -> None:
        assert verdict({**box(walls=SHELF), "drop": {"x": x}}) == answer

    def test_every_start_counts_those_of_jitter_reach_and_slots(self) -> None:
        away = box(walls=SHELF)
        for zone, answer in (
            ({"x": 2.0, "jitter": 0.9}, ""),
            ({"x": 2.0, "jitter": 1.1}, "come to rest there"),
            ({"x": 2.0, "jitter": 0.9, "reach": 1.1}, "come to rest there"),
            ({"x": 2.0, "slots": [1.5, 3.0]}, ""),
            ({"x": 2.0, "slots": [1.5, 0.5]}, "come to rest there"),
        ):
            assert verdict({**away, "drop": zone}) == answer

    def test_a_level_wall_onto_which_no_ball_falls_is_fine(self) -> None:
        for roof in (
            box([(0.0, 2.0, 0.1)], SHELF),
            box(walls=[*SHELF, (-0.2, 1.0, 0.3, 1.2)]),
            box(walls=[*SHELF, (-0.2, 1.0, 0.0, 1.2), (0.0, 1.2, 0.3, 2.0)]),
            box(walls=[*SHELF, (0.0, 0.5, 0.0, 2.9)]),
        ):
            assert verdict({**roof, "drop": {"jitter": 0.05}}) == ""
            assert verdict({**roof, "drop": {"jitter": 0.5}}) == "come to rest there"

    def test_a_roof_covers_it_as_far_as_the_ball_is_wide(self) -> None:
        form = box([(0.0, 2.0, 0.1)], SHELF)
        assert verdict({**form, "drop": {"jitter": 0.1 + R}}) == ""
        assert verdict({**form, "drop": {"jitter": 0.1 + R + 1e-6}}) == "come to rest there"

    def test_what_is_above_the_start_covers_nothing(self) -> None:
        assert verdict(box([(0.0, -1.0, 0.1)], [*SHELF, (-1.0, -0.5, 1.0, -0.6)])) == (
            "come to rest there"
        )

    def test_a_level_wall_above_the_start_or_below_bins_is_fine(self) -> None:
        assert verdict(box(walls=[(-1.0, -1.0, 1.0, -1.0), (-1.0, 6.1, 1.0, 6.1)])) == ""

    # Most wild forms have another fault; which ones come depends on the modules that are loaded.
    @settings(
        max_examples=tries(50, 1000),
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
        form = box(walls=SHELF)
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
    @pytest.mark.parametrize("way", [1e-9, 1.0, 6.0, 1e6])
    def test_the_least_time_is_that_of_the_closed_form(
        self, gravity: float, drag: float, way: float
    ) -> None:
        with mpmath.workdps(1000):
            g, k, t = (
                mpmath.mpf(gravity),
                mpmath.mpf(drag),
                mpmath.mpf(fall_time(gravity, drag, way)),
            )
            fallen = g / k * (t - (1 - mpmath.exp(-k * t)) / k) if drag else g * t * t / 2
            assert abs(fallen / way - 1) < 1e-8


class TestPassing:
    @pytest.mark.parametrize(("gap", "answer"), [(2 * R - 1e-6, "cannot pass"), (2 * R + 1e-6, "")])
    def test_a_slit_is_open_exactly_if_it_is_wider_than_the_ball(
        self, gap: float, answer: str
    ) -> None:
        funnel = [(-4.0, 1.0, -0.5 * gap, 3.0), (0.5 * gap, 3.0, 4.0, 1.0)]
        assert verdict(box(walls=funnel)) == answer

    def test_the_error_names_the_balls_diameter(self) -> None:
        error = refusal(box(walls=[(-4.0, 3.0, 4.0, 3.0)]))
        assert error.field == "ball.radius"
        assert "the ball (diameter 0.2 m) cannot pass" in str(error)

    def test_a_row_of_pegs_from_wall_to_wall_stops_a_ball(self) -> None:
        row = [(-4.0 + 0.5 * i, 3.0, 0.2) for i in range(17)]
        assert verdict(box(row)) == "cannot pass"
        assert verdict(box(row, radius=0.04)) == ""

    def test_a_floor_with_a_hole_beside_it_is_passable(self) -> None:
        assert verdict(box(walls=[(-4.0, 2.9, 4.0 - 2.1 * R, 3.0)])) == ""
        assert verdict(box(walls=[(-4.0, 2.9, 4.0 - 1.9 * R, 3.0)])) == "cannot pass"

    def test_a_way_that_leads_above_the_start_is_no_way(self) -> None:
        cup = [(-1.0, 2.0, 1.0, 2.0), (-1.0, 2.0, -1.0, 0.05), (1.0, 2.0, 1.0, 0.05)]
        assert verdict(box(walls=cup)) == "cannot pass"
        lower = [(x1, y1, x2, y2 if y2 == 2.0 else 0.15) for x1, y1, x2, y2 in cup]
        assert verdict(box(walls=lower)) == "come to rest there"

    def test_a_slot_over_a_closed_shaft_is_named(self) -> None:
        shaft = [(2.0, -1.0, 2.0, 3.0), (2.0, 3.0, 4.0, 3.0)]
        error = refusal({**box(walls=shaft), "drop": {"slots": [0.0, 3.0]}})
        assert "cannot pass from drop.slots[1] = 3.0" in str(error)

    def test_a_maze_is_followed_to_its_end(self) -> None:
        floors = [
            (-4.0, y, 3.7, y + 0.1) if i % 2 else (-3.7, y + 0.1, 4.0, y)
            for i, y in enumerate(np.arange(0.5, 5.5, 0.5).tolist())
        ]
        # Each floor runs down to a gap on alternating sides; closing one closes the maze.
        assert verdict(box(walls=floors)) == ""
        closed = [*floors[:-1], (-4.0, 5.1, 4.0, 5.1)]
        assert verdict(box(walls=closed)) == "cannot pass"

    def test_a_ball_too_small_to_check_the_way_of_is_refused(self) -> None:
        error = refusal(box(radius=0.001))
        assert error.field == "ball.radius"
        assert "too small for a board of" in str(error)


class TestMissing:
    def test_bins_must_reach_from_wall_to_wall(self) -> None:
        form = box([(0.0, 3.0, 0.1)])
        for edges, index in (([-3.0, 0.0, 4.0], 0), ([-4.0, 0.0, 3.0], 2)):
            error = refusal(changed(form, ("bins", "edges"), edges))
            assert error.field == f"bins.edges[{index}]"
            assert f"bins.edges[{index}] is {edges[index]}: a ball can miss the bins" in str(error)

    def test_walls_must_reach_down_to_the_bins(self) -> None:
        form = box([(0.0, 3.0, 0.1)])
        assert verdict(changed(form, ("walls", 1, "y2"), 5.95)) == ""
        assert verdict(changed(form, ("walls", 1, "y2"), 5.5)) == "miss the bins"

    def test_walls_must_reach_up_to_where_a_ball_could_leave(self) -> None:
        form = box([(0.0, 3.0, 0.1)])
        assert verdict(changed(form, ("walls", 0, "y1"), 0.05)) == ""
        assert verdict(changed(form, ("walls", 0, "y1"), 2.0)) == "miss the bins"

    @pytest.mark.parametrize(
        ("gap", "answer"), [(2 * R - 0.001, ""), (2 * R + 0.001, "miss the bins")]
    )
    def test_a_gap_in_a_wall_loses_a_ball_only_if_it_fits_through(
        self, gap: float, answer: str
    ) -> None:
        form = box([(0.0, 1.0, 0.1)], [(-4.0, 3.0 + gap, -4.0, 6.0)])
        assert verdict(changed(form, ("walls", 0, "y2"), 3.0)) == answer

    @pytest.mark.parametrize(
        ("gap", "answer"), [(2 * R - 0.001, ""), (2 * R + 0.001, "miss the bins")]
    )
    def test_a_fence_of_pegs_keeps_a_ball_exactly_if_dense_enough(
        self, gap: float, answer: str
    ) -> None:
        radius, pitch = 0.05, gap + 2 * 0.05
        count = int(7.0 / pitch) + 1
        fence = [(s * 4.0, -0.5 + i * pitch, radius) for s in (-1, 1) for i in range(count)]
        assert verdict(box([(0.0, 3.0, 0.1), *fence], sides=False)) == answer

    def test_with_no_walls_a_ball_that_falls_straight_cannot_miss(self) -> None:
        assert verdict(box(sides=False)) == ""
        assert verdict({**box(sides=False), "drop": {"x": 3.0, "jitter": 1.5}}) == "miss the bins"

    def test_with_no_walls_the_farthest_throw_decides(self) -> None:
        # A peg whose lowest contact is h below the start throws no farther than 2 sqrt(6 h) m.
        def far(y: float) -> float:
            return 0.2 + 2.0 * math.sqrt(6.0 * (y + 0.2))

        for y in (0.3, 0.4, 0.5):
            form = box([(0.0, y, 0.1)], sides=False)
            wide = changed(form, ("bins", "edges"), [-far(y) - 1e-6, 0.0, far(y) + 1e-6])
            narrow = changed(form, ("bins", "edges"), [-far(y) + 1e-3, 0.0, far(y) + 1e-6])
            assert verdict(wide) == ""
            assert verdict(narrow) == "miss the bins"

    def test_the_design_s_example_needs_no_right_wall(self) -> None:
        assert verdict(EXAMPLE) == ""
        assert verdict(changed(EXAMPLE, ("bins", "edges"), [-4.0, -3.5, 3.5])) == "miss the bins"


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
