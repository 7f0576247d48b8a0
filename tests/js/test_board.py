"""Pages and the server's pictures find the same side walls of a board."""

import pytest

from plinko.app.render.parts.board import sides_of
from plinko.engine import Board
from tests.app.render.test_walls import HEXAGON, hexagon, walled
from tests.js.conftest import Run
from tests.kit.presets import SAMPLE

RAMP = {"x1": -1.5, "y1": 0.5, "x2": -0.75, "y2": 0.875}
LID = {"x1": -1.5, "y1": -1.0, "x2": 1.5, "y2": -1.0}


@pytest.mark.parametrize(
    "boards",
    [
        [Board.preset(name) for name in SAMPLE],
        [HEXAGON, walled(*hexagon(0.5)), walled(RAMP), walled(LID), walled()],
    ],
    ids=["presets", "own"],
)
def test_the_same_walls_are_at_the_sides(run: Run, boards: list[Board]) -> None:
    found = run(
        "model/board.js",
        "({ sidesOf }, boards) => boards.map(sidesOf)",
        [board.to_dict() for board in boards],
    )
    assert found == [list(sides_of(board)) for board in boards]
