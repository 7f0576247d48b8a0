"""The compare page opens with two balls that end in different bins, on the house table."""

import math

from plinko.engine import Board, drop
from plinko.engine.board.presets import HOUSE_NAMES
from tests.js.conftest import Run

MODULE = "compare/pair.js"
SCRIPT = "({ openingPair }, names) => Object.fromEntries(names.map((n) => [n, openingPair(n)]))"


def test_every_preset_of_the_house_table_has_an_opening_pair(run: Run) -> None:
    for name, pair in run(MODULE, SCRIPT, list(HOUSE_NAMES)).items():
        board = Board.preset(name)
        one = drop(board, int(pair["seed"]))
        bit = pair["shift"] == "bit"
        x = math.nextafter(one.x_start, math.inf) if bit else one.x_start + float(pair["shift"])
        two = drop(board, one.seed, x=x)
        assert one.bin is not None
        assert two.bin is not None
        assert one.bin != two.bin, name


def test_another_board_has_no_opening_pair(run: Run) -> None:
    assert run(MODULE, "({ openingPair }) => openingPair('0123456789abcdef')") is None
    assert run(MODULE, "({ openingPair }) => openingPair('triangle-3')") is None
    assert run(MODULE, "({ openingPair }) => openingPair('moon-16')") is None
