"""Decides what a ball does that rests in a notch between two surfaces a and b and may spin.

n points from a surface to the ball's centre, t = (-n_y, n_x). The centre does not move, so both
contacts slip at -omega R, and friction acts at both in the sense of s = sign(omega):

    g + N_a (n_a + s mu_a t_a) + N_b (n_b + s mu_b t_b) = 0

If both normal forces are positive, the ball spins in the notch, and friction brakes it evenly,

    omega' = -s (2 / R) (mu_a N_a + mu_b N_b),

until it stops. If the angle between the surfaces is less than the difference of their angles of
friction, opening a contact may satisfy the laws too (Painlevé's paradox). Then the contacts hold,
unless both surfaces overhang: forces that balance the weight give no reason why one should open.
The result depends neither on a step nor on the order of the surfaces.

Otherwise a contact may open: the ball continues along one surface if the forces there accelerate it
away from the other, and falls if both surfaces overhang. `docs/physics.md` derives this.
"""

from plinko.engine.jit.decorator import inner_kernel

# What the ball does.
FALLS = 0  # off both surfaces
GOES_ON_A = 1  # rolls or slides along a
GOES_ON_B = 2
SPINS = 3  # in the notch
RESTS = 4  # without spin, for ever
JAMS = 5  # impulses at both contacts stop the spin at once


@inner_kernel
def spinning_forces(
    gravity: float,
    sense: float,
    ax: float,
    ay: float,
    friction_a: float,
    bx: float,
    by: float,
    friction_b: float,
) -> tuple[float, float]:
    """Normal forces N_a and N_b per unit mass on a ball that spins in `sense`, 1 or -1.

    (ax, ay) and (bx, by) are the unit normals. Both forces are 0 if no forces hold the ball.
    """
    reach_ax = ax - sense * friction_a * ay
    reach_ay = ay + sense * friction_a * ax
    reach_bx = bx - sense * friction_b * by
    reach_by = by + sense * friction_b * bx
    cross = reach_ax * reach_by - reach_ay * reach_bx
    if cross == 0.0:
        return 0.0, 0.0
    return gravity * reach_bx / cross, -gravity * reach_ax / cross


@inner_kernel
def opens(
    gravity: float, pull: float, nx: float, ny: float, other_x: float, other_y: float
) -> bool:
    """Whether a ball at rest, held only by one surface with normal (nx, ny), leaves the other.

    `pull` is the friction along the tangent per unit of the normal force.
    """
    force = -gravity * ny
    along = gravity * nx + pull * force
    away = other_y * nx - other_x * ny  # t . n of the other
    return force > 0.0 and along * away >= 0.0


@inner_kernel
def rest_in_notch(
    gravity: float,
    omega: float,
    ax: float,
    ay: float,
    friction_a: float,
    bx: float,
    by: float,
    friction_b: float,
) -> tuple[int, float]:
    """What a ball at rest on two surfaces does, and for SPINS the brake of its spin, 0 otherwise.

    The brake is mu_a N_a + mu_b N_b in m/s^2; |omega|' = -2 brake / R. If both contacts could open,
    contact b opens without spin; with spin, the one whose normal force would have to pull.
    """
    if gravity * ay >= 0.0 and gravity * by >= 0.0:
        return FALLS, 0.0  # pressed onto neither surface, so there is no friction
    if omega == 0.0 or (friction_a == 0.0 and friction_b == 0.0):
        # Friction cannot turn the motion around: whether the ball rolls or slides, it begins to
        # move in the direction of gravity along the surface.
        if opens(gravity, 0.0, ax, ay, bx, by):
            return GOES_ON_A, 0.0
        if opens(gravity, 0.0, bx, by, ax, ay):
            return GOES_ON_B, 0.0
        return RESTS, 0.0
    sense = 1.0 if omega > 0.0 else -1.0
    force_a, force_b = spinning_forces(gravity, sense, ax, ay, friction_a, bx, by, friction_b)
    if force_a > 0.0 and force_b > 0.0:
        return SPINS, friction_a * force_a + friction_b * force_b
    stays_on_a = opens(gravity, sense * friction_a, ax, ay, bx, by)
    stays_on_b = opens(gravity, sense * friction_b, bx, by, ax, ay)
    if stays_on_a and (force_b <= 0.0 or not stays_on_b):
        return GOES_ON_A, 0.0
    if stays_on_b:
        return GOES_ON_B, 0.0
    return JAMS, 0.0
