"""Contact solver: sequential impulses with a warm start, for contacts at rest.

Catto, Iterative Dynamics with Temporal Coherence (GDC 2005), and Fast and Simple Physics using
Sequential Impulses (GDC 2006). Each contact begins with its impulse of the last substep, which is
then corrected. In a pile at rest this impulse is already right, so the load of all layers acts at
once, instead of propagating by one layer in each pass.
"""

from math import sqrt

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.multibody.solver.layout import body, contact, pair, shape
from plinko.engine.multibody.solver.layout.array_types import Floats
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.contact import Contacts
from plinko.engine.multibody.solver.layout.pair import NeighbourList
from plinko.engine.multibody.solver.layout.shape import StaticShapes
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.multibody.solver.narrow_phase import SPECULATIVE_GAP, fallback_normal, separation
from plinko.engine.multibody.solver.position_projection import limit_pushes, push_apart

SLOP = 0.001
"""Overlap, in radii of the smaller ball, that is not corrected, so that resting contacts last."""

ROUNDING = 1.0e-10
"""Approach, as a fraction of both balls' speeds, below which even an elastic pair does not rebound.
It covers the rounding of velocities and of the normal. With a larger value, a slow pair that moves
fast as a whole would be inelastic. With a smaller one, balls that touch and move together would
have impact after impact."""

STRETCHES = 4
"""Number of parts of the contacts' list from which a pass takes contacts in turn."""


@inner_kernel
def new_contacts(pairs: NeighbourList) -> Contacts:
    """Work space with room for a contact of each pair."""
    room = len(pairs.other)
    return Contacts(
        np.empty((room, contact.END_COLUMNS), np.int32), np.empty((room, contact.COLUMNS))
    )


@lean_kernel
def restitution_threshold(
    restitution: float, gravity: float, h: float,
    vx_a: float, vy_a: float, vx_b: float, vy_b: float,
) -> float:  # fmt: skip
    """Approach in m/s below which an impact does not rebound: twice what gravity adds in h seconds.

    Elastic balls never come to rest, and without gravity no balls do. For these, the threshold is
    only large enough to ignore rounding: a fraction of both balls' speeds.
    """
    floor = ROUNDING * (abs(vx_a) + abs(vy_a) + abs(vx_b) + abs(vy_b))
    if restitution >= 1.0:
        return floor
    return max(2.0 * gravity * h, floor)


@lean_kernel
def pair_restitution(one: float, other: float, lesser: bool) -> float:
    """The restitution of a pair: the greater of the two, or the lesser."""
    return min(one, other) if lesser else max(one, other)


@lean_kernel
def mix_materials(
    surface: Floats, items: Floats, a: int, b: int, lesser: bool
) -> tuple[float, float]:
    """A pair's restitution, and its friction coefficient, the geometric mean of the two."""
    restitution = surface[a, body.RESTITUTION]
    mu = surface[a, body.FRICTION]
    if b >= 0:
        other = surface[b, body.RESTITUTION]
        nu = surface[b, body.FRICTION]
    else:
        other = items[-1 - b, shape.RESTITUTION]
        nu = items[-1 - b, shape.FRICTION]
    if mu != nu:
        mu = sqrt(mu * nu)
    return pair_restitution(restitution, other, lesser), mu


@lean_kernel
def _may_touch(
    vel: Floats,
    a: int,
    b: int,
    dx: float,
    dy: float,
    touch_distance: float,
    settings: SolverSettings,
) -> bool:
    """Whether a, at (dx, dy) in m from b, touches it now or before the substep ends.

    In the latter case the contact is speculative.
    """
    dd = dx * dx + dy * dy
    far = touch_distance + 2.0 * settings.gravity * settings.h * settings.h
    if dd >= far * far:
        return False
    if dd < touch_distance * touch_distance:
        return True
    ex = dx + (vel[a, body.VX] - vel[b, body.VX]) * settings.h
    ey = dy + (vel[a, body.VY] - vel[b, body.VY]) * settings.h
    return bool(ex * ex + ey * ey < touch_distance * touch_distance)


@lean_kernel
def prepare_contacts(
    bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes, settings: SolverSettings,
    push_left: Floats, contacts: Contacts,
) -> int:  # fmt: skip
    """Find the contacts, reduce their overlap and fill `contacts`; return their number.

    push_left (n,): work space. A new contact that would rebound is left to the impacts.
    """
    pos = bodies.pos
    vel = bodies.vel
    marks = bodies.marks
    items = statics.items
    starts = pairs.starts
    other = pairs.other
    impulse = pairs.impulse
    gravity = settings.gravity
    h = settings.h
    correction = settings.correction
    ends = contacts.ends
    rows = contacts.rows
    fixed = len(pos) - 1
    count = 0
    limit_pushes(pos, n, push_left)
    for a in range(n):
        if starts[a] == starts[a + 1] or marks[a, body.FLAGS] & body.GONE:
            continue
        wa = vel[a, body.INVERSE_MASS]
        for k in range(starts[a], starts[a + 1]):
            b = other[k]
            partner = b if b >= 0 else fixed
            dx, dy, contact_distance, small = separation(pos, items, a, b)
            dd = dx * dx + dy * dy
            touch_distance = contact_distance + SPECULATIVE_GAP * small
            if dd >= touch_distance * touch_distance and impulse[k, pair.NORMAL] != 0.0:
                impulse[k, pair.NORMAL] = 0.0
                impulse[k, pair.TANGENT] = 0.0
                impulse[k, pair.TORQUE] = 0.0
            if not _may_touch(vel, a, partner, dx, dy, touch_distance, settings):
                continue
            if b >= 0 and marks[b, body.FLAGS] & (body.ASLEEP | body.GONE):
                continue
            distance = sqrt(dd)
            if distance > 0.0:
                inverse = 1.0 / distance
                nx = dx * inverse
                ny = dy * inverse
            else:
                nx, ny = fallback_normal(marks[a, body.ID], marks[b, body.ID] if b >= 0 else b)
            gap = distance - contact_distance
            mass = 1.0 / (wa + vel[partner, body.INVERSE_MASS])
            if gap < -SLOP * small:
                push = correction * (-gap - SLOP * small)
                share = wa * mass if b >= 0 else 1.0
                push_apart(pos, push_left, a, partner, nx, ny, push, share)
            restitution, friction = mix_materials(bodies.surface, items, a, b, settings.lesser)
            if impulse[k, pair.NORMAL] == 0.0:
                approach = (vel[partner, body.VX] - vel[a, body.VX]) * nx
                approach += (vel[partner, body.VY] - vel[a, body.VY]) * ny
                threshold = restitution_threshold(
                    restitution, gravity, h,
                    vel[a, body.VX], vel[a, body.VY], vel[partner, body.VX], vel[partner, body.VY],
                )  # fmt: skip
                if approach >= threshold:
                    continue
            rows[count, contact.NORMAL_X] = nx
            rows[count, contact.NORMAL_Y] = ny
            rows[count, contact.MASS] = mass
            rows[count, contact.BIAS] = gap / h if gap > 0.0 else 0.0
            rows[count, contact.FRICTION] = friction
            rows[count, contact.NORMAL_IMPULSE] = impulse[k, pair.NORMAL]
            rows[count, contact.TANGENT_IMPULSE] = impulse[k, pair.TANGENT]
            rows[count, contact.TORQUE_IMPULSE] = impulse[k, pair.TORQUE]
            ends[count, contact.A] = a
            ends[count, contact.B] = partner
            ends[count, contact.PAIR] = k
            count += 1
    return count


@lean_kernel
def _apply(
    vel: Floats, a: int, b: int, nx: float, ny: float, normal: float, tangent: float
) -> None:
    """Apply the impulse normal * n + tangent * t to a and its opposite to b; t = (-n_y, n_x)."""
    jx = normal * nx - tangent * ny
    jy = normal * ny + tangent * nx
    wa = vel[a, body.INVERSE_MASS]
    wb = vel[b, body.INVERSE_MASS]
    vel[a, body.VX] += wa * jx
    vel[a, body.VY] += wa * jy
    vel[a, body.RIM_SPEED] -= 2.0 * wa * tangent
    vel[b, body.VX] -= wb * jx
    vel[b, body.VY] -= wb * jy
    vel[b, body.RIM_SPEED] -= 2.0 * wb * tangent


@lean_kernel
def _turn(vel: Floats, a: int, b: int, over_a: float, over_b: float, torque: float) -> None:
    """Apply the impulse of a torque to a, and its opposite to b; over_a, over_b: 1 / radius."""
    vel[a, body.RIM_SPEED] += 2.0 * vel[a, body.INVERSE_MASS] * over_a * torque
    vel[b, body.RIM_SPEED] -= 2.0 * vel[b, body.INVERSE_MASS] * over_b * torque


@lean_kernel
def _over_radii(pos: Floats, a: int, b: int) -> tuple[float, float]:
    """1 / radius of ball a, and of b, which is 0 for the row of fixed shapes."""
    return 1.0 / pos[a, body.RADIUS], 1.0 / pos[b, body.RADIUS] if b < len(pos) - 1 else 0.0


@lean_kernel
def _apply_all(vel: Floats, contacts: Contacts, c: int, factor: float) -> None:
    """Apply `factor` times the accumulated impulses of a contact."""
    rows = contacts.rows
    _apply(
        vel, contacts.ends[c, contact.A], contacts.ends[c, contact.B],
        rows[c, contact.NORMAL_X], rows[c, contact.NORMAL_Y],
        factor * rows[c, contact.NORMAL_IMPULSE], factor * rows[c, contact.TANGENT_IMPULSE],
    )  # fmt: skip


@lean_kernel
def warm_start(bodies: Bodies, count: int, contacts: Contacts) -> None:
    """Apply each contact's impulses of the last substep."""
    ends = contacts.ends
    rows = contacts.rows
    for c in range(count):
        if rows[c, contact.NORMAL_IMPULSE] > 0.0:
            _apply_all(bodies.vel, contacts, c, 1.0)
            if rows[c, contact.TORQUE_IMPULSE] != 0.0:
                a = ends[c, contact.A]
                b = ends[c, contact.B]
                over_a, over_b = _over_radii(bodies.pos, a, b)
                _turn(bodies.vel, a, b, over_a, over_b, rows[c, contact.TORQUE_IMPULSE])


@lean_kernel
def resist_rolling(bodies: Bodies, count: int, contacts: Contacts, rolling: float) -> None:
    """Reduce the rolling of each contact, omega_a - omega_b, to 0 by a torque that the load limits.

    The load is that of the last substep. A torque is at most c N R with the coefficient c and
    1 / R = 1 / R_a + 1 / R_b. So a ball that rolls on a plane slows down by c g (2/3), as friction
    passes the torque on to its velocity, and one on a slope of less than c rests. Without friction
    nothing rolls.
    """
    pos = bodies.pos
    vel = bodies.vel
    rows = contacts.rows
    ends = contacts.ends
    for c in range(count):
        load = rows[c, contact.NORMAL_IMPULSE]
        if load == 0.0 or rows[c, contact.FRICTION] == 0.0:
            continue
        a = ends[c, contact.A]
        b = ends[c, contact.B]
        over_a, over_b = _over_radii(pos, a, b)
        spin = vel[a, body.RIM_SPEED] * over_a - vel[b, body.RIM_SPEED] * over_b
        turning = vel[a, body.INVERSE_MASS] * over_a * over_a
        turning += vel[b, body.INVERSE_MASS] * over_b * over_b
        limit = rolling * load / (over_a + over_b)
        before = rows[c, contact.TORQUE_IMPULSE]
        torque = before - spin / (2.0 * turning)
        torque = torque if torque < limit else limit
        torque = torque if torque > -limit else -limit
        rows[c, contact.TORQUE_IMPULSE] = torque
        _turn(vel, a, b, over_a, over_b, torque - before)


@lean_kernel
def take_back(vel: Floats, count: int, contacts: Contacts) -> None:
    """Take the normal and tangential impulses of this substep back."""
    rows = contacts.rows
    for c in range(count):
        _apply_all(vel, contacts, c, -1.0)
        rows[c, contact.NORMAL_IMPULSE] = 0.0
        rows[c, contact.TANGENT_IMPULSE] = 0.0


@lean_kernel
def solve_contacts(vel: Floats, count: int, contacts: Contacts) -> float:
    """One pass over the contacts: stop each approach, with Coulomb friction.

    The normal impulse j_n >= 0 makes v_n >= -gap / h. The tangential impulse, |j_t| <= mu j_n,
    reduces slip = (v_a - v_b).t - omega_a R_a - omega_b R_b to 0. The bounds apply to the impulses
    accumulated over all passes. Returns the largest change of an approach in m/s, which measures
    how far the impulses were from the solution.

    The pass takes contacts from STRETCHES parts of the list in turn. Consecutive contacts in the
    list usually share a ball, so the processor would have to finish one before it begins the next.
    """
    ends = contacts.ends
    rows = contacts.rows
    largest = 0.0
    stretch = (count + STRETCHES - 1) // STRETCHES
    for m in range(stretch * STRETCHES):
        c = m // STRETCHES + m % STRETCHES * stretch
        if c >= count:
            continue
        a = ends[c, contact.A]
        b = ends[c, contact.B]
        nx = rows[c, contact.NORMAL_X]
        ny = rows[c, contact.NORMAL_Y]
        mass = rows[c, contact.MASS]
        ux = vel[a, body.VX] - vel[b, body.VX]
        uy = vel[a, body.VY] - vel[b, body.VY]
        before = rows[c, contact.NORMAL_IMPULSE]
        normal = before - mass * (ux * nx + uy * ny + rows[c, contact.BIAS])
        normal = normal if normal > 0.0 else 0.0
        rows[c, contact.NORMAL_IMPULSE] = normal
        friction = rows[c, contact.FRICTION]
        tangent = 0.0
        was = rows[c, contact.TANGENT_IMPULSE]
        if friction > 0.0:
            slip = uy * nx - ux * ny - vel[a, body.RIM_SPEED] - vel[b, body.RIM_SPEED]
            tangent = was - mass * slip * (1.0 / 3.0)
            limit = friction * normal
            tangent = tangent if tangent < limit else limit
            tangent = tangent if tangent > -limit else -limit
            rows[c, contact.TANGENT_IMPULSE] = tangent
        normal -= before
        _apply(vel, a, b, nx, ny, normal, tangent - was)
        change = abs(normal) * (vel[a, body.INVERSE_MASS] + vel[b, body.INVERSE_MASS])
        largest = change if change > largest else largest
    return largest


@lean_kernel
def store_impulses(pairs: NeighbourList, count: int, contacts: Contacts) -> None:
    """Copy the impulses back to the pairs for the next warm start."""
    for c in range(count):
        k = contacts.ends[c, contact.PAIR]
        pairs.impulse[k, pair.NORMAL] = contacts.rows[c, contact.NORMAL_IMPULSE]
        pairs.impulse[k, pair.TANGENT] = contacts.rows[c, contact.TANGENT_IMPULSE]
        pairs.impulse[k, pair.TORQUE] = contacts.rows[c, contact.TORQUE_IMPULSE]
