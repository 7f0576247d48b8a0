"""Carries a small change of a ball's state along its path: the derivatives of the laws of motion.

A tangent is a row (dx, dy, dvx, dvy, domega): the change of the state at a fixed time, per change
of an earlier quantity. An event with the condition g = 0 then comes d tau later. With f the rates
of the state before and after the event, and J the derivative of its law,

    d tau = -(dg . d) / (dg . f_before)
    d_after = J (d_before + f_before d tau) - f_after d tau

(the saltation matrix; Müller, Chaos, Solitons and Fractals 5, 1995).
"""

import numpy as np
import numpy.typing as npt

from plinko.engine.jit.decorator import inner_kernel
from plinko.engine.physics import contact
from plinko.engine.physics.flight import basis
from plinko.engine.physics.series import Series, value

Tangent = npt.NDArray[np.float64]

DX = 0
DY = 1
DVX = 2
DVY = 3
DOMEGA = 4
TANGENT_SIZE = 5

# Rows of a contact's variation: changes of the way along the surface, the speed and the spin.
ALONG = 0
RATE = 1
SPINNING = 2
VARIATION_ROWS = 3


@inner_kernel
def shift(tangent: Tangent, rates: Tangent, s: float) -> None:
    """Turn the change at one time into the change s later, by s times the rates of the state."""
    for i in range(TANGENT_SIZE):
        tangent[i] += rates[i] * s


@inner_kernel
def flight_rates(vx: float, vy: float, gravity: float, k: float, rates: Tangent) -> None:
    """Write the rates of a state in free flight into `rates`."""
    rates[DX] = vx
    rates[DY] = vy
    rates[DVX] = -k * vx
    rates[DVY] = gravity - k * vy
    rates[DOMEGA] = 0.0


@inner_kernel
def through_flight(tangent: Tangent, k: float, s: float) -> None:
    """Carry a tangent through s seconds of flight."""
    decay, phi, _ = basis(k, s)
    tangent[DX] += tangent[DVX] * phi
    tangent[DY] += tangent[DVY] * phi
    tangent[DVX] *= decay
    tangent[DVY] *= decay


@inner_kernel
def delay(tangent: Tangent, nx: float, ny: float, vx: float, vy: float) -> float:
    """Delay of the impact of a ball with velocity (vx, vy) on a surface with normal (nx, ny).

    In s per unit of the tangent.
    """
    approach = nx * vx + ny * vy
    if approach == 0.0:
        return 0.0
    return float(-(nx * tangent[DX] + ny * tangent[DY]) / approach)


@inner_kernel
def bounce_tangent(
    tangent: Tangent,
    vx: float,
    vy: float,
    omega: float,
    nx: float,
    ny: float,
    curvature: float,
    radius: float,
    restitution: float,
    friction: float,
) -> None:
    """Carry a tangent through the impulse of `bounce`; velocity and spin are those before it.

    The tangent must be one at the impact: its change of position is along the surface, and turns
    the normal by the curvature.
    """
    tx = -ny
    ty = nx
    turn = curvature * (tangent[DX] * tx + tangent[DY] * ty)  # dn = turn t, dt = -turn n
    vn = vx * nx + vy * ny
    u = vx * tx + vy * ty
    if vn >= 0.0:
        return  # no impulse
    dvn = tangent[DVX] * nx + tangent[DVY] * ny + turn * u
    du = tangent[DVX] * tx + tangent[DVY] * ty - turn * vn
    jt = 0.0
    djt = 0.0
    if friction > 0.0:
        slip = u - omega * radius
        jt = slip * (-1.0 / 3.0)
        djt = (du - radius * tangent[DOMEGA]) * (-1.0 / 3.0)
        limit = -friction * (1.0 + restitution) * vn
        if abs(jt) > limit:
            sign = 1.0 if jt > 0.0 else -1.0
            jt = sign * limit
            djt = -sign * friction * (1.0 + restitution) * dvn
        tangent[DOMEGA] -= 2.0 * djt / radius
    vn = -restitution * vn
    dvn = -restitution * dvn
    u += jt
    du += djt
    normal = dvn - turn * u
    along = du + turn * vn
    tangent[DVX] = normal * nx + along * tx
    tangent[DVY] = normal * ny + along * ty


@inner_kernel
def contact_rates(
    nx: float,
    ny: float,
    u: float,
    omega: float,
    mode: int,
    slip_sign: float,
    law: contact.Law,
    rates: Tangent,
) -> None:
    """Write the rates of a state in sustained contact, as contact.py has them, into `rates`."""
    curvature, gravity, k, friction, radius = law
    force = contact.normal_force(law, ny, u)
    drive = gravity * nx - k * u
    rate = drive
    turning = 0.0
    if mode == contact.ROLLING:
        rate = drive * (2.0 / 3.0)
        turning = rate / radius
    elif mode == contact.SLIDING:
        friction_force = friction * slip_sign * force
        rate = drive - friction_force
        turning = 2.0 * friction_force / radius
    rates[DX] = -u * ny
    rates[DY] = u * nx
    rates[DVX] = -rate * ny - curvature * u * u * nx
    rates[DVY] = rate * nx - curvature * u * u * ny
    rates[DOMEGA] = turning


@inner_kernel
def through_contact(
    tangent: Tangent,
    series: Series,
    variation: Series,
    s: float,
    mode: int,
    slip_sign: float,
    law: contact.Law,
) -> None:
    """Carry a tangent through s seconds of sustained contact, whose motion is in `series`.

    Components off the surface are dropped. `variation`, shape (3, ORDER + 1), is work space for the
    series of the variational equations, which are computed like those of the motion.
    """
    curvature, gravity, k, friction, radius = law
    nx = series[contact.NORMAL_X]
    ny = series[contact.NORMAL_Y]
    u = series[contact.SPEED]
    along = variation[ALONG]
    rate = variation[RATE]
    spin = variation[SPINNING]
    along[0] = -tangent[DX] * ny[0] + tangent[DY] * nx[0]
    rate[0] = -tangent[DVX] * ny[0] + tangent[DVY] * nx[0]
    spin[0] = rate[0] / radius if mode == contact.ROLLING else tangent[DOMEGA]
    for i in range(contact.ORDER):
        turn_x = 0.0  # changes of gravity's parts along the surface and onto it
        turn_y = 0.0
        square = 0.0
        if curvature > 0.0:
            for j in range(i + 1):
                turn_x -= ny[j] * along[i - j]
                turn_y += nx[j] * along[i - j]
                square += 2.0 * u[j] * rate[i - j]
        share = 1.0 / (i + 1.0)
        drive = gravity * curvature * turn_x - k * rate[i]
        along[i + 1] = rate[i] * share
        if mode == contact.ROLLING:
            rate[i + 1] = drive * share * (2.0 / 3.0)
            spin[i + 1] = rate[i + 1] / radius
        elif mode == contact.SLIDING:
            force = -gravity * curvature * turn_y - curvature * square
            friction_force = friction * slip_sign * force
            rate[i + 1] = (drive - friction_force) * share
            spin[i + 1] = 2.0 * friction_force / radius * share
        else:
            rate[i + 1] = drive * share
            spin[i + 1] = 0.0
    end_x = value(nx, s)
    end_y = value(ny, s)
    moved = value(along, s)
    bend = curvature * value(u, s) * moved
    change = value(rate, s)
    tangent[DX] = -end_y * moved
    tangent[DY] = end_x * moved
    tangent[DVX] = -end_y * change - bend * end_x
    tangent[DVY] = end_x * change - bend * end_y
    tangent[DOMEGA] = value(spin, s)
