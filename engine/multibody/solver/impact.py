"""An impact of two balls, or of a ball with what is fixed, at its place and time in a substep."""

from math import sqrt

from engine.jit.decorator import lean_kernel
from engine.multibody.solver.contact_solver import (
    any_direction,
    pair_surface,
    resting_speed,
    separation,
)
from engine.multibody.solver.layout import (
    ASLEEP,
    BOUNCED,
    FLAGS,
    ID,
    INVERSE_MASS,
    LOG_A,
    LOG_B,
    LOG_SPEED,
    LOG_T,
    LOG_X,
    LOG_Y,
    RING,
    ROLL,
    STILL,
    TOUCHES,
    VX,
    VY,
    WAITS,
    Counts,
    Floats,
    Ints,
    X,
    Y,
)
from engine.multibody.solver.narrow_phase import SLACK
from engine.multibody.solver.prediction import HITS, STAMP, WAITING

MAX_HITS = 16
"""Impacts of one ball in one substep. A ball that meets more is caught between others; it waits
where it is for the next substep, so it cannot be pushed through anything."""

LIVELY_HITS = 8
"""Impacts of one ball in one substep that rebound by less than all; further ones do not rebound.
Balls caught between others would bounce infinitely often otherwise."""

PART = 1.0e-3
"""Speed at which a pair that has reached the allowed overlap parts, in allowed overlaps a substep:
above rounding, so that it does not meet again at once, and far below anything seen."""


@lean_kernel
def wake(marks: Ints, i: int) -> None:
    """Wake ball i and all that fell asleep with it."""
    j = i
    while marks[j, FLAGS] & ASLEEP:
        marks[j, FLAGS] &= ~ASLEEP
        marks[j, STILL] = 0
        following = marks[j, RING]
        marks[j, RING] = j
        j = following


@lean_kernel
def _note_touch(
    pos: Floats, marks: Ints, a: int, b: int, t: float, speed: float,
    floats: Floats, ints: Ints, counts: Counts,
) -> None:  # fmt: skip
    marks[a, FLAGS] |= BOUNCED
    other = b
    if b >= 0:
        marks[b, FLAGS] |= BOUNCED
        other = marks[b, ID]
    row = counts[TOUCHES]
    counts[TOUCHES] = row + 1
    if row < len(floats):
        floats[row, LOG_T] = t
        floats[row, LOG_X] = pos[a, X]
        floats[row, LOG_Y] = pos[a, Y]
        floats[row, LOG_SPEED] = speed
        ints[row, LOG_A] = marks[a, ID]
        ints[row, LOG_B] = other


@lean_kernel
def hold(
    vel: Floats, state: Ints, i: int, is_dead: bool, gravity: float, rest: float, counts: Counts
) -> None:
    """Let ball i wait out the `rest` of the substep: it neither moves nor falls faster meanwhile.

    After impacts that do not rebound it is at rest between others, if gravity presses it there.
    """
    if state[i, WAITING] == 0:
        state[i, WAITING] = 1
        counts[WAITS] += 1
        if is_dead and gravity > 0.0:
            vel[i, VX] = 0.0
            vel[i, VY] = 0.0
        else:
            vel[i, VY] -= gravity * rest


@lean_kernel
def _count_hit(
    vel: Floats, state: Ints, i: int, is_dead: bool, gravity: float, rest: float, counts: Counts
) -> None:
    state[i, HITS] += 1
    state[i, STAMP] += 1
    if state[i, HITS] > MAX_HITS:
        hold(vel, state, i, is_dead, gravity, rest, counts)


@lean_kernel
def impact(
    pos: Floats, vel: Floats, surface: Floats, marks: Ints, items: Floats, state: Ints,
    a: int, b: int, gravity: float, h: float, now: float, start: float,
    floats: Floats, ints: Ints, counts: Counts,
) -> tuple[float, float]:  # fmt: skip
    """Impact of a and b (a ball, or -1 - item), which both are where they are at `now`.

    Velocities of semi-implicit Euler lag half a substep behind the places: a ball that hits what
    is fixed at `now` has fallen g (now - h/2) faster. With that, elastic impacts keep the energy.
    Between balls it cancels. Returns the impulses, N s, of one that is a contact: zero otherwise.
    """
    dx, dy, reach, small = separation(pos, items, a, b)
    distance = sqrt(dx * dx + dy * dy)
    if distance > 0.0:
        nx = dx / distance
        ny = dy / distance
    else:
        nx, ny = any_direction(marks[a, ID], marks[b, ID] if b >= 0 else b)
    partner = b if b >= 0 else len(vel) - 1
    restitution, grip = pair_surface(surface, items, a, b)
    threshold = resting_speed(restitution, gravity, h, small)
    approach = (vel[partner, VX] - vel[a, VX]) * nx + (vel[partner, VY] - vel[a, VY]) * ny
    is_slow = approach < threshold
    lead = 0.0
    wa = vel[a, INVERSE_MASS]
    wb = vel[partner, INVERSE_MASS]
    part = 0.0
    if is_slow:
        restitution = 0.0
        if distance < reach:
            part = PART * SLACK * small / h
    else:
        if b < 0:
            lead = gravity * (now - 0.5 * h)
        if restitution < 1.0 and max(state[a, HITS], state[b, HITS] if b >= 0 else 0) > LIVELY_HITS:
            restitution = 0.0
    is_dead = restitution == 0.0
    if is_dead and gravity > 0.0 and b >= 0:  # what waits is held by what is around it
        if state[b, WAITING]:
            wb = 0.0
        elif state[a, WAITING]:
            wa = 0.0
    ux = vel[a, VX] - vel[partner, VX]
    uy = vel[a, VY] + lead - vel[partner, VY]
    un = ux * nx + uy * ny
    normal = 0.0
    tangent = 0.0
    if wa + wb > 0.0 and un < part:
        mass = 1.0 / (wa + wb)
        normal = mass * (max(part, -restitution * un) - un)
        if grip > 0.0:
            slip = uy * nx - ux * ny - vel[a, ROLL] - vel[partner, ROLL]
            limit = grip * normal
            tangent = max(-limit, min(limit, -mass * slip * (1.0 / 3.0)))
        jx = normal * nx - tangent * ny
        jy = normal * ny + tangent * nx
        vel[a, VX] += wa * jx
        vel[a, VY] += wa * jy
        vel[a, ROLL] -= 2.0 * wa * tangent
        vel[partner, VX] -= wb * jx
        vel[partner, VY] -= wb * jy
        vel[partner, ROLL] -= 2.0 * wb * tangent
    if not is_slow:
        _note_touch(pos, marks, a, b, start + now, approach, floats, ints, counts)
    _count_hit(vel, state, a, is_dead, gravity, h - now, counts)
    if b >= 0:
        _count_hit(vel, state, b, is_dead, gravity, h - now, counts)
        if state[b, WAITING] and vel[a, VX] * nx + vel[a, VY] * ny < 0.0:
            hold(vel, state, a, is_dead, gravity, h - now, counts)
        if state[a, WAITING] and vel[b, VX] * nx + vel[b, VY] * ny > 0.0:
            hold(vel, state, b, is_dead, gravity, h - now, counts)
    if not is_slow:
        normal = 0.0
        tangent = 0.0
    return normal, tangent
