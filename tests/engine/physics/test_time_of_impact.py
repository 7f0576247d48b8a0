"""The time of an impact: no impact is missed, early, or in the past."""

import math
from math import sqrt
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from plinko.engine.physics.circle_impact import (
    Motion,
    circle_hit_after_leaving,
    circle_hit_again,
    circle_search,
    third_derivative_bound,
)
from plinko.engine.physics.flight import SERIES_LIMIT, basis
from plinko.engine.physics.line_impact import line_hit, line_hit_again
from plinko.engine.physics.time_of_impact import NO_HIT, halley_step, minorant_root

mp = mpmath.MPContext()
mp.dps = 40
HORIZON = 0.05  # s, at most SERIES_LIMIT / k for the drags below


def quantities(most: float) -> st.SearchStrategy[float]:
    """Numbers that are 0 or whose square does not underflow, which the search would treat as 0.

    At 2.7e-175 m/s towards a circle, for example, it gives up too early; no real ball is so slow.
    """
    return st.floats(-most, most).map(lambda value: 0.0 if abs(value) < 1e-100 else value)


speeds = quantities(20.0)
accelerations = quantities(50.0)
drags = st.sampled_from([0.0, 0.02, 0.5, 2.2, 5.0])
offsets = quantities(1.0)


def position(q: float, v: float, a: float, k: float, s: Any) -> Any:
    """One coordinate of a flight after s, in forty digits."""
    s = mp.mpf(s)
    psi = s * s / 2 if k == 0.0 else (s + mp.expm1(-k * s) / k) / k
    return q + mp.mpf(v) * s + mp.mpf(a) * psi


Arguments = tuple[float, float, float, float, float, float, float, float]


class Circle:
    """f(s) = |q(s)|^2 - d2 for a flight past a circle, and the rounding error of f in float64."""

    def __init__(self, q: Any, v: Any, a: Any, k: float, d2: float) -> None:
        self.arguments: Arguments = (*q, *v, *a, k, d2)
        self.rounding = 1e-15 * (q[0] ** 2 + q[1] ** 2 + d2)

    def __call__(self, s: Any) -> Any:
        qx, qy, vx, vy, ax, ay, k, d2 = self.arguments
        return position(qx, vx, ax, k, s) ** 2 + position(qy, vy, ay, k, s) ** 2 - mp.mpf(d2)

    def lowest(self, end: float, points: int = 300) -> float:
        """The smallest f at evenly spaced times in [0, end], in float64."""
        qx, qy, vx, vy, ax, ay, k, d2 = self.arguments
        s = np.linspace(0.0, end, points)
        psi = np.array([basis(k, float(t))[2] for t in s])
        return float((((qx + vx * s + ax * psi) ** 2 + (qy + vy * s + ay * psi) ** 2) - d2).min())


def first_entry(
    qx: float, qy: float, vx: float, vy: float, ax: float, ay: float, k: float, d2: float,
    horizon: float, best: float,
) -> float:  # fmt: skip
    """When a ball outside a circle enters it, or NO_HIT."""
    low3 = third_derivative_bound(
        vx * ax + vy * ay, ax * ax + ay * ay, qx * ax + qy * ay, k, horizon
    )
    f, fd = qx * qx + qy * qy - d2, 2.0 * (qx * vx + qy * vy)
    fdd = 2.0 * (vx * vx + vy * vy + qx * ax + qy * ay)
    motion = Motion(qx, qy, vx, vy, ax, ay, k)
    return circle_search(motion, d2, horizon, best, 0.0, f, fd, fdd, low3)


@given(offsets, offsets, speeds, speeds, accelerations, accelerations, drags, st.floats(0.01, 1.0))
@example(-0.2, -0.1, 10.0, 0.0, 0.0, 9.81, 2.2, 0.1)
def test_the_first_entry_into_a_circle_is_found(
    qx: float, qy: float, vx: float, vy: float, ax: float, ay: float, k: float, distance: float
) -> None:
    d2 = distance * distance
    assume(qx * qx + qy * qy > d2 * (1.0 + 1e-9))
    f = Circle((qx, qy), (vx, vy), (ax, ay), k, d2)
    s = first_entry(*f.arguments, HORIZON, HORIZON)
    if s == NO_HIT:
        assert f.lowest(HORIZON) > -f.rounding
        return
    assert 0.0 <= s <= HORIZON
    assert abs(f(s)) <= f.rounding
    assert f.lowest(s) > -f.rounding


@given(st.floats(0.05, 0.5), st.floats(-12.0, -3.0), st.floats(1.0, 30.0), drags, st.booleans())
def test_a_grazing_hit_is_found_and_a_near_miss_is_not(
    distance: float, exponent: float, speed: float, k: float, hits: bool
) -> None:
    """A straight flight past a circle, which overlaps or misses it by 1e-12 to 1e-3 of its size."""
    overlap = 10.0**exponent * distance
    y = -(distance - overlap if hits else distance + overlap)
    d2 = distance * distance
    x = -0.5 * speed * HORIZON - distance
    assume(x + speed * HORIZON > 0.0)
    s = first_entry(x, y, speed, 0.0, 0.0, 0.0, k, d2, HORIZON * 4, HORIZON * 4)
    assert (s != NO_HIT) is hits
    if hits:
        half = mp.sqrt(mp.mpf(d2) - mp.mpf(y) ** 2)
        rounding = 4e-16 * (x * x + d2)  # of the squares at the start of the search
        assert abs(mp.mpf(x) + mp.mpf(speed) * s + half) < rounding / float(half) + 1e-15


@given(offsets, offsets, speeds, speeds, accelerations, accelerations, drags)
def test_a_ball_that_leaves_a_circle_is_not_held_by_it(
    qx: float, qy: float, vx: float, vy: float, ax: float, ay: float, k: float
) -> None:
    """The ball starts in contact: the touch at time 0 is not an impact, but its return is."""
    d2 = qx * qx + qy * qy
    assume(d2 > 1e-4 and qx * vx + qy * vy > 1e-6)
    s = circle_hit_again(qx, qy, vx, vy, ax, ay, k, HORIZON, HORIZON)
    f = Circle((qx, qy), (vx, vy), (ax, ay), k, 0.0)
    start = f(0)

    def gap(t: float) -> float:
        """(|q(t)|^2 - |q(0)|^2) / t in float64, from forty digits."""
        return float((f(t) - start) / mp.mpf(t))

    scale = 1e-14 * (math.sqrt(d2) * math.hypot(vx, vy) + d2 / HORIZON)
    end = HORIZON if s == NO_HIT else s
    assert s == NO_HIT or s > 0.0
    assert min(gap(end * i / 60) for i in range(1, 61)) > -scale
    if s != NO_HIT:
        assert abs(gap(s)) <= scale


@pytest.mark.parametrize("velocity", [(0.0, 1.0), (3.0, 0.0), (3.0, 0.5)])
def test_a_ball_driven_into_the_circle_it_touches_hits_at_once(
    velocity: tuple[float, float],
) -> None:
    """The ball is on top of a circle (y points down) and falls, or moves too slowly to take off."""
    vx, vy = velocity
    assert circle_hit_again(0.0, -1.0, vx, vy, 0.0, 9.81, 0.0, HORIZON, HORIZON) == 0.0


def test_a_ball_too_fast_for_the_curve_takes_off() -> None:
    assert circle_hit_again(0.0, -1.0, 3.2, 0.0, 0.0, 9.81, 0.0, 0.05, 0.05) == NO_HIT


@pytest.mark.parametrize("k", [0.0, 0.5, 3.0])
def test_a_ball_that_rolled_off_a_peg_does_not_fall_through_it(k: float) -> None:
    """Where the normal force vanishes, v^2 = g D cos, and the ball moves away for good."""
    distance, angle = 0.3, 0.7
    qx, qy = distance * math.sin(angle), -distance * math.cos(angle)
    v = math.sqrt(9.81 * distance * math.cos(angle))
    vx, vy = v * math.cos(angle), v * math.sin(angle)
    s = circle_hit_after_leaving(
        qx, qy, vx, vy, -k * vx, 9.81 - k * vy, k, distance * distance, HORIZON, HORIZON
    )
    assert s == NO_HIT


@given(st.floats(-18.0, 0.0), speeds, accelerations, drags)
@example(-16.4, 0.15021323428929076, -9.371850958322197, 0.0)
def test_a_line_is_hit_when_the_gap_closes(e: float, hd: float, hdd: float, k: float) -> None:
    """This holds for any gap: a ball may leave one wall while it nearly touches another."""
    h = 10.0**e
    s = line_hit(h, hd, hdd, k, HORIZON, HORIZON, 0.0)
    gaps = [position(h, hd, hdd, k, HORIZON * i / 200) for i in range(201)]
    if s == NO_HIT:
        assert min(gaps) > -1e-16
        return
    assert abs(position(h, hd, hdd, k, s)) < 4e-16 * (h + abs(hd) * s)
    assert all(gap > -1e-16 for i, gap in enumerate(gaps) if HORIZON * i / 200 < s)


@given(
    st.floats(-18.0, 2.0).map(lambda e: 10.0**e),
    st.one_of(st.just(0.0), st.floats(-18.0, 2.0).map(lambda e: 10.0**e)),
    st.sampled_from([-1.0, 1.0]),
    st.integers(-500, 500).map(lambda tenths: tenths / 10.0),
)
def test_the_root_of_a_parabola_is_right_to_a_few_units(
    f: float, slope: float, sign: float, m: float
) -> None:
    fd = sign * slope
    exact = mp.mpf(fd) ** 2 - 2 * mp.mpf(m) * mp.mpf(f)
    assume(abs(exact) > 1e-9 * (fd * fd + abs(m) * f))  # except near a double root
    d = minorant_root(f, fd, m)
    if exact < 0 or (fd >= 0.0 and m >= 0.0):
        assert d == NO_HIT
        return
    root = (mp.mpf(fd) + mp.sqrt(exact)) / -m if fd > 0.0 else 2 * f / (mp.sqrt(exact) - fd)
    assert root > 0
    assert abs(d / root - 1) < 1e-12 * (1.0 if abs(exact) > 1e-3 * fd * fd else 1e6)


@given(
    st.floats(-18.0, 2.0).map(lambda e: 10.0**e),
    st.floats(-18.0, 2.0).map(lambda e: -(10.0**e)),
    st.floats(-50.0, 50.0),
)
def test_halleys_step_ends_before_the_root_and_nearly_at_it(f: float, fd: float, m: float) -> None:
    root = minorant_root(f, fd, m)
    step = halley_step(f, fd, m)
    assume(fd * fd != 2.0 * f * m)
    if root == NO_HIT:
        assert step == NO_HIT
        return
    assert 0.0 < step <= root * (1.0 + 1e-14)
    x = mp.mpf(m) * f / (mp.mpf(fd) ** 2)
    left = f + fd * mp.mpf(step) + m * mp.mpf(step) ** 2 / 2
    assert abs(left - f * x * x / (2 - x) ** 2) < 1e-14 * (f + abs(m) * step * step)


@given(st.floats(1e-6, 0.5), st.floats(0.1, 50.0), drags)
def test_a_line_is_hit_again_after_a_bounce(up: float, down: float, k: float) -> None:
    horizon = 4.0 if k == 0.0 else SERIES_LIMIT / k
    s = line_hit_again(up, -down, k, horizon, horizon)
    if s == NO_HIT:
        assert position(0.0, up, -down, k, horizon) > 0
        return
    assert s > 0.0
    assert abs(position(0.0, up, -down, k, s)) < 1e-15 * up * s
    assert position(0.0, up, -down, k, 0.5 * s) > 0


@given(st.floats(0.0, 1e-16), st.floats(0.0, 1e-8), st.floats(1.0, 10.0))
def test_a_touching_ball_rounded_into_a_line_does_not_cross_it(
    depth: float, up: float, down: float
) -> None:
    """It may rise too little to get out of the line; then it hits the line when it falls back."""
    s = line_hit(-depth, up, -down, 0.0, HORIZON, HORIZON, depth)
    assert 0.0 <= s <= 2.0 * up / down * (1.0 + 1e-12)


def test_a_ball_that_moves_along_or_away_never_hits_a_line() -> None:
    assert line_hit(0.1, 0.0, 0.0, 0.0, 10.0, 10.0, 0.0) == NO_HIT
    assert line_hit(0.1, 1.0, 5.0, 0.0, 10.0, 10.0, 0.0) == NO_HIT
    assert line_hit_again(1.0, 5.0, 0.0, 10.0, 10.0) == NO_HIT


@given(offsets, offsets, speeds, speeds, drags, st.floats(0.0, 1.0))
def test_an_earlier_find_ends_the_search_and_changes_no_root(
    qx: float, qy: float, vx: float, vy: float, k: float, share: float
) -> None:
    assume(qx * qx + qy * qy > 0.02)
    arguments = (qx, qy, vx, vy, -k * vx, 9.81 - k * vy, k, 0.01)
    free = first_entry(*arguments, HORIZON, HORIZON)
    best = share * HORIZON
    limited = first_entry(*arguments, HORIZON, best)
    assert limited == (free if free != NO_HIT and free <= best else NO_HIT)


def leap(bend: float, clearance: float) -> tuple[float, float, float, float]:
    """(qx, qy, vx, vy) of a ball that leaves a circle and comes back to it after 0.3 s.

    Without drag, g(s) = f(s) / s is a cubic, whose minimum is `clearance` at 0.3 s. Under 10 m/s^2;
    `bend`, below 1, chooses how fast the ball rises at first. The circle is at the origin.
    """
    gravity, s = 10.0, 0.3
    rise = -bend * 0.5 * gravity**2 * s  # v.a
    vy, qy = rise / gravity, -0.6
    slope = -2.0 * rise * s - 0.75 * gravity**2 * s * s  # g'(0) = |v|^2 + q.a
    vx = sqrt(slope - vy * vy - gravity * qy)
    off = clearance - slope * s - rise * s * s - 0.25 * gravity**2 * s**3  # g(0) = 2 q.v
    return (0.5 * off - qy * vy) / vx, qy, vx, vy


@pytest.mark.parametrize("bend", [0.3, 0.5, 0.7, 0.9, 0.97])
@pytest.mark.parametrize("clearance", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_a_ball_that_just_misses_the_circle_it_left_does_not_hit_it(
    bend: float, clearance: float
) -> None:
    def hit(apart: float) -> float:
        qx, qy, vx, vy = leap(bend, apart)
        return circle_hit_again(qx, qy, vx, vy, 0.0, 10.0, 0.0, 1.0, 1.0)

    assert hit(clearance) == NO_HIT
    assert 0.0 < hit(-clearance) < 0.3
