"""Impulses at an impact: restitution along the normal, Coulomb friction with spin across it.

Every impulse is per unit mass of the ball. The tangent of a normal n is t = (-n_y, n_x); a ball of
radius R on a fixed surface slips there at u - omega R, where u = v.t. Friction changes v.t by j_t
and omega by -R j_t m / I = -2 j_t / R (solid disc, I = m R^2 / 2).
"""

from engine.jit.decorator import inner_kernel


@inner_kernel
def bounce(
    vx: float,
    vy: float,
    omega: float,
    nx: float,
    ny: float,
    radius: float,
    restitution: float,
    friction: float,
) -> tuple[float, float, float, bool]:
    """Velocity (m/s) and spin (rad/s) of a ball after it hits a fixed surface of normal (nx, ny).

    The arguments are those before; radius in m, restitution e and coefficient of friction mu are
    numbers. The last value says whether friction stopped the slip.

    j_n = -(1 + e) v.n; the tangential impulse that stops the slip, -slip / (1 + m R^2 / I) =
    -slip / 3, is limited by Coulomb's |j_t| <= mu j_n.
    """
    jn = -(1.0 + restitution) * (vx * nx + vy * ny)
    sticks = False
    vx = vx + jn * nx
    vy = vy + jn * ny
    if friction > 0.0:
        slip = vy * nx - vx * ny - omega * radius
        jt = slip * (-1.0 / 3.0)
        limit = friction * jn
        if jt > limit:
            jt = limit
        elif jt < -limit:
            jt = -limit
        else:
            sticks = True
        vx = vx - jt * ny
        vy = vy + jt * nx
        omega = omega - 2.0 * jt / radius
    return vx, vy, omega, sticks
