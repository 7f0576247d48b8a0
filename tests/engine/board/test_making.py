"""Boards made in Python: triangles of any size, parts replaced, polygons as obstacles."""

from typing import Any

import numpy as np
import pytest

from plinko.engine import BallSpec, Board, BoardError, Peg, drop, drop_many, polygon
from plinko.engine.board.making import ROWS
from plinko.engine.board.payouts import RISKS, Risk
from plinko.engine.board.payouts import ROWS as PRESETS


@pytest.mark.parametrize("rows", PRESETS)
@pytest.mark.parametrize("risk", RISKS)
def test_a_triangle_with_a_preset_s_rows_is_the_preset(rows: int, risk: Risk) -> None:
    suffix = "" if risk == "medium" else f"-{risk}"
    assert Board.triangle(rows, risk=risk) == Board.preset(f"triangle-{rows}{suffix}")


@pytest.mark.parametrize("rows", [rows for rows in ROWS if rows not in PRESETS])
def test_a_triangle_of_any_rows_is_playable_and_pays_one_stake(rows: int) -> None:
    board = Board.triangle(rows)
    assert len(board.pegs) == sum(range(3, rows + 3))
    assert board.bins.multipliers == (1.0,) * (rows + 1)
    many = drop_many(board, 200)
    assert many.unsettled_count == 0
    assert many.histogram.sum() == 200
    mirrored = drop_many(board, 200, xs=-many.x_start)
    assert (mirrored.bin == rows - many.bin).all()


def test_a_triangle_takes_changes() -> None:
    pays = [4.0, 1.0, 0.5, 1.0, 4.0]
    board = Board.triangle(4, name="mine", gravity=1.62, bins={"multipliers": pays})
    assert (board.name, board.gravity, board.bins.multipliers) == ("mine", 1.62, tuple(pays))
    assert board.replace(name="triangle-4", gravity=24.79, bins={"multipliers": (1,) * 5}) == (
        Board.triangle(4)
    )


def test_a_triangle_with_changes_is_not_called_like_the_preset() -> None:
    heavy = Board.triangle(8, gravity=24.79)
    assert heavy.name == "triangle of 8 rows"
    assert heavy.preset_name is None
    assert Board.triangle(8).name == "triangle-8"


def test_a_part_may_be_given_in_the_json_form() -> None:
    board = Board(bins={"multipliers": [1, 2, 1]}, ball={"radius": 0.1}, width=3.0)  # type: ignore[arg-type]
    assert board.bins.edges == (-1.5, -0.5, 0.5, 1.5)
    assert (board.ball.radius, board.ball.restitution) == (0.1, BallSpec().restitution)
    assert board == Board.from_json(
        {"bins": {"multipliers": [1, 2, 1]}, "ball": {"radius": 0.1}, "width": 3.0, "walls": []}
    )
    with pytest.raises(BoardError, match=r"bins\.edge is unknown") as it:
        Board(bins={"edge": []})  # type: ignore[arg-type]
    assert it.value.field == "bins.edge"
    assert len(it.value.faults) == 1


@pytest.mark.parametrize("name", ["triangle-8", "classic"])
def test_one_call_sets_the_surface_of_every_contact(name: str) -> None:
    board = Board.preset(name)
    bouncy, rough = board.with_restitution(0.8), board.with_friction(0.3)
    for part in ("ball", "peg_material", "wall_material"):
        assert getattr(bouncy, part).restitution == 0.8
        assert getattr(bouncy, part).friction == getattr(board, part).friction
        assert getattr(rough, part).friction == 0.3
        assert getattr(rough, part).restitution == getattr(board, part).restitution
    with pytest.raises(BoardError, match="restitution is 1"):
        board.with_restitution(1.5)


def test_a_study_of_restitution_shows_no_plateau() -> None:
    board = Board.preset("classic")
    studied = [0.1, 0.2, 0.3, 0.4]
    fall = [drop_many(board.with_restitution(e), 200).duration.mean() for e in studied]
    assert len(set(fall)) == 4
    one = [drop_many(board.replace(ball={"restitution": e}), 200).duration.mean() for e in studied]
    assert len(set(one)) < 4, "the greater restitution counts, so the ball's alone may not show"


@pytest.mark.parametrize("number", [np.float32(5.0), np.int64(5), 5])
def test_numbers_of_numpy_are_numbers(number: Any) -> None:
    board = Board.preset("triangle-8").replace(gravity=number)
    assert (board.gravity, type(board.gravity)) == (5.0, float)


def test_a_part_is_replaced_as_a_whole_or_by_field() -> None:
    board = Board.preset("triangle-8")
    heavy = board.replace(ball={"density": 7.8})
    assert heavy.ball.density == 7.8
    assert heavy.ball.radius == board.ball.radius
    assert heavy == board.replace(ball=BallSpec(**{**_fields(board.ball), "density": 7.8}))
    assert heavy.preset_name is None
    assert board.replace() == board
    assert board.replace(pegs=board.pegs[:-1]).pegs == board.pegs[:-1]


def _fields(ball: BallSpec) -> dict[str, Any]:
    return {name: getattr(ball, name) for name in ("radius", "density", "restitution", "friction")}


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda board: board.replace(colour="red"), "colour"),
        (lambda board: board.replace(ball={"mass": 1}), "ball.mass"),
        (lambda board: board.replace(ball={"radius": -1}), "ball.radius"),
        (lambda board: board.replace(ball=3), "ball"),
        (lambda board: board.replace(pegs=[*board.pegs, Peg(0.0, 0.36, 0.01)]), "pegs[52]"),
        (lambda board: board.replace(digest="0"), "digest"),
        (lambda board: Board.triangle(3), "rows"),
        (lambda board: Board.triangle(21), "rows"),
        (lambda board: Board.triangle(8.5), "rows"),  # type: ignore[arg-type]
        (lambda board: Board.triangle(8, risk="huge"), "risk"),  # type: ignore[arg-type]
        (lambda board: polygon([(0, 0), (1, 1)]), "corners"),
    ],
)
def test_an_impossible_change_is_named(make: Any, field: str) -> None:
    with pytest.raises(BoardError) as caught:
        make(Board.preset("triangle-8"))
    assert caught.value.field == field


def test_a_ball_goes_around_a_polygon() -> None:
    """A roof with its ridge below the start divides the balls, and no ball enters it."""
    roof = polygon([(0.0, 0.5), (0.5, 1.5), (-0.5, 1.5)])
    board = Board.from_json(
        {"bins": {"y": 2.5, "edges": [-2.0, 0.0, 2.0]}, "drop": {"jitter": 0.3, "y": 0.1}}
    )
    board = board.replace(walls=[*board.walls, *roof])
    assert len(roof) == 3
    many = drop_many(board, 100)
    assert ((many.x_start < 0) == (many.bin == 0)).all()
    for one in many[:20]:
        path = one.states([one.duration * k / 50 for k in range(51)])
        inside = (path["y"] > 0.5) & (path["y"] < 1.5) & (abs(path["x"]) < 0.5 * (path["y"] - 0.5))
        assert not inside.any()
    assert drop(board, x=0.2).impact_count > 0
