"""Taylor series of contact phases: zeros of polynomials, and the equations of motion."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from plinko.engine.physics import contact
from plinko.engine.physics.contact import choose_mode, expand, new_series, step_length
from plinko.engine.physics.series import first_zero, sum_of_magnitudes, value
from plinko.engine.physics.time_of_impact import NO_HIT

Floats = npt.NDArray[np.float64]

# Multiples of 1/64: numpy's companion matrix fails with a leading coefficient of 1e-300.
coefficients = st.lists(st.integers(-640, 640), min_size=3, max_size=12).map(
    lambda numerators: np.array(numerators) / 64.0
)


@given(coefficients, st.floats(0.0, 2.0))
def test_a_polynomial_has_the_value_numpy_gives_it(c: Floats, s: float) -> None:
    bound = sum_of_magnitudes(c, 0, s)
    assert abs(value(c, s) - np.polyval(c[::-1], s)) <= 1e-14 * bound
    assert abs(value(c, s)) <= bound * (1.0 + 1e-14)


@given(coefficients, st.floats(0.01, 2.0))
def test_the_first_zero_is_the_least_root_that_numpy_finds(c: Floats, horizon: float) -> None:
    c[0] = abs(c[0])
    assume(c[0] > 0.0)
    roots = np.roots(c[::-1])
    slope = np.polyval(np.polyder(c[::-1]), roots.real)
    simple = np.abs(slope) > 1e-3  # where numpy's roots are accurate
    assume(simple[np.abs(roots.imag) < 1e-6].all())
    real = np.sort(roots.real[np.abs(roots.imag) < 1e-9])
    inside = real[(real > 0.0) & (real <= horizon)]
    assume(not ((np.abs(real - horizon) < 1e-9) & (real > 0.0)).any())
    s = first_zero(c, 0, horizon)
    if len(inside):
        assert s == pytest.approx(inside[0], rel=1e-9, abs=1e-11)
    else:
        assert s == NO_HIT


@given(coefficients, st.integers(1, 2), st.floats(0.01, 2.0))
def test_known_roots_at_zero_are_divided_out(c: Floats, skip: int, horizon: float) -> None:
    assume(c[0] > 0.0)
    raised = np.concatenate([np.zeros(skip), c])
    assert first_zero(raised, skip, horizon) == pytest.approx(
        first_zero(c, 0, horizon), rel=1e-9, abs=1e-11
    )


@pytest.mark.parametrize("c", [(0.0, 1.0), (-1.0, 5.0), (math.nan, 1.0)])
def test_what_does_not_start_positive_is_zero_at_once(c: tuple[float, ...]) -> None:
    assert first_zero(np.array([*c, 0.0, 0.0]), 0, 1.0) == 0.0


def start(angle: float, u: float, spin: float) -> Floats:
    """Unexpanded series with the state of a ball at `angle` from the top of a circle."""
    series = new_series()
    series[contact.NORMAL_X, 0] = math.sin(angle)
    series[contact.NORMAL_Y, 0] = -math.cos(angle)
    series[contact.SPEED, 0] = u
    series[contact.SPIN, 0] = spin
    return series


def rates(y: Floats, mode: int, sign: float, kappa: float, k: float, mu: float) -> Floats:
    """Right-hand sides of n', u', omega' for y = (nx, ny, u, omega), R = 0.1; from the docstring
    of the laws, not from the series."""
    nx, ny, u, _ = y
    normal = -9.81 * ny - kappa * u * u
    drive = 9.81 * nx - k * u
    force = {
        contact.ROLLING: -drive / 3.0,
        contact.SLIDING: -mu * normal * sign,
        contact.FRICTIONLESS: 0.0,
    }[mode]
    return np.array([-kappa * u * ny, kappa * u * nx, drive + force, -2.0 * force / 0.1])


def runge_kutta(y: Floats, h: float, steps: int, *laws: float) -> Floats:
    """The classical method of order four: an independent integration."""
    mode, rest = int(laws[0]), laws[1:]
    d = h / steps
    for _ in range(steps):
        a = rates(y, mode, *rest)
        b = rates(y + 0.5 * d * a, mode, *rest)
        c = rates(y + 0.5 * d * b, mode, *rest)
        e = rates(y + d * c, mode, *rest)
        y = y + d / 6.0 * (a + 2.0 * b + 2.0 * c + e)
    return y


@pytest.mark.parametrize("mode", [contact.ROLLING, contact.SLIDING, contact.FRICTIONLESS])
@pytest.mark.parametrize("kappa", [0.0, 4.0])
@pytest.mark.parametrize("k", [0.0, 2.0])
def test_the_series_solves_the_equations_of_motion(mode: int, kappa: float, k: float) -> None:
    u, mu = 0.4, 0.3
    spin = u / 0.1 if mode == contact.ROLLING else 1.0
    series = start(0.3, u, spin)
    expand(series, mode, 1.0, contact.Law(kappa, 9.81, k, mu, 0.1))
    h = step_length(series, 0.1, 1.0)
    assert 0.001 < h <= contact.LONGEST_STEP
    first = np.array([math.sin(0.3), -math.cos(0.3), u, spin])
    truth = runge_kutta(first, h, 400, mode, 1.0, kappa, k, mu)
    got = [
        value(series[row], h)
        for row in (contact.NORMAL_X, contact.NORMAL_Y, contact.SPEED, contact.SPIN)
    ]
    assert got == pytest.approx(truth.tolist(), abs=2e-12)
    assert got[0] ** 2 + got[1] ** 2 == pytest.approx(1.0, abs=1e-15)


@given(st.floats(0.0, 1.5), st.floats(-3.0, 3.0), st.floats(-60.0, 60.0), st.floats(0.5, 20.0))
def test_a_step_is_as_short_as_its_truncation_asks(
    angle: float, u: float, spin: float, kappa: float
) -> None:
    series = start(angle, u, spin)
    expand(series, contact.SLIDING, 1.0, contact.Law(kappa, 9.81, 1.0, 0.4, 0.1))
    h = step_length(series, 0.1, 0.05)
    tails = [
        abs(series[row, contact.ORDER]) * h**contact.ORDER
        for row in (contact.NORMAL_X, contact.NORMAL_Y, contact.SPEED)
    ]
    assert max(tails) <= contact.TRUNCATION * (1.0 + 1e-12)
    assert h * sum_of_magnitudes(series[contact.SPEED], 0, h) <= 0.05


def test_a_ball_rolls_slides_or_is_free_as_coulomb_says() -> None:
    free, weak, strong = (contact.Law(0.0, 10.0, 0.0, mu, 0.1) for mu in (0.0, 0.1, 0.5))
    down, up = (0.5, -1.0), (-0.5, -1.0)  # a driving force of 5, a normal force of 10
    assert choose_mode(free, *down, 1.0, 0.0, False) == (contact.FRICTIONLESS, 0.0)
    assert choose_mode(strong, *down, 1.0, 0.0, False) == (contact.SLIDING, 1.0)
    assert choose_mode(strong, *down, 1.0, 20.0, False) == (contact.SLIDING, -1.0)
    assert choose_mode(strong, *down, 1.0, 10.0, True) == (contact.ROLLING, 0.0)
    # rolling needs a third of the driving force as friction: 5/3 > 0.1 * 10
    assert choose_mode(weak, *down, 1.0, 10.0, True) == (contact.SLIDING, 1.0)
    assert choose_mode(weak, *up, 1.0, 10.0, True) == (contact.SLIDING, -1.0)
