"""One impact of two balls, or of a ball with a fixed shape, at its place and time in a substep."""

from math import sqrt

from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.multibody.solver.contact_solver import mix_materials, restitution_threshold
from plinko.engine.multibody.solver.layout import body, step_log, sweep
from plinko.engine.multibody.solver.layout.array_types import Floats, Ints
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.multibody.solver.layout.step_log import StepLog
from plinko.engine.multibody.solver.narrow_phase import SLACK, fallback_normal, separation

MAX_IMPACTS = 16
"""Most impacts of one ball in one substep. A ball with more is caught between others. It is frozen
for the rest of the substep, so that it cannot be pushed through anything."""

MAX_REBOUNDS = 8
"""Most inelastic impacts of one ball in one substep that rebound. Without this limit, balls caught
between others would bounce infinitely often."""

SEPARATION_SPEED = 1.0e-3
"""Speed at which a pair at the allowed overlap separates, in allowed overlaps per substep. It is
larger than rounding, so that no second impact follows at once, and too small to be seen."""


@lean_kernel
def _note_touch(bodies: Bodies, a: int, b: int, t: float, speed: float, log: StepLog) -> None:
    """Log an impact of a and b, `t` seconds after the start of the step."""
    marks = bodies.marks
    marks[a, body.FLAGS] |= body.BOUNCED
    other = b
    if b >= 0:
        marks[b, body.FLAGS] |= body.BOUNCED
        other = marks[b, body.ID]
    row = log.counts[step_log.TOUCHES]
    log.counts[step_log.TOUCHES] = row + 1
    if row < len(log.floats):
        log.floats[row, step_log.T] = t
        log.floats[row, step_log.X] = bodies.pos[a, body.X]
        log.floats[row, step_log.Y] = bodies.pos[a, body.Y]
        log.floats[row, step_log.SPEED] = speed
        log.ints[row, step_log.A] = marks[a, body.ID]
        log.ints[row, step_log.B] = other


@lean_kernel
def freeze(
    vel: Floats, state: Ints, i: int, is_dead: bool, settings: SolverSettings, remaining: float
) -> None:
    """Freeze ball i for the `remaining` s of the substep: it does not move, and gravity does not
    act on it.

    is_dead: whether its last impact did not rebound. With gravity, the ball is then at rest between
    others, and its velocity and spin become zero.
    """
    if state[i, sweep.FROZEN] == 0:
        state[i, sweep.FROZEN] = 1
        if is_dead and settings.gravity > 0.0:
            vel[i, body.VX] = 0.0
            vel[i, body.VY] = 0.0
            vel[i, body.RIM_SPEED] = 0.0
        else:
            vel[i, body.VX] -= settings.gravity_x * remaining
            vel[i, body.VY] -= settings.gravity_y * remaining


@lean_kernel
def _count_impact(
    vel: Floats, state: Ints, i: int, is_dead: bool, settings: SolverSettings, remaining: float
) -> None:
    """Count an impact of ball i, and freeze the ball if it had more than MAX_IMPACTS."""
    state[i, sweep.IMPACTS] += 1
    state[i, sweep.VERSION] += 1
    if state[i, sweep.IMPACTS] > MAX_IMPACTS:
        freeze(vel, state, i, is_dead, settings, remaining)


@lean_kernel
def _freeze_against_frozen(
    vel: Floats, state: Ints, a: int, b: int, nx: float, ny: float, is_dead: bool,
    settings: SolverSettings, remaining: float,
) -> None:  # fmt: skip
    """If one of two balls is frozen and the other still moves towards it, freeze that one too."""
    if state[b, sweep.FROZEN] and vel[a, body.VX] * nx + vel[a, body.VY] * ny < 0.0:
        freeze(vel, state, a, is_dead, settings, remaining)
    if state[a, sweep.FROZEN] and vel[b, body.VX] * nx + vel[b, body.VY] * ny > 0.0:
        freeze(vel, state, b, is_dead, settings, remaining)


@lean_kernel
def impact(
    bodies: Bodies, items: Floats, state: Ints, a: int, b: int, settings: SolverSettings,
    now: float, start: float, log: StepLog,
) -> tuple[float, float]:  # fmt: skip
    """Compute the impact of a and b (a ball, or -1 - item), whose places are those at time `now`.

    In semi-implicit Euler, velocities are those of the middle of the substep. At `now`, a ball
    really moves faster by g (now - h/2). Impacts on fixed shapes use this correction, so that
    elastic ones conserve energy; between two balls it cancels.

    Returns the normal and tangential impulse in N s of a slow approach, which counts as a contact,
    otherwise zeros.
    """
    pos = bodies.pos
    vel = bodies.vel
    marks = bodies.marks
    gravity = settings.gravity
    h = settings.h
    dx, dy, contact_distance, small = separation(pos, items, a, b)
    distance = sqrt(dx * dx + dy * dy)
    if distance > 0.0:
        nx = dx / distance
        ny = dy / distance
    else:
        nx, ny = fallback_normal(marks[a, body.ID], marks[b, body.ID] if b >= 0 else b)
    partner = b if b >= 0 else len(vel) - 1
    restitution, friction = mix_materials(bodies.surface, items, a, b, settings.lesser)
    threshold = restitution_threshold(
        restitution, gravity, h,
        vel[a, body.VX], vel[a, body.VY], vel[partner, body.VX], vel[partner, body.VY],
    )  # fmt: skip
    approach = (vel[partner, body.VX] - vel[a, body.VX]) * nx
    approach += (vel[partner, body.VY] - vel[a, body.VY]) * ny
    is_slow = approach < threshold
    lead_x = 0.0
    lead_y = 0.0
    wa = vel[a, body.INVERSE_MASS]
    wb = vel[partner, body.INVERSE_MASS]
    parting = 0.0
    if is_slow:
        restitution = 0.0
        if distance < contact_distance:
            parting = SEPARATION_SPEED * SLACK * small / h
    else:
        if b < 0:
            lead_x = settings.gravity_x * (now - 0.5 * h)
            lead_y = settings.gravity_y * (now - 0.5 * h)
        impacts = max(state[a, sweep.IMPACTS], state[b, sweep.IMPACTS] if b >= 0 else 0)
        if restitution < 1.0 and impacts > MAX_REBOUNDS:
            restitution = 0.0
    is_dead = restitution == 0.0
    ux = vel[a, body.VX] + lead_x - vel[partner, body.VX]
    uy = vel[a, body.VY] + lead_y - vel[partner, body.VY]
    rim = vel[a, body.RIM_SPEED] + vel[partner, body.RIM_SPEED]
    if is_dead and gravity > 0.0 and b >= 0:
        # A frozen ball is held by its neighbours, and does not move, whatever its velocity: a fixed
        # ball that moved or turned would drive the other one.
        if state[b, sweep.FROZEN]:
            wb = 0.0
            ux = vel[a, body.VX]
            uy = vel[a, body.VY]
            rim = vel[a, body.RIM_SPEED]
        elif state[a, sweep.FROZEN]:
            wa = 0.0
            ux = -vel[b, body.VX]
            uy = -vel[b, body.VY]
            rim = vel[b, body.RIM_SPEED]
    un = ux * nx + uy * ny
    normal = 0.0
    tangent = 0.0
    if wa + wb > 0.0 and un < parting:
        mass = 1.0 / (wa + wb)
        normal = mass * (max(parting, -restitution * un) - un)
        if friction > 0.0:
            slip = uy * nx - ux * ny - rim
            limit = friction * normal
            tangent = max(-limit, min(limit, -mass * slip * (1.0 / 3.0)))
        jx = normal * nx - tangent * ny
        jy = normal * ny + tangent * nx
        vel[a, body.VX] += wa * jx
        vel[a, body.VY] += wa * jy
        vel[a, body.RIM_SPEED] -= 2.0 * wa * tangent
        vel[partner, body.VX] -= wb * jx
        vel[partner, body.VY] -= wb * jy
        vel[partner, body.RIM_SPEED] -= 2.0 * wb * tangent
    if not is_slow:
        _note_touch(bodies, a, b, start + now, -un, log)
    _count_impact(vel, state, a, is_dead, settings, h - now)
    if b >= 0:
        _count_impact(vel, state, b, is_dead, settings, h - now)
        _freeze_against_frozen(vel, state, a, b, nx, ny, is_dead, settings, h - now)
    if not is_slow:
        normal = 0.0
        tangent = 0.0
    return normal, tangent
