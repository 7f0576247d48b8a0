"""Free flight under gravity and linear drag, in closed form.

In free flight dv/dt = g - k v, with the drag k in 1/s. Let a0 = g - k v0 be the acceleration at the
start, and s the time since then:

    a(s) = a0 exp(-k s)        v(s) = v0 + a0 phi(s)        r(s) = r0 + v0 s + a0 psi(s)

    phi(s) = (1 - exp(-k s)) / k        psi(s) = (s - phi(s)) / k

Without drag, phi = s and psi = s^2 / 2. No library's exponential is called, because libraries
differ between machines.
"""

import numpy as np
import numpy.typing as npt

from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.physics import body

# psi(s) = s^2 phi2(k s), phi2(z) = sum over n of (-z)^n / (n + 2)!. The first omitted term is
# z^11 / 13!. Up to z = 0.2427 it is below half a unit in the last place of phi2 > 0.46, which is
# 2.8e-17; at z = 1/4 it is 3.9e-17, 0.7 units.
SERIES_LIMIT = 0.25

_C0 = 1.0 / 2.0
_C1 = 1.0 / 6.0
_C2 = 1.0 / 24.0
_C3 = 1.0 / 120.0
_C4 = 1.0 / 720.0
_C5 = 1.0 / 5040.0
_C6 = 1.0 / 40320.0
_C7 = 1.0 / 362880.0
_C8 = 1.0 / 3628800.0
_C9 = 1.0 / 39916800.0
_C10 = 1.0 / 479001600.0


@inner_kernel
def phi2(z: float) -> float:
    """(z - 1 + exp(-z)) / z^2 for 0 <= z <= SERIES_LIMIT, to rounding."""
    w = z * z
    even = _C0 + w * (_C2 + w * (_C4 + w * (_C6 + w * (_C8 + w * _C10))))
    odd = _C1 + w * (_C3 + w * (_C5 + w * (_C7 + w * _C9)))
    return even - z * odd


@lean_kernel
def short_basis(k: float, s: float) -> tuple[float, float, float]:
    """`basis` for k s <= SERIES_LIMIT, which holds within a search window."""
    if k == 0.0:
        return 1.0, s, 0.5 * s * s
    psi = s * s * phi2(k * s)
    phi = s - k * psi
    return 1.0 - k * phi, phi, psi


HALF_WAY = 0.503
"""All points of a path lie within this share of its length l from the point of `half_chord`.

For each point P of a path from A to B, |PA| + |PB| <= l: P lies in an ellipse about the middle of
AB with semi-major axis l / 2. The terms that `half_chord` omits move that middle by at most
|a| s^2 z^2 / 48, with z = k s <= 1/4 and |a| s^2 / 2 <= l, so by at most l / 384."""


@lean_kernel
def half_chord(k: float, s: float) -> tuple[float, float]:
    """s / 2 and about psi(s) / 2 for k s <= SERIES_LIMIT: the first two terms of psi's series.

    r0 + v0 s / 2 + a0 psi(s) / 2 is the middle between the path's start and end.
    """
    half = 0.5 * s
    return half, half * half * (1.0 - k * s * (1.0 / 3.0))


@inner_kernel
def basis(k: float, s: float) -> tuple[float, float, float]:
    """exp(-k s), phi(s) and psi(s) for a drag k >= 0 in 1/s and a time s >= 0 in s.

    Beyond the series' range, the time is halved until it fits, and the results are doubled back:
    psi(2s) = psi + phi s + exp(-k s) psi, phi(2s) = phi + exp(-k s) phi. All terms are positive,
    so nothing cancels.
    """
    h = s
    doublings = 0
    while k * h > SERIES_LIMIT:
        h *= 0.5
        doublings += 1
    decay, phi, psi = short_basis(k, h)
    for _ in range(doublings):
        psi = psi + phi * h + decay * psi
        phi = phi + decay * phi
        decay = decay * decay
        h = h + h
    return decay, phi, psi


@inner_kernel
def advance_flight(state: npt.NDArray[np.float64], gravity: float, k: float, s: float) -> None:
    """Move a state in free flight by s seconds."""
    ax = -k * state[body.VX]
    ay = gravity - k * state[body.VY]
    _, phi, psi = basis(k, s)
    state[body.T] += s
    state[body.X] = state[body.X] + state[body.VX] * s + ax * psi
    state[body.Y] = state[body.Y] + state[body.VY] * s + ay * psi
    state[body.VX] = state[body.VX] + ax * phi
    state[body.VY] = state[body.VY] + ay * phi
    state[body.THETA] = state[body.THETA] + state[body.OMEGA] * s
