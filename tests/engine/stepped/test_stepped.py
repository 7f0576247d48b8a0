"""The stepped solver: laws of its impacts, no tunnelling, bounded energy, convergence."""

import math
import random
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from benchmarks.scenes.contact_scenes import scene, scene_names
from plinko.engine import Board, ParameterError, World, drop, drop_many
from plinko.engine.board.parts import Peg, Wall
from plinko.engine.constants import KIND_WALL
from plinko.engine.drops.trajectory import Trajectory, at_start, follow
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.outcome import BALANCED, ESCAPED, EVENT_LIMIT, LANDED, TIME_LIMIT
from plinko.engine.parameters import Exact, Stepped
from plinko.engine.physics import body
from plinko.engine.stepped.step import push_out
from tests.engine.exact.test_exact import overlap
from tests.engine.multibody.static_scenes import box, place
from tests.long import tries

Floats = npt.NDArray[np.float64]

G = 9.81


def thrown(x: float, y: float, vx: float, vy: float, omega: float = 0.0) -> Floats:
    """State at time 0 of a ball with a velocity."""
    return np.array([0.0, x, y, vx, vy, 0.0, omega])


# In this example a substep has more impacts than the solver plays, and the ball is frozen.
@example(0.0, 1.0, 0.0, 5.0, 1.0)
@given(
    st.floats(-2.0, 2.0),
    st.floats(0.3, 4.7),
    st.floats(0.0, 2.0 * math.pi),
    st.floats(0.0, 5.0),
    st.sampled_from([0.0, 0.5, 1.0]),
)
def test_nothing_tunnels_at_any_speed(
    x: float, y: float, angle: float, exponent: float, e: float
) -> None:
    """In a closed box with pegs, a ball at up to 100 km/s passes no wall and enters no peg."""
    pegs = tuple(Peg(-1.5 + i, 1.5 + j, 0.05) for i in range(4) for j in range(3))
    board = box(5.0, 5.0, pegs=pegs, restitution=e)
    if overlap(board, np.array([x]), np.array([y])) > 0.0:
        return
    speed = 10.0**exponent
    start = thrown(x, y, speed * math.cos(angle), speed * math.sin(angle))
    path = follow(board, start, Stepped(), max_events=300)
    assert path.outcome in {EVENT_LIMIT, BALANCED, TIME_LIMIT}
    assert overlap(board, path.events[:, 1], path.events[:, 2]) <= 1e-12
    assert overlap(board, path.segments[:, 1], path.segments[:, 2]) <= 1e-12
    states = path.states_at(np.linspace(0.0, min(path.end[0], 2.0), 2000))
    # Between the ends of straight pieces; a piece on a peg's edge is a chord, seen here too.
    assert overlap(board, states[:, 1], states[:, 2]) <= 1e-12
    assert abs(states[:, 1]).max() <= 2.4 + 1e-12


@pytest.mark.parametrize("speed", [1.0, 1e3, 1e5])
def test_a_ball_shot_at_a_thin_wall_stays_on_its_side(speed: float) -> None:
    board = place(walls=(Wall(1.0, -5.0, 1.0, 5.0),), restitution=0.5, radius=1e-3)
    path = follow(board, thrown(0.0, 0.0, speed, 0.0), Stepped(), max_events=1)
    assert path.marks[0].tolist() == [KIND_WALL, 0]
    assert path.events[0, 1] == pytest.approx(0.999, abs=1e-12)
    assert path.events[0, 3] == pytest.approx(-0.5 * speed)


@pytest.mark.parametrize("e", [0.0, 0.25, 0.6, 1.0])
def test_a_vertical_bounce_returns_the_restitution_of_the_speed(e: float) -> None:
    board = place(walls=(Wall(-1.0, 1.0, 1.0, 1.0),), restitution=e)
    path = follow(board, thrown(0.0, 0.0, 0.0, 0.0), Stepped(), max_events=1)
    t, _, y, _, vy, omega = path.events[0]
    before = G * (t + 0.5 * Stepped().h)  # speed on the parabola through the ends of the substeps
    assert vy == pytest.approx(-e * before, rel=1e-12, abs=1e-15)
    assert y == pytest.approx(0.9, abs=1e-12)
    assert omega == 0.0


@pytest.mark.parametrize("mu", [0.0, 0.05, 0.2, 0.3, 1.0])
@pytest.mark.parametrize("spin", [-40.0, 0.0, 25.0])
def test_friction_at_an_impact_is_coulombs_with_spin(mu: float, spin: float) -> None:
    """On a floor the friction impulse is slip / 3, but at most mu (1 + e) v_n."""
    e, radius, down, along = 0.5, 0.1, 3.0, 2.0
    board = place(walls=(Wall(-5.0, 1.0, 5.0, 1.0),), restitution=e, friction=mu, radius=radius)
    path = follow(board, thrown(0.0, 0.85, along, down, spin), Stepped(), max_events=1)
    t, _, _, vx, vy, omega = path.events[0]
    normal = down + G * (t + 0.5 * Stepped().h)
    # Normal (0, -1), tangent (1, 0): the ball's lowest point moves at vx - omega R.
    slip = along - spin * radius
    limit = mu * (1.0 + e) * normal
    impulse = min(max(-slip / 3.0, -limit), limit)
    assert vy == pytest.approx(-e * normal, rel=1e-12)
    assert vx == pytest.approx(along + impulse, rel=1e-12)
    assert omega == pytest.approx(spin - 2.0 * impulse / radius, rel=1e-12)
    sticks = bool(abs(slip) / 3.0 <= limit)
    assert bool(abs(vx - omega * radius) < 1e-12) is sticks


@given(st.floats(0.4, 0.8), st.floats(1e-6, 0.09))
def test_what_overlaps_is_pushed_out_by_the_fraction_asked_for(
    correction: float, depth: float
) -> None:
    for parts in ({"pegs": (Peg(0.0, 0.0, 0.1),)}, {"walls": (Wall(-1.0, 0.1, 1.0, 0.1),)}):
        layout = arrays_of(place(**parts))
        state = np.zeros(body.SIZE)
        state[2] = -(0.2 - depth) if "pegs" in parts else 0.1 - (0.1 - depth)
        before = state[2]
        push_out(layout, state, correction)
        assert before - state[2] == pytest.approx(correction * depth, rel=1e-9, abs=1e-16)
        assert state[1] == 0.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("dt", bad) for bad in (0.0, -1.0 / 60.0, 0.11, math.nan, math.inf, "fast", True)),
        *(("substeps", bad) for bad in (0, -1, 1001, 2.5, "4")),
        *(("correction", bad) for bad in (0.39, 0.81, math.nan)),
        ("solver", "magic"),
    ],
)
def test_a_parameter_out_of_range_is_named_with_its_value(name: str, value: object) -> None:
    board = Board.preset("triangle-8")
    arguments = {"solver": "stepped", name: value}
    for make in (
        lambda: drop(board, 1, **arguments),  # type: ignore[arg-type]
        lambda: drop_many(board, [1], **arguments),  # type: ignore[arg-type]
        lambda: World(board, **arguments),  # type: ignore[arg-type]
    ):
        with pytest.raises(ParameterError) as caught:
            make()
        assert caught.value.field == name
        assert repr(value) in str(caught.value)
        assert name in str(caught.value)


def heights(path: Trajectory) -> Floats:
    """Energy per mass in J/kg, zero at the bins' line, at the ends of the path's pieces."""
    s = path.segments
    spin = 0.25 * (path.board.ball.radius * s[:, 6]) ** 2
    energy: Floats = 0.5 * (s[:, 3] ** 2 + s[:, 4] ** 2) + spin
    energy += path.board.gravity * (path.board.bins.y - s[:, 2])
    return energy


@pytest.mark.parametrize(
    "name", ["triangle-8", "triangle-16", *sorted({*scene_names()} - {"storm", "elastic"})]
)
def test_energy_grows_at_most_by_what_a_substep_of_gravity_gives(name: str) -> None:
    """On these scenes, impacts lose more energy than the method's error adds; without loss, the
    error shows, and falls with the substep."""
    board = scene(name).board if name in scene_names() else Board.preset(name)
    start = board.gravity * (board.bins.y - board.drop.y)
    for seed in range(3):
        energy = heights(drop(board, seed, solver="stepped").trajectory)
        speed = math.sqrt(2.0 * start)
        assert energy.max() <= start + 2.0 * board.gravity * Stepped().h * speed


def test_elastic_impacts_gain_and_lose_no_energy() -> None:
    """Energy on the parabola through the substeps' ends: impacts are on chords below it."""
    h = Stepped().h
    board = box(3.0, 3.0, restitution=1.0)
    path = follow(board, thrown(0.3, 1.0, 1.0, 0.0), Stepped(), max_events=3000)
    t, _, y, vx, vy, _ = path.events.T
    s = t % h
    energy = 0.5 * (vx * vx + vy * vy) + G * (3.0 - y) + 0.5 * G * G * s * (h - s)
    assert len(energy) > 1000
    assert np.ptp(energy) < 1e-9 * energy[0]


def test_the_energy_error_of_elastic_impacts_falls_with_substeps() -> None:
    errors = []
    for substeps in (4, 16, 64):
        path = follow(
            box(3.0, 3.0, restitution=1.0),
            thrown(0.3, 1.0, 1.0, 0.0),
            Stepped(1.0 / 60.0, substeps),
            max_events=30,
        )
        start = 0.5 + G * (3.0 - 1.0)
        energy = 0.5 * (path.events[:, 3] ** 2 + path.events[:, 4] ** 2) + G * (
            3.0 - path.events[:, 2]
        )
        errors.append(float(abs(energy / start - 1.0).max()))
    assert errors[0] < 0.05
    assert errors[2] < errors[1] < errors[0]
    assert errors[2] < 0.2 * errors[0]


def test_it_converges_to_the_exact_path_as_the_step_falls() -> None:
    """Before the second impact, the mean error over many drops halves with the step."""
    board = scene("low-restitution").board
    xs = [drop(board, seed).x_start for seed in range(40)]
    means = []
    for substeps in (2, 4, 8, 16, 32):
        errors = []
        for x in xs:
            start = at_start(board, x)
            exact = follow(board, start, Exact())
            t = 0.5 * (exact.events[0, 0] + exact.events[1, 0])  # between the first two impacts
            truth = exact.states_at(np.array([t]))[0]
            state = follow(board, start, Stepped(1.0 / 60.0, substeps)).states_at(np.array([t]))[0]
            errors.append(math.hypot(state[1] - truth[1], state[2] - truth[2]))
        means.append(float(np.median(errors)))
    assert all(fine < coarse for coarse, fine in pairwise(means))
    order = math.log2(means[0] / means[-1]) / 4.0
    assert 0.8 < order < 1.3


DROPPED, THROWN = np.zeros(3), np.array([0.4, 0.7, 15.0])


def impact_errors(start: Floats, drag: float, solver: Stepped, *, lag: bool) -> Floats:
    """Errors of time, place and velocity of the first impact on a peg.

    lag: whether the ball of the exact solver starts faster by g h / 2, by which the velocities of
    semi-implicit Euler lag.
    """
    pegs = (Peg(0.0, 0.0, 0.1),)
    board = place(pegs=pegs, restitution=0.6, friction=0.2, drag=drag, radius=0.1)
    faster = start + thrown(0.0, 0.0, 0.0, 0.5 * G * solver.h if lag else 0.0)
    exact = follow(board, faster, Exact(), max_events=1).events[0]
    found = follow(board, start, solver, max_events=1).events[0] - exact
    return np.array([abs(found[0]), math.hypot(*found[1:3]), math.hypot(*found[3:5])])


@pytest.mark.long
@pytest.mark.parametrize(("substeps", "correction"), [(1, 0.6), (4, 0.8)])
@pytest.mark.parametrize(
    ("velocity", "drag", "lag", "orders"),
    [
        (THROWN, 0.0, False, (1.0, 1.0, 1.0)),
        (THROWN, 0.0, True, (2.0, 2.0, 2.0)),
        (THROWN, 1.0, True, (1.0, 1.0, 1.0)),
        (DROPPED, 0.0, False, (1.0, 0.0, 2.0)),
    ],
)
def test_an_impact_is_of_second_order_but_for_the_lag_of_the_velocity_and_drag(
    substeps: int, correction: float, velocity: Floats, drag: float, lag: bool,
    orders: tuple[float, float, float],
) -> None:  # fmt: skip
    """The lag makes a dropped ball come later, by half a substep, on the same upright line."""
    choice, halvings, errors = random.Random("one impact"), tries(5, 10), []
    solvers = [Stepped(1.0 / 60.0 / n, substeps, correction) for n in (1, 2**halvings)]
    for _ in range(tries(201, 1001)):
        start = thrown(choice.uniform(-0.15, 0.15), choice.uniform(-1.2, -0.6), *velocity)
        start[body.VX] = -math.copysign(start[body.VX], start[body.X])
        errors.append([impact_errors(start, drag, solver, lag=lag) for solver in solvers])
    first, last = np.median(errors, axis=0)
    for coarse, fine, order in zip(first, last, orders, strict=True):
        if order == 0.0:
            assert max(coarse, fine) < 1e-15
        else:
            assert math.log2(coarse / fine) / halvings == pytest.approx(order, abs=0.15 * order)
    if velocity is DROPPED:
        assert first[0] == pytest.approx(0.5 * solvers[0].h, rel=0.05)


def test_a_free_fall_is_what_semi_implicit_euler_gives() -> None:
    """After n substeps of h, v = n g h and y = n (n + 1) g h^2 / 2; drag has its closed form."""
    h = Stepped().h
    path = follow(place(), thrown(0.0, 0.0, 0.0, 0.0), Stepped())
    state = path.states_at(np.array([100.0 * h]))[0]
    assert state[2] == pytest.approx(100.0 * 101.0 / 2.0 * G * h * h, rel=1e-12)
    terminal = follow(place(drag=2.0), thrown(0.0, 0.0, 0.0, 0.0), Stepped())
    assert terminal.segments[-1, 4] == pytest.approx(G / 2.0, rel=1e-12)


def test_slow_is_not_at_rest() -> None:
    """A ball on a slope of 10^-6 slides off, and a ball at the top of its flight falls."""
    slope = place(walls=(Wall(-0.5, 1.0 - 5e-7, 0.5, 1.0 + 5e-7),), restitution=0.0)
    assert follow(slope, at_start(slope, -0.4), Stepped()).outcome == LANDED
    up = follow(place(), thrown(0.0, 0.0, 0.0, -G * Stepped().h * 100.0), Stepped())
    assert up.outcome == LANDED


def test_a_ball_in_a_notch_does_not_land_and_ends() -> None:
    walls = (Wall(-1.0, 0.2, 0.0, 1.0), Wall(0.0, 1.0, 1.0, 0.2))
    for e in (0.0, 0.5):
        stuck = drop(place(walls=walls, restitution=e, friction=0.1), x=0.0, solver="stepped")
        assert (stuck.bin, stuck.score) == (None, 1.0)
        assert stuck.unsettled
        assert stuck.x_end == pytest.approx(0.0, abs=1e-3)


def test_a_ball_far_out_has_escaped() -> None:
    path = follow(place(), thrown(1e12, 0.0, 0.0, 0.0), Stepped())
    assert path.outcome == ESCAPED
    assert len(path.segments) == 0
    assert path.states_at(np.array([0.0, 5.0]))[:, 1].tolist() == [1e12, 1e12]
