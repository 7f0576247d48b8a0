"""The values of a billiard: each is checked, and an error names the bad value."""

import math
from typing import Any

import pytest

from benchmarks.billiards import Billiard, launch
from plinko.engine.board.parts import Peg, Wall
from plinko.engine.errors import BoardError

PEG = Peg(0.0, 0.0, 0.5)
SQUARE = ((2.0, 0.0), (0.0, 2.0))


@pytest.mark.parametrize(
    ("values", "field", "words"),
    [
        ({"gravity": -1.0}, "gravity", "from 0"),
        ({"gravity": math.inf}, "gravity", "finite"),
        ({"drag": -0.1}, "drag", "drag is -0.1: it must be"),
        ({"pegs": (Peg(0.0, 0.0, 0.0),)}, "pegs[0].radius", "greater than 0"),
        ({"cell": SQUARE}, "cell", "at least one"),
        ({"pegs": (PEG,), "walls": (Wall(0, 1, 1, 1),), "cell": SQUARE}, "cell", "1 walls"),
        ({"pegs": (PEG,), "cell": ((1.0, 0.0), (2.0, 0.0))}, "cell", "parallel"),
        ({"pegs": (PEG,), "cell": ((1.0, 0.0), (2.0, "x"))}, "cell[1][1]", "number"),
        ({"pegs": (PEG,), "cell": ((1.0, 0.0),)}, "cell", "two vectors"),
        ({"pegs": (PEG,), "cell": ((1.0, 0.0), (1.0,))}, "cell[1]", "two numbers"),
    ],
)
def test_a_value_out_of_range_is_named(values: dict[str, Any], field: str, words: str) -> None:
    with pytest.raises(BoardError, match=words.replace("(", r"\(")) as error:
        Billiard(**values)
    assert error.value.field == field


def test_a_cell_too_flat_to_be_copied_around_a_ball_is_refused() -> None:
    flat = Billiard(pegs=(Peg(0.0, 0.0, 1e-3),), cell=((100.0, 0.0), (100.0, 0.01)))
    with pytest.raises(BoardError, match="copies") as error:
        launch(flat, [(1.0, 0.5)], [(1.0, 0.0)])
    assert error.value.field == "cell"
