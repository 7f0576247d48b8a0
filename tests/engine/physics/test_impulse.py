"""Impacts: restitution, Coulomb friction with spin, and no gain of energy."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.engine.physics.impulse import bounce

RADIUS = 0.1

velocities = st.floats(-20.0, 20.0)
spins = st.floats(-200.0, 200.0)
angles = st.floats(0.0, 2.0 * math.pi)
restitutions = st.floats(0.0, 1.0)
frictions = st.one_of(st.just(0.0), st.floats(1e-3, 3.0))


def energy(vx: float, vy: float, omega: float) -> float:
    """Energy per mass in J/kg: v^2 / 2 and, with I = m R^2 / 2, (R omega)^2 / 4."""
    return 0.5 * (vx * vx + vy * vy) + 0.25 * (RADIUS * omega) ** 2


@given(velocities, spins, st.floats(0.01, 20.0), angles, restitutions, frictions)
def test_an_impact_obeys_newton_coulomb_and_never_gains_energy(
    along: float, omega: float, into: float, angle: float, e: float, mu: float
) -> None:
    nx, ny = math.cos(angle), math.sin(angle)
    vx, vy = -into * nx - along * ny, -into * ny + along * nx
    ux, uy, spin, sticks = bounce(vx, vy, omega, nx, ny, RADIUS, e, mu)

    assert ux * nx + uy * ny == pytest.approx(e * into, abs=1e-12 * (into + abs(along)))
    pushed = (uy * nx - ux * ny) - along  # tangential impulse per mass
    limit = mu * (1.0 + e) * into
    slip_before = along - omega * RADIUS
    slip_after = (uy * nx - ux * ny) - spin * RADIUS
    rounding = 1e-12 * (into + abs(along) + RADIUS * abs(omega))
    assert abs(pushed) <= limit + rounding
    assert pushed * slip_before <= rounding
    assert spin - omega == pytest.approx(-2.0 * pushed / RADIUS, abs=20.0 * rounding)
    if sticks:
        assert abs(slip_after) <= rounding  # it sticks
        assert abs(slip_before) / 3.0 <= limit + rounding
    elif mu > 0.0:
        assert abs(pushed) == pytest.approx(limit, abs=rounding)  # it slips during the whole impact
        assert slip_after * slip_before >= -rounding * abs(slip_before)
    assert energy(ux, uy, spin) <= energy(vx, vy, omega) * (1.0 + 1e-13)


@given(velocities, spins, st.floats(0.01, 20.0), angles, restitutions)
def test_without_friction_spin_and_tangential_velocity_stay(
    along: float, omega: float, into: float, angle: float, e: float
) -> None:
    nx, ny = math.cos(angle), math.sin(angle)
    vx, vy = -into * nx - along * ny, -into * ny + along * nx
    ux, uy, spin, sticks = bounce(vx, vy, omega, nx, ny, RADIUS, e, 0.0)
    assert spin == omega
    assert not sticks
    assert uy * nx - ux * ny == pytest.approx(along, abs=1e-13 * (into + abs(along)))


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_a_vertical_bounce_on_a_level_floor_has_the_closed_form(e: float) -> None:
    vx, vy, omega, sticks = bounce(0.0, 4.0, 0.0, 0.0, -1.0, RADIUS, e, 0.5)
    assert (vx, omega, sticks) == (0.0, 0.0, True)
    assert vy == pytest.approx(-4.0 * e, rel=1e-15, abs=1e-15)


def test_sticking_shares_the_slip_between_velocity_and_spin() -> None:
    """A slip of 3 m/s changes a disc's velocity by a third of it and its spin by two thirds."""
    vx, vy, omega, sticks = bounce(3.0, 1.0, 0.0, 0.0, -1.0, RADIUS, 0.0, 10.0)
    assert sticks
    assert (vx, vy) == pytest.approx((2.0, 0.0))
    assert omega == pytest.approx(20.0)  # clockwise on the screen: it rolls to the right
