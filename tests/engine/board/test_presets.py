"""The presets have the reference game's proportions, are exact mirrors, and pass every check."""

import math
from itertools import pairwise
from unittest import mock

import pytest

from plinko.engine.board.checks import playable
from plinko.engine.board.checks.obstacles import obstacles
from plinko.engine.board.checks.reach import free_intervals
from plinko.engine.board.model import Board
from plinko.engine.board.payouts import TABLES
from plinko.engine.board.presets import TUNING, preset_names
from plinko.engine.errors import BoardError

TRIANGLES = [f"triangle-{rows}" for rows in range(8, 17)]
# Those of low and of high risk differ from these in their payouts only.
PLAIN = [name for name in preset_names() if not name.endswith(("-low", "-high"))]


def test_presets_come_in_the_order_of_the_menu() -> None:
    names = preset_names()
    assert names[:4] == ("triangle-8", "triangle-8-low", "triangle-8-high", "triangle-9")
    assert names[24:30] == (
        "triangle-16", "triangle-16-low", "triangle-16-high", "classic", "galton", "earth-8"
    )  # fmt: skip
    assert names[-1] == "rubber-16-high"
    assert len(names) == len(set(names)) == 8 * 9 * 3 + 2


def test_the_boards_known_to_be_playable_are_exactly_the_presets() -> None:
    """If you change a preset, check that it passes every test, then copy its digest there."""
    digests = {name: table.digest for name, table in TABLES.items()}
    assert {name: Board.preset(name).digest for name in preset_names()} == digests
    assert len(set(digests.values())) == len(digests)


def test_only_a_board_that_is_no_preset_is_checked_as_a_whole() -> None:
    form = Board.preset("triangle-8").to_dict()
    with mock.patch.object(playable, "check") as check:
        Board.from_json(form)
        assert check.call_count == 0
        other = Board.from_json({**form, "gravity": 1.62})
        check.assert_called_once_with(other)


def test_a_preset_s_name_does_not_excuse_an_unplayable_board() -> None:
    form = Board.preset("triangle-8").to_dict()
    form["pegs"].append(form["pegs"][0])
    with pytest.raises(BoardError, match="overlaps"):
        Board.from_json(form)


@pytest.mark.parametrize("name", PLAIN)
def test_every_preset_passes_every_check(name: str) -> None:
    playable.check(Board.preset(name))


def test_a_preset_s_json_form_is_the_preset() -> None:
    for name in preset_names():
        board = Board.preset(name)
        again = Board.from_json(board.to_json())
        assert again == board
        assert again.digest == board.digest
        assert again.preset_name == name == board.name


def test_a_preset_is_made_once() -> None:
    assert Board.preset("triangle-16") is Board.preset("triangle-16")


def test_a_board_with_only_a_presets_name_is_no_preset() -> None:
    form = Board.preset("triangle-8").to_dict()
    assert Board.from_json({**form, "gravity": 1.62}).preset_name is None
    assert Board.from_json({**form, "name": "mine"}).preset_name is None


@pytest.mark.parametrize(
    "name", ["triangle-7", "triangle-17", "triangle-8-medium", "TRIANGLE-8", ""]
)
def test_the_error_for_an_unknown_preset_lists_all_presets(name: str) -> None:
    with pytest.raises(BoardError, match="there is no such preset") as caught:
        Board.preset(name)
    assert repr(name) in str(caught.value)
    assert "triangle-16-high" in str(caught.value)


@pytest.mark.parametrize("name", PLAIN)
def test_each_half_is_the_exact_mirror_of_the_other(name: str) -> None:
    board = Board.preset(name)
    pegs = {(p.x, p.y, p.radius) for p in board.pegs}
    assert pegs == {(-x, y, r) for x, y, r in pegs}
    walls = {(w.x1, w.y1, w.x2, w.y2) for w in board.walls}
    assert walls == {(-x1, y1, -x2, y2) for x1, y1, x2, y2 in walls}
    assert board.bins.edges == tuple(-x for x in reversed(board.bins.edges))
    assert board.bins.multipliers == board.bins.multipliers[::-1]
    assert board.drop.x == 0.0


@pytest.mark.parametrize("name", PLAIN)
def test_no_ball_can_land_on_an_edge_between_two_bins(name: str) -> None:
    board = Board.preset(name)
    landing = free_intervals(obstacles(board), board.bins.y)
    reach, below = board.ball.radius + board.pegs[0].radius, board.ball.radius
    clearance = math.sqrt(reach * reach - below * below)
    for edge in board.bins.edges[1:-1]:
        nearest = min(abs(edge - end) for pair in landing for end in pair)
        assert nearest == pytest.approx(clearance, rel=1e-9)
        assert not any(a < edge < b for a, b in landing)


@pytest.mark.parametrize("name", [*TRIANGLES, "galton"])
def test_every_bin_is_as_wide_as_any_other_where_a_ball_can_land(name: str) -> None:
    board = Board.preset(name)
    edges = board.bins.edges
    inside = [
        (a, b)
        for a, b in free_intervals(obstacles(board), board.bins.y)
        if a > edges[0] and b < edges[-1]
    ]
    assert len(inside) == board.bins.count
    for (a, b), left, right in zip(inside, edges, edges[1:], strict=False):
        assert left < a < b < right
        assert b - a == pytest.approx(inside[0][1] - inside[0][0], rel=1e-9)


@pytest.mark.parametrize("rows", range(8, 17))
def test_triangles_have_the_reference_games_proportions(rows: int) -> None:
    board = Board.preset(f"triangle-{rows}")
    spacing = 6.56 / (rows + 1)
    heights = sorted({p.y for p in board.pegs})
    assert len(heights) == rows
    for i, y in enumerate(heights):
        row = sorted(p.x for p in board.pegs if p.y == y)
        assert len(row) == i + 3
        assert y == pytest.approx(0.36 + 5.06 * i / (rows - 1), rel=1e-14)
        assert all(b - a == pytest.approx(spacing, rel=1e-12) for a, b in pairwise(row))
    assert board.bins.count == rows + 1
    assert (board.width, board.height) == (7.6, 5.7)
    radius = (24 - rows) / 2 / 100
    assert all(p.radius == pytest.approx(radius) for p in board.pegs)
    assert board.ball.radius == pytest.approx(2 * radius)
    tuning = TUNING[f"triangle-{rows}"]
    assert (board.drop.x, board.drop.y) == (0.0, tuning.start)
    assert board.drop.jitter == pytest.approx(tuning.jitter * spacing)
    assert board.drop.reach == pytest.approx(0.8 * spacing)
    assert board.drag == tuning.drag
    assert board.ball.restitution == board.peg_material.restitution == tuning.restitution
    assert board.ball.friction == board.wall_material.friction == tuning.friction


@pytest.mark.parametrize("name", TRIANGLES)
def test_side_walls_are_a_quarter_spacing_outside_the_last_pegs(name: str) -> None:
    board = Board.preset(name)
    wall = board.walls[2]
    spacing = 6.56 / board.bins.count
    for y in {p.y for p in board.pegs}:
        outermost = max(p.x for p in board.pegs if p.y == y)
        x = wall.x1 + (wall.x2 - wall.x1) * (y - wall.y1) / (wall.y2 - wall.y1)
        assert x - outermost == pytest.approx(0.25 * spacing, rel=1e-9)


@pytest.mark.parametrize("name", PLAIN)
def test_the_last_rows_pegs_stand_over_the_edges_of_the_bins(name: str) -> None:
    board = Board.preset(name)
    lowest = max(p.y for p in board.pegs)
    row = sorted(p.x for p in board.pegs if p.y == lowest)
    assert row[1:-1] == pytest.approx(board.bins.edges[1:-1])
    assert len(row) == len(board.bins.edges)


@pytest.mark.parametrize("name", [name for name in PLAIN if name not in ("classic", "galton")])
def test_variants_differ_in_name_and_payouts_only(name: str) -> None:
    plain = Board.preset(name)
    for risk in ("low", "high"):
        variant = Board.preset(f"{name}-{risk}")
        pays = variant.bins.multipliers
        assert pays == pays[::-1]
        same = {**plain.to_dict(), "name": variant.name}
        same["bins"]["multipliers"] = list(pays)
        assert same == variant.to_dict()


def test_presets_pay_by_their_tables() -> None:
    assert list(TABLES) == list(preset_names())
    for name, table in TABLES.items():
        half = Board.preset(name).bins.multipliers[: len(table.half)]
        assert half == table.half


def test_classic_has_nine_slots_over_nine_bins_with_their_jitter() -> None:
    board = Board.preset("classic")
    zone = board.drop
    assert board.bins.count == len(board.slots) == 9
    for slot, left, right in zip(board.slots, board.bins.edges, board.bins.edges[1:], strict=False):
        assert slot == pytest.approx((left + right) / 2.0)
        assert left + board.ball.radius < slot - zone.jitter
        assert slot + zone.jitter < right - board.ball.radius
    assert zone.aim_span == board.slots[-1]


def test_galton_has_many_small_pegs_a_small_ball_and_many_bins() -> None:
    board = Board.preset("galton")
    assert len(board.pegs) > 900
    assert board.bins.count == 33
    assert board.ball.radius < 0.05
