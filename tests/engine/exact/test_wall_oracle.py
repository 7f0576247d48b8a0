"""The oracle is right about walls in pieces, and the exact solver does what it says."""

import math
from collections import Counter
from itertools import product

import numpy as np
import pytest

from plinko.engine.board.model import Board
from plinko.engine.board.parts import Peg, Wall
from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.drops.trajectory import at_start, follow
from plinko.engine.parameters import Exact
from plinko.engine.seeding import start_xs
from tests.long import tries
from tools.boards.wall_boards import seeds_of, wall_board, wall_pair
from tools.oracle import CUT, OracleDrop, oracle_drop
from tools.oracle.comparison import FELT, compare, compare_path
from tools.oracle.corners import Corner, holds
from tools.oracle.drop import Run
from tools.oracle.scene import Scene
from tools.oracle.scenes import scene
from tools.oracle.time_stepping import Velocity

SLOPE = Wall(-1.0, 0.0, 1.0, 0.5)


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
@pytest.mark.parametrize("group", range(tries(1, 20)))
def test_the_oracle_does_not_notice_that_a_straight_wall_is_in_pieces(group: int) -> None:
    """Exact joints change nothing; rounded ones bend the wall by 1e-16 rad."""
    for number in range(10 * group, 10 * (group + 1)):
        whole, cut = wall_pair(number)
        for x in starts(whole, number):
            one = oracle_drop(whole, x, 30, max_events=150)
            if one.reason != "too many events":
                error = 1e-18 if number % 2 == 0 else 1e-9
                assert_alike(one, oracle_drop(cut, x, 30), error * max(1.0, one.amplification))


@pytest.mark.long
@pytest.mark.parametrize("group", range(tries(1, 20)))
def test_the_oracle_says_the_same_at_thirty_and_at_fifty_digits(group: int) -> None:
    for number in range(10 * group, 10 * group + tries(6, 10)):
        board = wall_board(number)
        for x in starts(board, number):
            few = oracle_drop(board, x, 30, max_events=100)
            many = oracle_drop(board, x, 50, max_events=100)
            assert_alike(few, many, 1e-12)


@pytest.mark.long
@pytest.mark.parametrize(
    ("x", "restitution"),
    tries([(-0.5, 0.0), (-0.9, 0.3)], [*product((-0.9, -0.5, 0.3), (0.0, 0.3, 1.0))]),
)
def test_walls_that_cover_a_wall_change_nothing(x: float, restitution: float) -> None:
    parts = (
        (SLOPE, SLOPE),
        (SLOPE, Wall(1.0, 0.5, -1.0, 0.0)),
        (SLOPE, Wall(-0.5, 0.125, 0.5, 0.375)),
        (Wall(-1.0, 0.0, 0.5, 0.375), Wall(-0.5, 0.125, 1.0, 0.5)),
        (Wall(0.0, 0.25, 1.0, 0.5), Wall(-1.0, 0.0, 0.0, 0.25)),
        tuple(
            Wall(0.25 * i, 0.25 + i / 16, 0.25 * i + 0.25, 0.3125 + i / 16) for i in range(-4, 4)
        ),
    )
    one = oracle_drop(scene(walls=(SLOPE,), restitution=restitution, friction=0.2), x, 30, 60)
    for walls in parts:
        board = scene(walls=walls, restitution=restitution, friction=0.2)
        assert_alike(one, oracle_drop(board, x, 30, 200), 1e-18)


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_an_end_that_lies_in_another_wall_is_no_surface(friction: float) -> None:
    """A second wall below the first sticks out beyond its end: the ball goes on without a bump."""
    below = Wall(0.5, 0.375, 2.0, 0.75)
    board = scene(walls=(SLOPE, below), friction=friction)
    long = scene(walls=(Wall(-1.0, 0.0, 2.0, 0.75),), friction=friction)
    assert_alike(oracle_drop(long, -0.5, 30), oracle_drop(board, -0.5, 30), 1e-18)


def test_a_ball_in_a_concave_corner_meets_the_second_wall_once() -> None:
    """It slides down the first, keeps the speed along the second, and touches nothing else."""
    steep, gentle = Wall(-1.0, -1.0, 0.0, 0.0), Wall(0.0, 0.0, 1.0, 0.25)
    drop = oracle_drop(scene(walls=(steep, gentle), radius=0.1, start_y=-1.5), -0.8, 30)
    impacts = felt(drop)
    assert len(impacts) == 2
    # The corner of two lines at a distance R from the walls, by hand.
    half = 0.5 * (math.atan2(1.0, 1.0) + math.atan2(0.25, 1.0))
    bend = 0.5 * (math.atan2(1.0, 1.0) - math.atan2(0.25, 1.0))
    corner = 0.1 / math.cos(bend) * math.sin(half)
    assert impacts[1][2] == pytest.approx(corner, abs=1e-15)


def test_a_peg_that_touches_a_wall_from_below_is_no_surface() -> None:
    length = math.hypot(2.0, 0.5)
    nx, ny = -0.5 / length, 2.0 / length
    peg = Peg(0.03 * nx, 0.25 + 0.03 * ny, 0.03)
    with_peg = oracle_drop(scene(walls=(SLOPE,), pegs=(peg,), friction=0.3), -0.6, 30)
    alone = oracle_drop(scene(walls=(SLOPE,), friction=0.3), -0.6, 30)
    assert_alike(alone, with_peg, 1e-15)


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
@pytest.mark.parametrize("group", range(tries(1, 400)))
def test_a_ball_on_walls_in_pieces_does_what_the_oracle_says(group: int) -> None:
    for number in range(5 * group, 5 * (group + 1)):
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


@pytest.mark.parametrize(("moved", "restitution"), [(1e-9, 0.0), (1e-5, 0.4)])
def test_the_comparison_sees_a_path_over_another_wall(moved: float, restitution: float) -> None:
    """A wall that lies 1e-9 m lower is close; one that lies 1e-5 m lower differs."""
    board = scene(walls=(SLOPE,), restitution=restitution, friction=0.2)
    lower = Wall(-1.0, moved, 1.0, 0.5 + moved)
    other = scene(walls=(lower,), restitution=restitution, friction=0.2)
    oracle = oracle_drop(board, -0.5, 30)
    own = compare_path(board, follow(board, at_start(board, -0.5), Exact()), oracle)
    assert own.verdict == "equal"
    path = follow(other, at_start(other, -0.5), Exact())
    assert compare_path(board, path, oracle).verdict == ("close" if moved < 1e-6 else "differs")
