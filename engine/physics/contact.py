"""The motion of a ball that rolls or slides on a surface, as a power series in time.

On a surface of curvature kappa (1/D on a circle, 0 on a line) with unit normal n towards the ball
and tangent t = (-n_y, n_x), the centre moves at v = u t and, per unit mass,

    n' = kappa u t                      N = -g.n - kappa u^2          (normal force)
    u' = g.t - k u + F                  omega' = -2 F / R             (friction force F)

    rolling   u = omega R, so F = -(g.t - k u) / 3, possible while |F| <= mu N
    sliding   F = -mu N sign(u - omega R)
    free      F = 0 (a surface without friction)

The right-hand sides are polynomials in the unknowns, so each Taylor coefficient follows from those
before it by sums of products, to any order and without trigonometry (Jorba and Zou, Experimental
Mathematics 14, 2005). Every event of a contact phase is the first zero of a polynomial made from
these series.
"""

from typing import NamedTuple

import numpy as np

from plinko.engine.jit.decorator import inner_kernel
from plinko.engine.physics.series import Series, sum_of_magnitudes

ORDER = 20
"""Degree of the series. With 20, a ball rolls off a circle in about ten steps."""

# Rows of the series, shape (ROWS, ORDER + 1).
NORMAL_X = 0
NORMAL_Y = 1
SPEED = 2
SPIN = 3
ANGLE = 4
PATH = 5  # length travelled along t since the start of the step, m
FORCE = 6  # normal force N per unit mass
SCRATCH = 7  # the function whose zero is an event
ROWS = 8

ROLLING = 0
SLIDING = 1
FRICTIONLESS = 2
HELD = 3  # spinning at rest between two surfaces

LONGEST_STEP = 0.25
"""s. Longer steps would never pass the truncation test on a circle of ordinary size."""

TRUNCATION = 6.9e-18
"""Bound of the sum of the last two terms of each series, 2^-57: below rounding. For the normal (1),
the speed (m/s), and the spin times the radius (m/s)."""


class Law(NamedTuple):
    """What decides the motion of a ball of this radius on a surface, in SI units."""

    curvature: float
    gravity: float
    drag: float
    friction: float
    radius: float


@inner_kernel
def expand(series: Series, mode: int, slip_sign: float, law: Law) -> None:
    """Fill rows NORMAL_X to FORCE of `series` from their first column.

    slip_sign is the sign of u - omega R while sliding.
    """
    curvature, gravity, drag, friction, radius = law
    nx = series[NORMAL_X]
    ny = series[NORMAL_Y]
    u = series[SPEED]
    spin = series[SPIN]
    force = series[FORCE]
    for i in range(ORDER + 1):
        turn_x = 0.0
        turn_y = 0.0
        square = 0.0
        if curvature > 0.0:
            for j in range(i + 1):
                turn_x += u[j] * ny[i - j]
                turn_y += u[j] * nx[i - j]
                square += u[j] * u[i - j]
        force[i] = -gravity * ny[i] - curvature * square
        if i == ORDER:
            break
        share = 1.0 / (i + 1.0)
        nx[i + 1] = -curvature * turn_x * share
        ny[i + 1] = curvature * turn_y * share
        drive = gravity * nx[i] - drag * u[i]
        if mode == ROLLING:
            u[i + 1] = drive * share * (2.0 / 3.0)
            spin[i + 1] = u[i + 1] / radius
        elif mode == SLIDING:
            friction_force = friction * slip_sign * force[i]
            u[i + 1] = (drive - friction_force) * share
            spin[i + 1] = 2.0 * friction_force / radius * share
        else:
            u[i + 1] = drive * share
            spin[i + 1] = 0.0
        series[ANGLE, i + 1] = spin[i] * share
        series[PATH, i + 1] = u[i] * share


@inner_kernel
def normal_force(law: Law, ny: float, u: float) -> float:
    """The normal force per unit mass, m/s^2."""
    return -law.gravity * ny - law.curvature * u * u


@inner_kernel
def hold(series: Series, spin_rate: float) -> None:
    """Fill the same rows for a ball at rest whose spin changes at a constant rate, in rad/s^2."""
    for row in range(FORCE + 1):
        for i in range(1, ORDER + 1):
            series[row, i] = 0.0
    series[SPIN, 1] = spin_rate
    series[ANGLE, 1] = series[SPIN, 0]
    series[ANGLE, 2] = 0.5 * spin_rate


@inner_kernel
def step_length(series: Series, radius: float, travel: float) -> float:
    """Longest step, in s, on which the series are exact to rounding and the ball moves <= travel.

    The second condition lets one cell of the grid list all surfaces that the ball may touch.
    """
    last = 0.0
    before = 0.0
    for row in range(SPIN + 1):
        scale = radius if row == SPIN else 1.0
        last = max(last, scale * abs(series[row, ORDER]))
        before = max(before, scale * abs(series[row, ORDER - 1]))
    h = LONGEST_STEP
    while True:
        power = 1.0
        for _ in range(ORDER - 1):
            power *= h
        if (
            power * (before + last * h) <= TRUNCATION
            and h * sum_of_magnitudes(series[SPEED], 0, h) <= travel
        ):
            return h
        h *= 0.5


def new_series() -> Series:
    """Work space for the series of one contact phase; kernels do not allocate arrays."""
    return np.zeros((ROWS, ORDER + 1))


@inner_kernel
def choose_mode(
    law: Law, nx: float, ny: float, u: float, omega: float, rolls: bool
) -> tuple[int, float]:
    """The mode at the start of a stretch, and the sign of the slip, 0 without slip.

    `rolls`: whether the event before has made the slip zero. Without this, a rounding error of the
    slip would decide between rolling and sliding.
    """
    if law.friction == 0.0:
        return FRICTIONLESS, 0.0
    slip = 0.0 if rolls else u - omega * law.radius
    if slip > 0.0:
        return SLIDING, 1.0
    if slip < 0.0:
        return SLIDING, -1.0
    drive = law.gravity * nx - law.drag * u
    if abs(drive) <= 3.0 * law.friction * normal_force(law, ny, u):
        return ROLLING, 0.0
    return SLIDING, 1.0 if drive > 0.0 else -1.0
