"""The engine agrees with textbooks of mechanics about bouncing, sliding, rolling and falling.

Sources: Goldstein, Classical Mechanics (bouncing and rolling bodies; the slider on a sphere);
Landau and Lifshitz, Mechanics; Cross, The bounce of a ball, Am. J. Phys. 67 (1999).
"""

import math
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest

from plinko.engine import Drop, drop
from plinko.engine.board.model import Board
from plinko.engine.board.parts import Bins, Peg, Wall
from plinko.engine.constants import (
    KIND_CONTACT_BEGIN,
    KIND_CONTACT_CHANGE,
    KIND_CONTACT_END,
    KIND_PEG,
    KIND_WALL,
)
from tools.oracle.scenes import scene

G = 9.81
RADIUS = 0.1  # m, radius of the ball in the scenes
FLOOR = Wall(-5.0, 1.0, 5.0, 1.0)


def of_kind(played: Drop, kind: int) -> npt.NDArray[np.void]:
    chosen: npt.NDArray[np.void] = played.impacts[played.impacts["kind"] == kind]
    return chosen


@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.7, 0.9])
def test_a_ball_bounces_to_restitution_squared_of_its_height(
    restitution: float,
) -> None:
    played = drop(scene(walls=(FLOOR,), restitution=restitution), x=0.0)
    hits = of_kind(played, KIND_WALL)[:6]
    fall = 1.0 - RADIUS - -1.0
    tops = [0.5 * (a + b) for a, b in pairwise(hits["t"])]
    for bounce, top in enumerate(played.states(tops), start=1):
        height = 1.0 - RADIUS - top["y"]
        assert height == pytest.approx(fall * restitution ** (2 * bounce), rel=1e-12)


def test_a_ball_that_falls_straight_hits_when_galileo_says() -> None:
    played = drop(scene(walls=(FLOOR,)), x=0.0)
    assert played.impacts[0]["t"] == pytest.approx(math.sqrt(2.0 * 1.9 / G), rel=1e-15)


@pytest.mark.parametrize("drag", [0.5, 2.0, 5.0])
def test_a_ball_that_falls_for_long_reaches_terminal_speed(drag: float) -> None:
    deep = Bins(100.0 / drag, (-5.0, 0.0, 5.0), (1.0, 1.0))
    end = drop(scene(bins=deep, drag=drag), x=0.1).impacts[-1]
    assert end["vy"] == pytest.approx(G / drag, rel=1e-12 + math.exp(-drag * end["t"]))
    assert end["vx"] == 0.0


def test_a_little_drag_is_a_little_change_of_the_parabola() -> None:
    """To first order in k, y = g t^2 / 2 - k g t^3 / 6."""
    k, t = 1e-4, 0.5
    played = drop(scene(drag=k), x=0.0)
    fallen = float(played.states([t])["y"][0]) + 1.0
    assert fallen == pytest.approx(G * t**2 / 2 - k * G * t**3 / 6, abs=k**2)


def test_a_frictionless_slider_leaves_a_circle_at_two_thirds() -> None:
    """From rest at the top, cos(theta) = 2/3. Energy conservation corrects for theta0 and speed
    u0."""
    played = drop(scene(pegs=(Peg(0.0, 0.0, 0.4),)), x=1e-4)
    begin, end = of_kind(played, KIND_CONTACT_BEGIN)[0], of_kind(played, KIND_CONTACT_END)[0]
    reach = 0.4 + RADIUS
    assert -end["y"] / reach == pytest.approx(2.0 / 3.0, abs=1e-6)
    speed2 = begin["vx"] ** 2 + begin["vy"] ** 2
    exact = (2.0 * -begin["y"] + speed2 / G) / (3.0 * reach)
    assert -end["y"] / reach == pytest.approx(exact, rel=1e-13)
    assert end["vx"] ** 2 + end["vy"] ** 2 == pytest.approx(G * reach * exact, rel=1e-12)


def test_a_rolling_disc_would_leave_a_circle_at_four_sevenths() -> None:
    """With high friction the ball rolls nearly until it leaves, and slips just before.

    From u^2 = 4/3 g D (1 - cos), rolling would end with N = 0 at cos(theta) = 4/7. Because of the
    slip, the ball leaves at a cosine between 4/7 and the frictionless 2/3.
    """
    played = drop(scene(pegs=(Peg(0.0, 0.0, 0.4),), friction=5.0), x=1e-3)
    end = of_kind(played, KIND_CONTACT_END)[0]
    assert len(of_kind(played, KIND_CONTACT_CHANGE)) == 1
    assert 4.0 / 7.0 - 1e-6 < -end["y"] / (0.4 + RADIUS) < 4.0 / 7.0 + 0.02


@pytest.mark.parametrize("slope", [0.1, 0.25, 0.5])
def test_a_disc_rolls_down_a_slope_at_two_thirds_of_the_pull(slope: float) -> None:
    """a = 2/3 g sin(theta) without slipping, g sin(theta) without friction."""
    wall = Wall(-1.9, -1.9 * slope, 1.9, 1.9 * slope)
    sine = slope / math.hypot(1.0, slope)
    for friction, wanted in ((1.0, 2.0 / 3.0), (0.0, 1.0)):
        played = drop(scene(walls=(wall,), friction=friction), x=-1.0)
        begin, last = of_kind(played, KIND_CONTACT_BEGIN)[0], of_kind(played, KIND_CONTACT_END)[0]
        times = np.linspace(begin["t"], last["t"], 7)[:-1] + 1e-3
        states = played.states(times)
        speeds = np.hypot(states["vx"], states["vy"])
        assert np.diff(speeds) / np.diff(times) == pytest.approx(wanted * G * sine, rel=1e-11)
        if friction > 0.0:
            assert states["omega"] * RADIUS == pytest.approx(speeds, rel=1e-13)


def test_a_disc_slips_if_friction_is_below_a_third_of_the_slope() -> None:
    """Rolling needs mu >= tan(theta) / 3; with less, a = g (sin - mu cos) and the spin lags."""
    slope = 0.6
    for factor, rolls in ((1.001, True), (0.999, False)):
        mu = factor * slope / 3.0
        played = drop(scene(walls=(Wall(-1.9, -1.14, 1.9, 1.14),), friction=mu, drag=0.0), x=-1.0)
        begin, last = of_kind(played, KIND_CONTACT_BEGIN)[0], of_kind(played, KIND_CONTACT_END)[0]
        times = np.linspace(begin["t"], last["t"], 5)[1:-1]
        states = played.states(times)
        slip = np.hypot(states["vx"], states["vy"]) - RADIUS * states["omega"]
        cosine = 1.0 / math.hypot(1.0, slope)
        if rolls:
            assert abs(slip).max() < 1e-12
        else:
            grows = (slope - 3.0 * mu) * G * cosine  # u' - R omega' = g sin - 3 mu g cos
            assert np.diff(slip) / np.diff(times) == pytest.approx(grows, rel=1e-9)


def test_a_glancing_ball_that_sticks_keeps_two_thirds_of_speed() -> None:
    """Without spin before and slip after, u' = 2/3 u and R omega' = u' (Cross 1999, for a disc)."""
    slope = Wall(-1.0, -0.5, 1.0, 0.5)
    hit = drop(scene(walls=(slope,), friction=1.0, restitution=0.5), x=0.0).impacts[0]
    cosine, sine = 2.0 / math.sqrt(5.0), 1.0 / math.sqrt(5.0)
    before = G * hit["t"] * sine
    along = hit["vx"] * cosine + hit["vy"] * sine
    assert along == pytest.approx(2.0 / 3.0 * before, rel=1e-14)
    assert hit["omega"] * RADIUS == pytest.approx(along, rel=1e-14)


def test_a_slipping_impact_costs_mu_times_the_normal_impulse() -> None:
    slope, mu, restitution = Wall(-1.0, -0.5, 1.0, 0.5), 0.05, 0.5
    board = scene(walls=(slope,), friction=mu, restitution=restitution)
    hit = drop(board, x=0.0).impacts[0]
    cosine, sine = 2.0 / math.sqrt(5.0), 1.0 / math.sqrt(5.0)
    fall = G * hit["t"]
    lost = mu * (1.0 + restitution) * fall * cosine
    along = hit["vx"] * cosine + hit["vy"] * sine
    assert along == pytest.approx(fall * sine - lost, rel=1e-13)
    assert hit["omega"] == pytest.approx(2.0 * lost / RADIUS, rel=1e-13)


def test_a_perfect_bounce_off_a_circle_mirrors_the_velocity() -> None:
    played = drop(scene(pegs=(Peg(0.0, 0.0, 0.4),), restitution=1.0), x=0.2)
    hit = of_kind(played, KIND_PEG)[0]
    nx, ny = hit["x"] / 0.5, hit["y"] / 0.5
    fall = G * hit["t"]
    assert hit["vx"] == pytest.approx(-2.0 * fall * ny * nx, rel=1e-13)
    assert hit["vy"] == pytest.approx(fall * (1.0 - 2.0 * ny * ny), rel=1e-12)
    assert math.hypot(hit["vx"], hit["vy"]) == pytest.approx(fall, rel=1e-14)


def test_off_a_slope_of_45_degrees_a_ball_leaves_level() -> None:
    board = scene(walls=(Wall(-0.5, -0.5, 0.5, 0.5),), restitution=1.0)
    hit = drop(board, x=0.0).impacts[0]
    assert hit["vy"] == pytest.approx(0.0, abs=1e-15)
    landing = drop(board, x=0.0).impacts[-1]
    fall_time = math.sqrt(2.0 * (2.0 - hit["y"]) / G)
    assert landing["t"] - hit["t"] == pytest.approx(fall_time, rel=1e-14)
    assert landing["x"] == pytest.approx(hit["vx"] * fall_time, rel=1e-14)


@pytest.mark.parametrize("gravity", [1.62, 3.72, 24.79])
def test_another_world_is_the_same_but_slower_or_faster(gravity: float) -> None:
    """Without drag, times are proportional to 1 / sqrt(g); the path does not depend on g."""

    def board(g: float) -> Board:
        pegs = (Peg(0.0, 0.0, 0.2), Peg(0.9, 0.6, 0.3), Peg(-0.6, 0.8, 0.3))
        return scene(pegs=pegs, restitution=0.6, friction=0.2, gravity=g)

    here, there = drop(board(G), x=0.05), drop(board(gravity), x=0.05)
    pace = math.sqrt(G / gravity)
    assert here.bin == there.bin
    assert there.impacts["x"] == pytest.approx(here.impacts["x"], abs=1e-11)
    assert there.impacts["t"] == pytest.approx(here.impacts["t"] * pace, rel=1e-12)
