"""Closed-form flight against fifty digits."""

import math
from typing import Any

import mpmath
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from plinko.engine.physics import body
from plinko.engine.physics.flight import (
    HALF_WAY,
    SERIES_LIMIT,
    advance_flight,
    basis,
    half_chord,
    phi2,
    short_basis,
)

mp = mpmath.MPContext()
mp.dps = 50

DRAGS = st.floats(-9.0, 3.0).map(lambda e: 10.0**e)  # 1/s


def ulps(value: float, truth: Any) -> float:
    """Error of `value` in ulps of the truth."""
    return float(abs(mp.mpf(value) - truth) / mp.mpf(math.ulp(float(truth))))


def truth(k: float, s: float) -> tuple[Any, Any, Any]:
    """exp(-k s), phi and psi in fifty digits."""
    phi = -mp.expm1(-mp.mpf(k) * s) / k
    return mp.exp(-mp.mpf(k) * s), phi, (mp.mpf(s) - phi) / k


@given(st.floats(1e-6, SERIES_LIMIT))
def test_phi2_is_right_to_three_units_in_the_last_place(z: float) -> None:
    exact = (mp.mpf(z) - 1 + mp.exp(-mp.mpf(z))) / mp.mpf(z) ** 2
    assert ulps(phi2(z), exact) <= 3.0


@given(DRAGS, st.floats(-6.0, math.log10(SERIES_LIMIT) - 1e-9))
def test_within_the_series_errors_are_a_few_units_at_most(k: float, e: float) -> None:
    s = 10.0**e / k
    decay, phi, psi = basis(k, s)
    exact = truth(k, s)
    assert ulps(decay, exact[0]) <= 2.0
    assert ulps(phi, exact[1]) <= 2.0
    assert ulps(psi, exact[2]) <= 4.0


@given(DRAGS, st.floats(math.log10(SERIES_LIMIT), 2.5))
def test_doubling_back_loses_no_more_than_a_digit(k: float, e: float) -> None:
    """The decay is an exception: its relative error grows with k s, as for any exp(-x) of a rounded
    x, but it stays below 1e-16 of the initial velocity."""
    s = 10.0**e / k
    decay, phi, psi = basis(k, s)
    exact = truth(k, s)
    assert ulps(decay, exact[0]) <= 10.0 * k * s + 4.0
    assert ulps(phi, exact[1]) <= 12.0
    assert ulps(psi, exact[2]) <= 14.0


@given(st.floats(0.0, 1e3))
def test_without_drag_it_is_a_parabola_to_the_bit(s: float) -> None:
    assert basis(0.0, s) == (1.0, s, 0.5 * s * s)


@given(st.floats(1e-12, 1e-9), st.floats(0.0, 10.0))
def test_vanishing_drag_tends_to_none(k: float, s: float) -> None:
    for with_drag, without in zip(basis(k, s), basis(0.0, s), strict=True):
        assert math.isclose(with_drag, without, rel_tol=2e-8)


@given(
    st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4),
    st.floats(0.0, SERIES_LIMIT),
    st.floats(1e-3, 1.0),
)
def test_all_of_a_short_flight_is_near_the_middle_of_its_chord(
    motion: list[float], z: float, s: float
) -> None:
    v, a = np.array(motion[:2]), np.array(motion[2:])
    k = z / s
    phi, psi = half_chord(k, s)
    middle = v * phi + a * psi
    way = math.hypot(*v) * s + 0.5 * math.hypot(*a) * s * s
    for part in np.linspace(0.0, s, 33):
        _, _, bend = short_basis(k, float(part))
        assert math.dist(v * part + a * bend, middle) <= HALF_WAY * way * (1.0 + 1e-12)


@given(
    st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4),
    st.floats(0.0, 5.0),
    st.floats(0.0, 3.0),
)
def test_a_flight_satisfies_its_differential_equation(v: list[float], k: float, s: float) -> None:
    """dv/dt = g - k v, by the integral: v(s) - v(0) = g s - k (r(s) - r(0))."""
    state = np.zeros(body.SIZE)
    state[1:5] = v
    state[6] = 3.0
    before = state.copy()
    advance_flight(state, 9.81, k, s)
    moved, gained = state[1:3] - before[1:3], state[3:5] - before[3:5]
    assert np.allclose(gained, np.array([0.0, 9.81]) * s - k * moved, rtol=0.0, atol=1e-13 * 50.0)
    assert state[0] == s
    assert state[5] == 3.0 * s  # drag does not slow the spin
    assert state[6] == 3.0
