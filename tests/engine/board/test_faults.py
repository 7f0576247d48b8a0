"""All faults of a board are reported at once."""

import pickle

import pytest

from plinko.engine import Board, BoardError, Peg
from plinko.engine.board.faults import MOST

GOOD = {
    "pegs": [{"x": 0.0, "y": 1.0, "radius": 0.05}],
    "bins": {"y": 2.0, "edges": [-1.5, 0.0, 1.5], "multipliers": [2.0, 0.5]},
    "drop": {"x": 0.0, "y": 0.0, "jitter": 0.5},
}


def faults(form: dict[str, object]) -> list[str]:
    """The wrong fields of `form`; each has exactly one message."""
    with pytest.raises(BoardError) as caught:
        Board.from_json(GOOD | form)
    error = caught.value
    assert error.field == error.faults[0].field
    assert all(fault.message in str(error) for fault in error.faults)
    assert pickle.loads(pickle.dumps(error)).faults == error.faults
    return [fault.field for fault in error.faults]


def test_one_fault_is_the_error_itself() -> None:
    with pytest.raises(BoardError) as caught:
        Board.from_json(GOOD | {"gravity": -1.0})
    assert caught.value.faults == (("gravity", str(caught.value)),)


def test_faults_of_form_and_of_value_are_named_together() -> None:
    assert faults(
        {
            "colour": "red",
            "gravity": -1.0,
            "drag": None,
            "ball": {"radius": 0.0, "density": -1.0, "mass": 1},
            "pegs": [{"x": 0.0, "y": 1.0}, {"x": 0.0, "y": "1", "radius": 0.05}, {"radius": 1}],
        }
    ) == [
        "colour",
        "ball.mass",
        "pegs[0].radius",
        "pegs[2].x",
        "pegs[2].y",
        "gravity",
        "drag",
    ]
    assert faults(
        {"ball": {"radius": 0.0, "density": -1.0}, "wall_material": {"friction": -1}}
    ) == [
        "ball.radius",
        "ball.density",
        "wall_material.friction",
    ]


def test_a_fault_that_two_checks_meet_is_named_once() -> None:
    assert faults({"width": -1.0, "bins": {}, "drag": -1.0}) == ["width", "drag"]


def test_all_overlapping_pegs_and_touching_starts_are_named() -> None:
    pegs = [{"x": x, "y": y, "radius": 0.05} for x in (-0.02, 0.02) for y in (0.1, 1.0)]
    assert faults({"pegs": pegs, "drop": {"slots": [0.0, 1.0, 0.01]}}) == [
        "pegs[2]",
        "pegs[3]",
        "drop",
        "drop.slots[0]",
        "drop.slots[2]",
    ]


def test_a_board_made_of_fields_names_all_faults_too() -> None:
    board = Board.from_json(GOOD)
    with pytest.raises(BoardError) as caught:
        Board(name="", bins=board.bins, pegs=(Peg(0.0, 1.0, -1.0), 3), drag=-1.0)  # type: ignore[arg-type]
    fields = [fault.field for fault in caught.value.faults]
    assert fields == ["name", "drag", "pegs[0].radius", "pegs[1]"]


def test_of_thousands_of_faults_the_first_are_named() -> None:
    named = faults({"pegs": [{"x": 0.0, "y": 1.0, "radius": -1.0}] * 20_000})
    assert named == [f"pegs[{i}].radius" for i in range(MOST)]


def test_everywhere_a_ball_sticks_misses_or_cannot_pass_is_named() -> None:
    pairs = [{"x": x, "y": 1.0, "radius": 0.2} for x in (-0.6, -0.15, 0.25, 0.7)]
    shaft = [(1.0, -1.0, 1.0, 0.6), (1.0, 0.6, 1.4, 0.6), (1.4, 0.6, 1.4, -1.0)]
    shelf = (-1.4, 1.5, -1.0, 1.5)
    walls = [dict(zip(("x1", "y1", "x2", "y2"), wall, strict=True)) for wall in (*shaft, shelf)]
    zone = {"x": 0.0, "y": 0.0, "jitter": 0.5, "slots": [1.2, -1.2, 0.0]}
    assert faults({"ball": {"radius": 0.1}, "pegs": pairs, "walls": walls, "drop": zone}) == [
        "ball.radius",
        "bins.edges[0]",
        "bins.edges[2]",
        "pegs[0]",
        "pegs[1]",
        "pegs[2]",
        "walls[1]",
        "walls[3]",
    ]
