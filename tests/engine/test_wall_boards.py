"""On boards whose walls come in pieces, every drop keeps to the surface and gains no energy."""

import pytest

from plinko.engine.board.model import Board
from plinko.engine.drops.trajectory import Trajectory, at_start, follow
from plinko.engine.parameters import Exact
from tests.long import tries
from tools.boards.checked_drops import check_drops, compare_drops, is_sure
from tools.boards.wall_boards import seeds_of, wall_board, wall_pair

BOARDS = 300
DROPS = tries(4, 50)
GROUPS = range(tries(10, 680))
"""Groups of BOARDS / 10 boards; `make test-long` plays a million drops."""


@pytest.mark.long
@pytest.mark.parametrize("group", GROUPS)
def test_no_drop_on_walls_in_pieces_breaks_a_law(group: int) -> None:
    size = BOARDS // 10
    failures = []
    for number in range(group * size, (group + 1) * size):
        failures += check_drops(wall_board(number), seeds_of(number, DROPS), number)
    assert not failures, "\n".join(f"{f.kind}: {f}" for f in failures[:20])


@pytest.mark.long
@pytest.mark.parametrize("group", range(tries(4, 100)))
def test_a_ball_does_not_notice_that_a_straight_wall_is_in_pieces(group: int) -> None:
    failures = []
    for number in range(50 * group, 50 * (group + 1)):
        failures += compare_drops(*wall_pair(number), seeds_of(number, tries(5, 50)), number)
    assert not failures, "\n".join(str(f) for f in failures[:20])


def test_most_drops_on_whole_walls_are_sure_enough_to_compare() -> None:
    boards = [wall_pair(number)[0] for number in range(20)]
    sure = [is_sure(path_on(board, x)) for board in boards for x in (-0.4, -0.1, 0.2, 0.5)]
    assert sum(sure) > 0.5 * len(sure)


# The check itself notices each kind of failure.


def path_on(board: Board, x: float) -> Trajectory:
    return follow(board, at_start(board, x), Exact())


@pytest.fixture
def slope() -> Board:
    """A ball bounces on a slope, then rolls down and off it."""
    material = {"restitution": 0.3, "friction": 0.5}
    return Board.from_json(
        {
            "ball": {"radius": 0.05, **material},
            "wall_material": material,
            "walls": [
                {"x1": -0.5, "y1": 0.5, "x2": 0.5, "y2": 0.7},
                {"x1": -1.0, "y1": -0.5, "x2": -1.0, "y2": 2.0},
                {"x1": 1.0, "y1": -0.5, "x2": 1.0, "y2": 2.0},
            ],
            "bins": {"y": 2.0, "edges": [-1.0, 0.0, 1.0]},
            "drop": {"x": -0.2},
        }
    )
