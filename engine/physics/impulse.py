"""Impulses at an impact: restitution along the normal, Coulomb friction along the tangent.

All impulses are per unit mass of the ball. The tangent of a normal n is t = (-n_y, n_x). A ball of
radius R slips on a fixed surface at u - omega R, where u = v.t. Friction changes v.t by j_t and
omega by -R j_t m / I = -2 j_t / R (solid disc, I = m R^2 / 2).
"""

from plinko.engine.jit.decorator import inner_kernel


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
    """Velocity (m/s) and spin (rad/s) of a ball after an impact on a surface with normal (nx, ny).

    The arguments are velocity and spin before it, the radius in m, the restitution e and the
    coefficient of friction mu. The last result is whether friction stopped the slip.

    j_n = -(1 + e) v.n. The tangential impulse that stops the slip is -slip / (1 + m R^2 / I) =
    -slip / 3; Coulomb's law limits it to |j_t| <= mu j_n.
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
