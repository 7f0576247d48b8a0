"""The textbook laws of impact and of contact, per unit of the ball's mass.

Sources: Goldsmith, Impact (1960), ch. 2; Brach, Mechanical Impact Dynamics (1991), ch. 2.
A fixed body has no inverse mass; a disc has I = m R^2 / 2, so that R^2 m / I = 2.
"""

from tools.oracle.scene import Material, Real

SPIN_TERM = 2  # R^2 m / I of a uniform disc


def impact(
    vx: Real,
    vy: Real,
    omega: Real,
    nx: Real,
    ny: Real,
    radius: Real,
    pair: Material,
) -> tuple[Real, Real, Real]:
    """Velocity and spin right after a hit with normal (nx, ny) pointing to the ball.

    The contact point sits at -R n from the centre and slips at u - omega R along the tangent
    (-ny, nx). Normal impulse j = -(1 + e) v_n; the tangential one stops the slip if Coulomb's
    bound mu j allows, and otherwise has that size, against the slip.
    """
    tx, ty = -ny, nx
    approach = vx * nx + vy * ny
    along = vx * tx + vy * ty
    j = -(1 + pair.restitution) * approach
    rebound = -pair.restitution * approach
    if pair.friction > 0:
        slip = along - omega * radius
        stick = -slip / (1 + SPIN_TERM)
        bound = pair.friction * j
        if abs(stick) <= bound:
            along += stick
            omega = along / radius  # no slip remains: set it exactly
        else:
            rub = bound if slip < 0 else -bound
            along += rub
            omega -= SPIN_TERM * rub / radius
    return rebound * nx + along * tx, rebound * ny + along * ty, omega


def normal_force(g: Real, ny: Real, along: Real, curvature: Real) -> Real:
    """N / m on a surface of this curvature (1/m; 0 for a wall): -g.n - u^2 / D."""
    return -g * ny - along * along * curvature


def rolling_force(g: Real, k: Real, nx: Real, along: Real) -> Real:
    """Friction per mass along the tangent that keeps the slip at zero.

    From u' = g t - k u + f and R omega' = -2 f with u' = R omega': f = -(g t - k u) / 3.
    """
    return -(g * nx - k * along) / (1 + SPIN_TERM)
