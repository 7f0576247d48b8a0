"""The oracle is right about walls in pieces, and the exact solver does what it says."""

from collections import Counter

import numpy as np
import pytest

from plinko.engine.board.model import Board
from plinko.engine.board.parts import Wall
from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.seeding import start_xs
from tests.long import tries
from tools.boards.wall_boards import seeds_of, wall_board
from tools.oracle import CUT, OracleDrop, oracle_drop
from tools.oracle.comparison import FELT, compare
from tools.oracle.corners import Corner, holds
from tools.oracle.drop import Run
from tools.oracle.scene import Scene
from tools.oracle.scenes import scene
from tools.oracle.time_stepping import Velocity


def starts(board: Board, number: int, count: int = 1) -> list[float]:
    seeds = np.array([*seeds_of(number, count)], np.uint64)
    found: list[float] = start_xs(seeds, board.drop.x, board.drop.jitter).tolist()
    return found


def felt(drop: OracleDrop) -> list[tuple[int, float, float]]:
    """Kind, time and place of the impacts that are felt."""
    impacts = [e for e in drop.events if e.kind in {KIND_PEG, KIND_WALL}]
    return [(e.kind, float(e.t), float(e.x)) for e in impacts if e.approach > FELT]


def assert_alike(a: OracleDrop, b: OracleDrop, error: float) -> None:
    assert (a.bin, a.reason) == (b.bin, b.reason)
    assert abs(float(a.x_end - b.x_end)) <= error
    assert abs(float(a.duration - b.duration)) <= error
    assert [kind for kind, _, _ in felt(a)] == [kind for kind, _, _ in felt(b)]
    assert np.allclose(felt(a), felt(b), rtol=0.0, atol=error)


# The oracle by itself.


@pytest.mark.long
@pytest.mark.parametrize("group", range(tries(2, 20)))
def test_the_oracle_says_the_same_at_thirty_and_at_fifty_digits(group: int) -> None:
    for number in range(10 * group, 10 * (group + 1)):
        board = wall_board(number)
        for x in starts(board, number):
            few = oracle_drop(board, x, 30, max_events=100)
            many = oracle_drop(board, x, 50, max_events=100)
            assert_alike(few, many, 1e-12)


def test_a_ball_that_stops_in_a_notch_spins_down_and_goes_on_along_the_slope() -> None:
    """It bounces ever faster between a slope and an upright wall until it has stopped."""
    walls = (Wall(1.0, 1.0, -1.0, 1.2), Wall(1.0, -1.0, 1.0, 1.0), Wall(0.4, 0.4, 0.7, 0.7))
    board = scene(walls=walls, friction=0.3, radius=0.05)
    oracle = oracle_drop(board, 0.5, 30)
    assert oracle.reason is None
    assert oracle.x_end < -1.0
    assert compare(board, 0.5).verdict in {"equal", "close"}


def test_a_spinning_ball_that_stops_below_two_overhangs_falls_with_its_spin() -> None:
    """Friction could hold it: the sum of the forces along both friction cones can be its weight."""
    made, omega = Corner((-102.0, 115.0), (0.1, 0.0), (0.07, 1.7)), -73.0
    assert any(holds(solution) for solution in made.solutions(omega))
    run = Run(Scene(made.board, 30), 0, 10, CUT)
    nx, ny = made.normals[1]
    wall = max(run.scene.faces, key=lambda face: face.nx * nx + face.ny * ny)
    run.now = run.now._replace(omega=run.scene.ctx.mpf(omega))
    run.rest_in(run.scene.circles[0], wall)
    assert (run.end, run.pieces, run.now.omega) == (None, [], omega)
    exact = made.path(Velocity(0.0, 0.0, omega)).states_at(np.array([0.01]))[0]
    assert exact[2] == pytest.approx(0.5 * 9.81 * 1e-4)
    assert exact[6] == omega


# The exact solver against the oracle.


@pytest.mark.long
@pytest.mark.parametrize("group", range(tries(6, 500)))
def test_a_ball_on_walls_in_pieces_does_what_the_oracle_says(group: int) -> None:
    for number in range(4 * group, 4 * (group + 1)):
        board = wall_board(number)
        for x in starts(board, number):
            found = compare(board, x)
            assert found.verdict != "differs", f"board {number}, x = {x!r}: {found.what}"


@pytest.mark.long("200 drops of the oracle")
def test_most_drops_are_compared_to_the_last_digits() -> None:
    numbers = range(200)
    boards = [(wall_board(number), number) for number in numbers]
    verdicts = Counter(compare(b, x).verdict for b, n in boards for x in starts(b, n))
    assert verdicts["equal"] > 0.6 * len(numbers)
