"""Contact with two surfaces at once, plastic impacts and long flights, by docs/physics.md."""

from itertools import pairwise
from math import exp, hypot, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.engine import Board, drop
from plinko.engine.board.parts import Bins, DropZone, Peg, Wall
from plinko.engine.constants import KIND_CONTACT_BEGIN, KIND_CONTACT_END, KIND_WALL
from plinko.engine.drops.trajectory import Trajectory, follow
from plinko.engine.exact.outcome import IMPULSE_LIMIT, LANDED
from plinko.engine.exact.two_contacts import MOST_IMPULSES
from plinko.engine.parameters import Exact
from plinko.engine.physics.two_contacts import (
    FALLS,
    GOES_ON_A,
    GOES_ON_B,
    JAMS,
    RESTS,
    SPINS,
    rest_in_notch,
)
from tests.engine.multibody.static_scenes import place

G = 9.81
R = 0.05
NEAR = Bins(6.0, (-3.0, 0.0, 3.0), (1.0, 1.0))
ZONE = DropZone(0.0, 0.0, 0.9)


def at(x: float, y: float, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0) -> np.ndarray:
    return np.array([0.0, x, y, vx, vy, 0.0, omega])


def normals(degrees_a: float, degrees_b: float) -> tuple[float, float, float, float]:
    """Two unit normals from their angles from straight up; positive angles lean right."""
    a, b = np.radians(degrees_a), np.radians(degrees_b)
    return float(np.sin(a)), float(-np.cos(a)), float(np.sin(b)), float(-np.cos(b))


# Of nearly equal directions, numpy's forces have no right digit.
degrees = st.floats(-170.0, 170.0).map(lambda angle: round(angle, 6))


@given(
    degrees,
    degrees,
    st.floats(0.0, 2.0),
    st.floats(0.0, 2.0),
    st.floats(-100.0, 100.0),
)
def test_the_forces_found_are_those_that_hold_or_move_the_ball(
    a: float, b: float, mu_a: float, mu_b: float, omega: float
) -> None:
    ax, ay, bx, by = normals(a, b)
    what, brake = rest_in_notch(G, omega, ax, ay, mu_a, bx, by, mu_b)
    s = np.sign(omega)
    pressed = {"a": -G * ay, "b": -G * by}
    if what == SPINS:
        qa = np.array([ax - s * mu_a * ay, ay + s * mu_a * ax])
        qb = np.array([bx - s * mu_b * by, by + s * mu_b * bx])
        forces = np.linalg.solve(np.column_stack([qa, qb]), [0.0, -G])
        assert (forces > 0.0).all()
        assert brake == pytest.approx(mu_a * forces[0] + mu_b * forces[1], rel=1e-6)
    elif what in {GOES_ON_A, GOES_ON_B}:
        on_a = what == GOES_ON_A
        (nx, ny), (ox, oy) = ((ax, ay), (bx, by)) if on_a else ((bx, by), (ax, ay))
        mu = (mu_a if on_a else mu_b) if mu_a or mu_b else 0.0
        force = pressed["a" if on_a else "b"]
        along = G * nx + s * mu * force
        assert force > 0.0
        assert along * (-ny * ox + nx * oy) >= -1e-9  # away from the other surface
    elif what == FALLS:
        assert max(pressed.values()) <= 0.0
    else:
        assert what in {RESTS, JAMS}
        assert what == RESTS or omega != 0.0


def spun(omega: float) -> tuple[Board, Trajectory]:
    """A spinning ball that starts in the notch of a slope and an upright wall, without velocity."""
    slope, wall = Wall(-1.0, 0.5, 1.0, 1.5), Wall(0.0, -1.0, 0.0, 1.0)
    board = place(walls=(slope, wall), restitution=0.0, friction=0.5, radius=R)
    x = -R  # the ball touches the left side of the wall, and the slope below
    y = 1.0 + 0.5 * x - R * hypot(1.0, 0.5)
    return board, follow(board, at(x, y - 1e-3, omega=omega), Exact())


def test_a_ball_spins_down_in_a_notch_as_the_formula_says() -> None:
    board, path = spun(-40.0)
    begins = [k for k, (kind, _) in enumerate(path.marks) if kind == KIND_CONTACT_BEGIN]
    pairs = [k for k, m in pairwise(begins) if path.events[k, 0] == path.events[m, 0]]
    assert pairs
    first = pairs[0]
    t, x, y, vx, vy, omega = path.events[first]
    assert (vx, vy) == (0.0, 0.0)
    mu = 0.5
    slope = np.array([1.0, -2.0]) / sqrt(5.0)
    wall = np.array([-1.0, 0.0])
    s = np.sign(omega)
    q = [n + s * mu * np.array([-n[1], n[0]]) for n in (slope, wall)]
    forces = np.linalg.solve(np.column_stack(q), [0.0, -board.gravity])
    assert (forces > 0.0).all()
    spins_for = abs(omega) * R / (2.0 * mu * forces.sum())
    later = path.events[first + 2, 0] if first + 2 < len(path.events) else path.end[0]
    assert later - t == pytest.approx(spins_for, rel=1e-9)
    middle = path.states_at(np.array([t + 0.5 * spins_for]))[0]
    assert middle[6] == pytest.approx(0.5 * omega, rel=1e-9)
    assert (middle[1], middle[2]) == pytest.approx((x, y), abs=1e-15)


@pytest.mark.parametrize("lean", [0.05, 0.3, 0.8])
@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
def test_a_plastic_hit_on_an_overhang_lets_the_ball_go_at_once(
    lean: float, friction: float
) -> None:
    overhang = Wall(0.0, 1.0, -lean, 2.0)
    board = place(walls=(overhang,), restitution=0.0, friction=friction, radius=R)
    path = follow(board, at(0.4, 0.8, vx=-2.0), Exact())
    hits = [
        t for t, (kind, _) in zip(path.events[:, 0], path.marks, strict=True) if kind == KIND_WALL
    ]
    assert path.outcome == LANDED
    assert 1 <= len(hits) <= 3


def test_nearly_parallel_overhangs_end_a_drop_as_what_they_are_a_limit_of_computing() -> None:
    """In the limit of infinitely many impulses the ball would stop; a board that wedges a ball for
    good is refused."""
    for narrow, outcome in ((1e-1, LANDED), (5e-2, IMPULSE_LIMIT), (1e-2, IMPULSE_LIMIT)):
        walls = (Wall(-0.06, 1.0, -0.06 + narrow, 0.0), Wall(0.06, 1.0, 0.06 - narrow, 0.0))
        board = place(walls=walls, restitution=0.0, friction=0.0, radius=R)
        path = follow(board, at(1e-3, 1.2, vy=-6.0), Exact())
        assert path.outcome == outcome
        assert (path.bin == -1) == (outcome == IMPULSE_LIMIT)
        _, counts = np.unique(path.events[:, 0], return_counts=True)
        assert counts.max() <= MOST_IMPULSES + 4


def test_friction_at_its_limit_rolls_on() -> None:
    """The tangent of the slope is 3 mu, so rolling needs all of the friction, to the last bit."""
    slope = Wall(1.0, 1.0, -1.0, 1.6)
    board = place(walls=(slope,), restitution=0.0, friction=0.1, radius=R, bins=NEAR, drop=ZONE)
    for x in (0.2, 0.5, 0.7):
        found = drop(board, x=x)
        assert found.bin is not None
        assert len(found.impacts) < 10
        assert [int(k) for k in found.impacts["kind"]].count(KIND_CONTACT_END) == 1


@pytest.mark.parametrize("drag", [10.0, 100.0, 1000.0])
def test_a_long_fall_lasts_as_the_closed_form_says(drag: float) -> None:
    board = place(drag=drag, radius=R, bins=NEAR)
    height = board.bins.y - board.drop.y
    found = drop(board, x=0.0)
    assert found.bin is not None
    s = found.duration
    fallen = board.gravity / drag * (s + (exp(-drag * s) - 1.0) / drag)
    speed = board.gravity / drag * (1.0 - exp(-drag * s))
    assert abs(fallen - height) / speed <= 1e-9


def test_a_ball_reaches_terminal_velocity_between_pegs_too() -> None:
    pegs = tuple(Peg(0.1 * i, 1.0 + 0.3 * (i % 2), 0.03) for i in range(-9, 10, 3))
    board = place(
        pegs=pegs, restitution=0.2, friction=0.4, drag=900.0, radius=0.03, bins=NEAR, drop=ZONE
    )
    found = drop(board, x=0.05)
    assert found.bin is not None
    # No ball is faster than the terminal velocity, so the fall takes at least this long.
    assert found.duration >= (board.bins.y - board.drop.y) * 900.0 / board.gravity


def test_a_start_in_a_notch_is_the_same_in_slices() -> None:
    from plinko.engine.drops.sliced import SlicedFlight

    walls = (Wall(-0.5, 0.4, 0.1, 0.9), Wall(0.1, -0.5, 0.1, 0.9))
    board = place(walls=walls, restitution=0.1, friction=0.3, radius=R, bins=NEAR, drop=ZONE)
    whole = drop(board, x=-0.2)
    sliced = SlicedFlight(board, -0.2)
    for _ in range(len(whole.impacts) + 1):
        sliced.advance(1)
    assert np.array_equal(sliced.flight().trajectory.impacts, whole.impacts)
