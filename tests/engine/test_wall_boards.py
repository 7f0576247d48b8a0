"""On boards whose walls come in pieces, every drop keeps to the surface and gains no energy."""

import pytest
from msgspec.structs import replace

from plinko.engine.board.model import Board
from plinko.engine.board.parts import Wall
from plinko.engine.drops.trajectory import Trajectory, at_start, follow
from plinko.engine.parameters import Exact
from plinko.engine.physics import body
from tests.long import tries
from tools.boards.checked_drops import check_drops, check_paths, compare_drops, is_sure
from tools.boards.wall_boards import seeds_of, wall_board, wall_pair

BOARDS = 300
DROPS = tries(4, 50)
GROUPS = range(tries(2, 680))
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
@pytest.mark.parametrize("group", range(tries(2, 100)))
def test_a_ball_does_not_notice_that_a_straight_wall_is_in_pieces(group: int) -> None:
    failures = []
    for number in range(50 * group, 50 * (group + 1)):
        failures += compare_drops(*wall_pair(number), seeds_of(number, tries(5, 50)), number)
    assert not failures, "\n".join(str(f) for f in failures[:20])


def test_most_drops_on_whole_walls_are_sure_enough_to_compare() -> None:
    boards = [wall_pair(number)[0] for number in range(20)]
    sure = [is_sure(path_on(board, x)) for board in boards for x in (-0.4, -0.1, 0.2, 0.5)]
    assert sum(sure) > 0.5 * len(sure)


def test_the_comparison_sees_a_wall_that_is_not_the_same() -> None:
    whole, _ = wall_pair(0)
    first, *others = whole.walls
    moved = whole.replace(walls=[Wall(first.x1, first.y1, first.x2, first.y2 + 1e-6), *others])
    assert compare_drops(whole, moved, range(50))


def test_a_numbered_board_is_always_the_same() -> None:
    assert wall_board(7).digest == wall_board(7).digest
    assert len({wall_board(number).digest for number in range(5)}) == 5


# The check itself notices each kind of failure.


def path_on(board: Board, x: float) -> Trajectory:
    return follow(board, at_start(board, x), Exact())


def kinds_of(board: Board, path: Trajectory) -> set[str]:
    return {failure.kind for failure in check_paths(board, [path])}


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


def test_a_true_path_passes_the_check(slope: Board) -> None:
    assert kinds_of(slope, path_on(slope, -0.2)) == set()


def test_the_check_sees_a_path_of_another_board(slope: Board) -> None:
    """Played without the slope, or with a slope that lies elsewhere."""
    moved = slope.replace(walls=(Wall(-0.5, 0.4, 0.5, 0.6), *slope.walls[1:]))
    found = kinds_of(slope, path_on(moved, -0.2))
    assert {"impact off its body", "contact off its body", "rides on nothing"} <= found
    deeper = slope.replace(walls=(Wall(-0.5, 0.6, 0.5, 0.8), *slope.walls[1:]))
    assert "depth" in kinds_of(slope, path_on(deeper, -0.2))


def test_the_check_sees_energy_a_jump_and_a_wrong_bounce(slope: Board) -> None:
    path = path_on(slope, -0.2)
    faster = path.segments.copy()
    faster[1, body.VY] *= 5.0
    assert "energy" in kinds_of(slope, replace(path, segments=faster))
    jumping = path.segments.copy()
    jumping[1:, body.X] += 1e-8
    assert "jump" in kinds_of(slope, replace(path, segments=jumping))
    inwards = path.impacts.copy()
    inwards["vy"][0] = 1.0
    assert "hits inwards" in kinds_of(slope, replace(path, impacts=inwards))


def test_the_check_sees_a_ball_at_rest_in_mid_air(slope: Board) -> None:
    path = path_on(slope, -0.2)
    assert "rests on nothing" in kinds_of(slope, replace(path, outcome=1))
    assert "event budget" in kinds_of(slope, replace(path, outcome=4))
