"""Resting contact of balls: overlap is reduced, then sequential impulses with a warm start.

A contact's impulse of the last substep is applied first, then corrected: in a pile at rest it is
right already, and the loads of all layers are there at once.
"""

from math import sqrt

from engine.jit.decorator import kernel, lean_kernel
from engine.multibody.solver.layout import (
    ASLEEP,
    FLAGS,
    FRICTION,
    GONE,
    INVERSE_MASS,
    ITEM_FRICTION,
    ITEM_RESTITUTION,
    RADIUS,
    RESTITUTION,
    ROLL,
    THICKNESS,
    VX,
    VY,
    Bodies,
    Floats,
    Ints,
    Pairs,
    Statics,
    X,
    Y,
)
from engine.multibody.solver.narrow_phase import nearest

TOUCH = 0.005
"""Gap, in radii of the smaller ball, up to which a contact counts as one: speculative, so that a
ball that hovers at the width of a hair keeps its impulse. Larger, it would hold back balls that
pass each other; at zero, contacts flicker and piles never come to rest."""

SLOP = 0.001
"""Overlap, in radii of the smaller ball, that is left alone: contacts at rest stay contacts."""

DEEP = 0.008
"""Overlap, in radii of the smaller ball, above which a pair is pushed apart at the end of a frame:
below the one per cent that may show, above what the swept move leaves by itself."""

LEAST_SHARE = 0.02
"""Part of such a push that even the heavier ball takes. At zero, a light ball under a heavy one
would be pushed to and fro between it and the floor; at a half, heavy ones would climb."""

PUSH_LIMIT = 0.25
"""A ball's radii by which others may push it out of overlap in a substep. A wall pushes back by
the correction factor times the depth, so a ball cannot be pushed through one: at 0.25 radii a
substep and a factor of 0.4 it comes to rest 0.6 radii deep."""

ELASTIC_REST = 1.0e-7
"""Speed below which not even an elastic approach rebounds, in radii of the smaller ball per
substep: rounding."""

LANES = 4
"""Stretches of the contacts' list that a pass takes from in turns."""

# Columns of the contacts' work space.
NORMAL_X = 0
NORMAL_Y = 1
MASS = 2  # that of the pair along the normal, kg; across it, a third
BIAS = 3  # gap over substep, m/s
GRIP = 4  # friction of the pair
PRESSED = 5  # accumulated impulses, N s
DRAGGED = 6
CONTACT_COLUMNS = 7


@lean_kernel
def resting_speed(restitution: float, gravity: float, h: float, radius: float) -> float:
    """Approach in m/s below which an impact does not rebound: twice what gravity adds meanwhile.

    An elastic ball never comes to rest.
    """
    floor = ELASTIC_REST * radius / h
    if restitution >= 1.0:
        return floor
    return max(2.0 * gravity * h, floor)


@lean_kernel
def pair_surface(surface: Floats, items: Floats, a: int, b: int) -> tuple[float, float]:
    """Restitution of a pair, the larger, and its friction, the root of the product."""
    restitution = surface[a, RESTITUTION]
    mu = surface[a, FRICTION]
    if b >= 0:
        other = surface[b, RESTITUTION]
        nu = surface[b, FRICTION]
    else:
        other = items[-1 - b, ITEM_RESTITUTION]
        nu = items[-1 - b, ITEM_FRICTION]
    if mu != nu:
        mu = sqrt(mu * nu)
    return max(restitution, other), mu


@lean_kernel
def any_direction(a: int, b: int) -> tuple[float, float]:
    """A unit vector for discs with one centre: by their ids, so that it is always the same."""
    mixed = (a * 40503 + b * 30011 + 7919) % 65521
    u = mixed % 255 / 255.0  # tan of a quarter of the angle from -pi/2 to pi/2
    u = 2.0 * u - 1.0
    d = 1.0 + u * u
    x = 2.0 * u / d
    y = (1.0 - u * u) / d
    return (x, y) if (mixed // 255) % 2 == 0 else (x, -y)


@lean_kernel
def separation(pos: Floats, items: Floats, a: int, b: int) -> tuple[float, float, float, float]:
    """Vector from b (a ball, or -1 - item) to ball a, their contact distance, and the size in m
    by which tolerances are measured."""
    if b >= 0:
        dx = pos[a, X] - pos[b, X]
        dy = pos[a, Y] - pos[b, Y]
        return dx, dy, pos[a, RADIUS] + pos[b, RADIUS], min(pos[a, RADIUS], pos[b, RADIUS])
    item = -1 - b
    dx, dy = nearest(items, item, pos[a, X], pos[a, Y])
    return dx, dy, pos[a, RADIUS] + items[item, THICKNESS], pos[a, RADIUS]


@lean_kernel
def _push_apart(
    pos: Floats, room: Floats, a: int, b: int, nx: float, ny: float, push: float, share: float
) -> None:
    """Move a and b apart by `push` m, of which a takes `share`; b is fixed if that is all."""
    da = push * share
    if b < len(room):
        db = push - da
        da = min(da, room[a])
        db = min(db, room[b])
        room[a] -= da
        room[b] -= db
        pos[b, X] -= db * nx
        pos[b, Y] -= db * ny
    pos[a, X] += da * nx
    pos[a, Y] += da * ny


@lean_kernel
def gather(
    pos: Floats,
    vel: Floats,
    surface: Floats,
    marks: Ints,
    items: Floats,
    starts: Ints,
    other: Ints,
    impulse: Floats,
    gravity: float,
    h: float,
    correction: float,
    room: Floats,
    ends: Ints,
    rows: Floats,
) -> int:
    """Find the contacts, reduce their overlap, start them warm; their number.

    `ends` (p, 3) gets their balls and pair, `rows` (p, 7) the work space; `room` (n,) is work space
    too. A new contact whose approach rebounds is left to the impacts. Arrays come one by one here
    and in all that is called for each pair: to unpack them costs more than to use them.
    """
    fixed = len(pos) - 1
    n = len(starts) - 1
    count = 0
    travel = 2.0 * gravity * h * h
    for i in range(n):
        room[i] = PUSH_LIMIT * pos[i, RADIUS]
    for a in range(n):
        if starts[a] == starts[a + 1] or marks[a, FLAGS] & GONE:
            continue
        ra = pos[a, RADIUS]
        wa = vel[a, INVERSE_MASS]
        for k in range(starts[a], starts[a + 1]):
            b = other[k]
            if b >= 0:
                dx = pos[a, X] - pos[b, X]
                dy = pos[a, Y] - pos[b, Y]
                small = min(ra, pos[b, RADIUS])
                reach = ra + pos[b, RADIUS]
            else:
                dx, dy, reach, small = separation(pos, items, a, b)
            near = reach + TOUCH * small
            far = near + travel
            dd = dx * dx + dy * dy
            if dd >= far * far:
                if impulse[k, 0] != 0.0:
                    impulse[k, 0] = 0.0
                    impulse[k, 1] = 0.0
                continue
            if dd >= near * near:  # not yet a contact, but one before the substep ends
                if impulse[k, 0] != 0.0:
                    impulse[k, 0] = 0.0
                    impulse[k, 1] = 0.0
                foe = b if b >= 0 else fixed
                ex = dx + (vel[a, VX] - vel[foe, VX]) * h
                ey = dy + (vel[a, VY] - vel[foe, VY]) * h
                if ex * ex + ey * ey >= near * near:
                    continue
            partner = fixed
            if b >= 0:
                if marks[b, FLAGS] & (ASLEEP | GONE):
                    continue
                partner = b
            distance = sqrt(dd)
            if distance > 0.0:
                over = 1.0 / distance
                nx = dx * over
                ny = dy * over
            else:
                nx, ny = any_direction(marks[a, 0], marks[b, 0] if b >= 0 else b)
            gap = distance - reach
            mass = 1.0 / (wa + vel[partner, INVERSE_MASS])
            if gap < -SLOP * small:
                push = correction * (-gap - SLOP * small)
                share = wa * mass if b >= 0 else 1.0
                _push_apart(pos, room, a, partner, nx, ny, push, share)
            restitution, grip = pair_surface(surface, items, a, b)
            if impulse[k, 0] == 0.0:
                approach = (vel[partner, VX] - vel[a, VX]) * nx
                approach += (vel[partner, VY] - vel[a, VY]) * ny
                if approach >= resting_speed(restitution, gravity, h, small):
                    continue
            rows[count, NORMAL_X] = nx
            rows[count, NORMAL_Y] = ny
            rows[count, MASS] = mass
            rows[count, BIAS] = gap / h if gap > 0.0 else 0.0
            rows[count, GRIP] = grip
            rows[count, PRESSED] = impulse[k, 0]
            rows[count, DRAGGED] = impulse[k, 1]
            ends[count, 0] = a
            ends[count, 1] = partner
            ends[count, 2] = k
            count += 1
    return count


@lean_kernel
def _apply(
    vel: Floats, a: int, b: int, nx: float, ny: float, normal: float, tangent: float
) -> None:
    """Give a the impulse normal n + tangent t and b its opposite; t = (-n_y, n_x)."""
    jx = normal * nx - tangent * ny
    jy = normal * ny + tangent * nx
    wa = vel[a, INVERSE_MASS]
    wb = vel[b, INVERSE_MASS]
    vel[a, VX] += wa * jx
    vel[a, VY] += wa * jy
    vel[a, ROLL] -= 2.0 * wa * tangent
    vel[b, VX] -= wb * jx
    vel[b, VY] -= wb * jy
    vel[b, ROLL] -= 2.0 * wb * tangent


@lean_kernel
def warm_start(vel: Floats, count: int, ends: Ints, rows: Floats) -> None:
    """Apply the impulses of the last substep."""
    for c in range(count):
        if rows[c, PRESSED] > 0.0:
            _apply(
                vel, ends[c, 0], ends[c, 1],
                rows[c, NORMAL_X], rows[c, NORMAL_Y], rows[c, PRESSED], rows[c, DRAGGED],
            )  # fmt: skip


@lean_kernel
def solve(vel: Floats, count: int, ends: Ints, rows: Floats) -> float:
    """One pass over the contacts: no approach, and Coulomb's friction within what presses.

    Returns the largest change of an approach, m/s: how far from the solution it still was.

    j_n >= 0 so that v_n >= -gap / h; |j_t| <= mu j_n, towards slip = 0 with
    slip = (v_a - v_b).t - omega_a R_a - omega_b R_b. The bounds hold for the accumulated impulses.
    Contacts are taken from LANES stretches of the list in turns: neighbours in the list mostly
    share a ball, and the processor would wait for one before it could begin the next.
    """
    largest = 0.0
    stretch = (count + LANES - 1) // LANES
    for m in range(stretch * LANES):
        c = m // LANES + m % LANES * stretch
        if c >= count:
            continue
        a = ends[c, 0]
        b = ends[c, 1]
        nx = rows[c, NORMAL_X]
        ny = rows[c, NORMAL_Y]
        mass = rows[c, MASS]
        ux = vel[a, VX] - vel[b, VX]
        uy = vel[a, VY] - vel[b, VY]
        before = rows[c, PRESSED]
        normal = before - mass * (ux * nx + uy * ny + rows[c, BIAS])
        normal = normal if normal > 0.0 else 0.0
        rows[c, PRESSED] = normal
        grip = rows[c, GRIP]
        tangent = 0.0
        was = rows[c, DRAGGED]
        if grip > 0.0:
            slip = uy * nx - ux * ny - vel[a, ROLL] - vel[b, ROLL]
            tangent = was - mass * slip * (1.0 / 3.0)
            limit = grip * normal
            tangent = tangent if tangent < limit else limit
            tangent = tangent if tangent > -limit else -limit
            rows[c, DRAGGED] = tangent
        normal -= before
        _apply(vel, a, b, nx, ny, normal, tangent - was)
        change = abs(normal) * (vel[a, INVERSE_MASS] + vel[b, INVERSE_MASS])
        largest = change if change > largest else largest
    return largest


@lean_kernel
def keep_impulses(impulse: Floats, count: int, ends: Ints, rows: Floats) -> None:
    """Write the impulses back for the next warm start."""
    for c in range(count):
        k = ends[c, 2]
        impulse[k, 0] = rows[c, PRESSED]
        impulse[k, 1] = rows[c, DRAGGED]


@lean_kernel
def part_deep(
    pos: Floats, vel: Floats, marks: Ints, items: Floats, starts: Ints, other: Ints, room: Floats
) -> bool:
    """Push apart the pairs that overlap by more than DEEP; whether there were any.

    `room` (n,) is how far each ball may still be pushed.
    """
    fixed = len(pos) - 1
    is_any = False
    for a in range(len(starts) - 1):
        for k in range(starts[a], starts[a + 1]):
            b = other[k]
            dx, dy, reach, small = separation(pos, items, a, b)
            inner = reach - DEEP * small
            dd = dx * dx + dy * dy
            if dd >= inner * inner or dd == 0.0:
                continue
            if marks[a, FLAGS] & GONE or (b >= 0 and marks[b, FLAGS] & GONE):
                continue
            distance = sqrt(dd)
            partner = fixed
            share = 1.0
            if b >= 0 and marks[b, FLAGS] & ASLEEP == 0:
                partner = b
                share = vel[a, INVERSE_MASS] / (vel[a, INVERSE_MASS] + vel[b, INVERSE_MASS])
                share = min(max(share, LEAST_SHARE), 1.0 - LEAST_SHARE)
            push = inner - distance + DEEP * small * 0.25
            _push_apart(pos, room, a, partner, dx / distance, dy / distance, push, share)
            is_any = True
    return is_any


@kernel
def deepest(bodies: Bodies, n: int, pairs: Pairs, statics: Statics) -> tuple[float, float, int]:
    """Deepest overlap of listed pairs in m and in radii of the smaller ball; contacts touching."""
    metres = 0.0
    radii = 0.0
    touching = 0
    for a in range(n):
        for k in range(pairs.starts[a], pairs.starts[a + 1]):
            dx, dy, reach, small = separation(bodies.pos, statics.items, a, int(pairs.other[k]))
            near = reach + TOUCH * small
            dd = dx * dx + dy * dy
            if dd >= near * near:
                continue
            touching += 1
            depth = reach - sqrt(dd)
            metres = max(metres, depth)
            radii = max(radii, depth / small)
    return metres, radii, touching
