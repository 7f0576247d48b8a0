"""A ball on two surfaces does what the laws allow, by time steps that share no code with it.

`tools/oracle/corners.py` has the states, `tools/oracle/time_stepping.py` the laws and the steps.
"""

import json
import math
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest

from plinko.engine import Board, drop
from plinko.engine.board.materials import combine
from plinko.engine.drops.trajectory import Trajectory
from plinko.engine.exact.outcome import WEDGED
from plinko.engine.physics import body
from tests.long import tries
from tools.oracle.corners import (
    Corner,
    R,
    corner,
    hit,
    holds,
    is_alike,
    motions,
    runs_into,
    spin,
    steps_agree,
)
from tools.oracle.time_stepping import (
    Body,
    Contact,
    Motion,
    Velocity,
    World,
    solutions,
    step,
    swept,
)

G = 9.81
STATES = tries(100, 5000)
STEPPED = tries(15, 500)
STILL = Velocity(0.0, 0.0, 0.0)

CASES = json.loads(
    (Path(__file__).parents[2] / "regressions/contacts/two-contacts.json").read_text("utf-8")
)

# Several solutions: the ball may hold or go on along one surface; along each of them; or fall.
HOLDS_OR_OPENS = Corner((14.0, -161.0), (0.1, 0.0), (0.76, 1.88)), -56.0
HOLDS_OR_OPENS_EITHER = Corner((-33.0, -47.7), (0.1, 0.0), (0.1, 1.88)), 39.0
HOLDS_OR_FALLS = Corner((-102.0, 115.0), (0.1, 0.0), (0.07, 1.7)), -73.0


# The steps by themselves.


def stepped(world: World, start: Motion, seconds: float, steps: int) -> Motion:
    now = start
    for _ in range(steps):
        now = step(world, now, seconds / steps)
    return now


@pytest.mark.parametrize(("friction", "share"), [(0.0, 1.0), (0.1, None), (1.0, 2.0 / 3.0)])
def test_steps_slide_and_roll_down_a_slope_as_the_formulas_say(
    friction: float, share: float | None
) -> None:
    """At 30 degrees a disc slides if mu < tan 30 / 3, and rolls with 2/3 of the acceleration."""
    angle = math.radians(30.0)
    nx, ny = math.sin(angle), -math.cos(angle)
    slope = Body(-R * nx + 9.0 * ny, -R * ny - 9.0 * nx, -R * nx - 9.0 * ny, -R * ny + 9.0 * nx,
                 0.0, 0.0, friction)  # fmt: skip
    now = stepped(World([slope], G, 0.0, R), Motion(0.0, 0.0, STILL), 0.1, 100)
    pull = G * (math.sin(angle) - friction * math.cos(angle))
    expected = pull if share is None else share * G * math.sin(angle)
    assert now.x * math.cos(angle) + now.y * math.sin(angle) == pytest.approx(
        0.5 * expected * 0.01, rel=1e-6
    )


def test_a_pinched_ball_may_hang_or_fall() -> None:
    """Between two walls that narrow upwards by less than twice the angle of friction."""
    walls = [
        Contact(math.cos(0.1), math.sin(0.1), 0.5),
        Contact(-math.cos(0.1), math.sin(0.1), 0.5),
    ]
    found = motions(solutions(walls, Velocity(0.0, G, 0.0), R))
    assert sorted(round(v.vy, 6) for v in found) == [0.0, G]
    assert (
        len(
            motions(solutions([c._replace(friction=0.05) for c in walls], Velocity(0.0, G, 0.0), R))
        )
        == 1
    )


def bodies(board: Board) -> list[Body]:
    peg = combine(board.ball.material, board.peg_material)
    wall = combine(board.ball.material, board.wall_material)
    return [
        Body(p.x, p.y, 0.0, 0.0, p.radius, peg.restitution, peg.friction) for p in board.pegs
    ] + [Body(w.x1, w.y1, w.x2, w.y2, 0.0, wall.restitution, wall.friction) for w in board.walls]


@pytest.mark.long
@pytest.mark.parametrize("case", tries(CASES[1:4], CASES))
def test_balls_that_meet_two_surfaces_land_where_the_steps_do(case: dict[str, Any]) -> None:
    board = Board.from_json(case["board"])
    exact = drop(board, case["seed"])
    world = World(bodies(board), board.gravity, board.drag, board.ball.radius)
    now = Motion(exact.x_start, board.drop.y, STILL)
    while now.y < board.bins.y:
        now = step(world, now, 1e-4)
    assert now.x == pytest.approx(exact.x_end, abs=1e-3)


# A ball at rest on two surfaces, with spin.


@pytest.mark.long
def test_a_spinning_ball_follows_the_only_solution_of_the_laws() -> None:
    """Without any, an impulse stops the spin. With several, see below."""
    choice, seen = Random("corner 1"), set()
    for _ in range(STATES):
        made, omega = corner(choice), spin(choice)
        found = made.solutions(omega)
        acceleration, left = made.acceleration(omega)
        seen.add(len(found))
        if not found:
            assert left == 0.0, made
        elif len(found) == 1:
            law = found[0].velocity
            assert acceleration == pytest.approx([law.vx, law.vy], abs=1e-3 * G), made
        else:
            assert any(map(holds, found)), made
            pressed = any(ny < 0.0 for _, ny in made.normals)
            assert np.hypot(*acceleration) == pytest.approx(0.0 if pressed else G, abs=1e-3), made
    assert {0, 1} < seen


@pytest.mark.long
def test_time_steps_take_the_same_path_where_there_is_one_solution() -> None:
    choice = Random("stepped")
    for _ in range(STEPPED):
        made, omega = corner(choice), spin(choice)
        if len(made.solutions(omega)) == 1:
            assert steps_agree(made, Velocity(0.0, 0.0, omega)), (made, omega)


@pytest.mark.parametrize(
    ("made", "omega", "count"), [(*HOLDS_OR_OPENS, 2), (*HOLDS_OR_OPENS_EITHER, 3)]
)
def test_where_holding_and_opening_fit_the_laws_the_ball_holds(
    made: Corner, omega: float, count: int
) -> None:
    assert len(made.solutions(omega)) == count
    acceleration, left = made.acceleration(omega)
    assert acceleration.tolist() == [0.0, 0.0]
    assert left == omega
    assert not steps_agree(made, Velocity(0.0, 0.0, omega))  # they open a contact


def test_a_ball_that_no_surface_carries_falls_although_friction_could_hold_it() -> None:
    made, omega = HOLDS_OR_FALLS
    found = made.solutions(omega)
    assert [holds(s) for s in found].count(True) == 1
    assert len(found) == 2
    acceleration, _ = made.acceleration(omega)
    assert acceleration == pytest.approx([0.0, G], abs=1e-6)


def test_no_or_several_solutions_need_surfaces_that_are_nearly_parallel() -> None:
    """The angle between them is less than the difference of the two angles of friction."""
    choice, seen = Random("corner 1"), Counter[bool]()
    for _ in range(tries(300, 5000)):
        made, omega = corner(choice), spin(choice)
        between = math.radians(made.degrees[0] - made.degrees[1])
        first, second = map(math.atan, made.friction)
        is_parallel = abs(math.remainder(between, math.pi)) < abs(first - second)
        is_one = len(made.solutions(omega)) == 1
        seen[is_one] += 1
        assert is_one or is_parallel, made
        assert made.coupling(omega) <= 1.0 or is_parallel, made
    assert seen[False] > 1


def test_sweeps_do_not_find_the_only_solution_where_eigenvalues_are_complex() -> None:
    """The ball holds. Sweeps over the contacts swing between the two, ever farther."""
    made, omega = Corner((30.0, -67.0), (0.0, 0.0), (1.8, 1.8)), 1.0
    assert made.coupling(omega) < -1.0
    (law,) = made.solutions(omega)
    assert holds(law)
    assert made.acceleration(omega)[0].tolist() == [0.0, 0.0]
    assert swept(made.contacts(-1), Velocity(0.0, 1e-6 * G, omega), R) is None


# A ball at rest on two surfaces, without spin.


@pytest.mark.long
def test_a_ball_without_spin_moves_if_the_laws_allow_it() -> None:
    """Surfaces could also pinch it: friction of one, because of the push of the other. Nothing
    has pressed it in so far."""
    choice, seen = Random("still"), set()
    for _ in range(STATES):
        made = corner(choice)
        found = motions(made.solutions(0.0))
        moving = [law for law in found if math.hypot(law.vx, law.vy) > 1e-6]
        assert len(moving) <= 1, made
        path: Trajectory = made.path(STILL)
        seen.add((len(found), len(moving)))
        if not moving:
            assert (path.outcome, path.end[body.T]) == (WEDGED, 0.0), made
        else:
            law = moving[0]
            assert made.acceleration(0.0)[0] == pytest.approx([law.vx, law.vy], abs=1e-3 * G), made
    assert seen == {(1, 0), (1, 1), (2, 1)}


# A plastic ball that runs into the corner.


@pytest.mark.long
def test_plastic_impulses_in_turn_are_mostly_those_at_once() -> None:
    """With friction in nearly nine of ten cases."""
    choice, others = Random("running into"), 0
    for _ in range(STATES):
        made, start = runs_into(choice)
        after, at_once = hit(made, start)
        assert at_once, made
        others += after is None or not any(is_alike(after, other) for other in at_once)
    assert others <= 0.15 * STATES


def test_without_friction_plastic_impulses_in_turn_are_those_at_once() -> None:
    """If they end: between nearly parallel surfaces they do not."""
    choice, ended = Random("smooth"), 0
    for _ in range(60):
        made, start = runs_into(choice)
        after, at_once = hit(Corner(made.degrees, made.pegs, (0.0, 0.0)), start)
        if after is not None:
            ended += 1
            assert any(is_alike(after, other) for other in at_once), made
    assert ended > 50
