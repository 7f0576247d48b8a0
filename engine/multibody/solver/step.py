"""One step of balls that touch each other, and the order of its phases. Start here.

    for each substep of h seconds:
        wake           islands.py: sleeping islands that an awake ball touches wake up
        velocities     drag and gravity over h; places follow from the new velocities
                       (semi-implicit Euler)
        contacts       contact_solver.py: impulses that stop slow approaches, as in piles
        impacts        time_of_impact_loop.py: balls move, and fast approaches rebound,
                       impact by impact in the order of time
    then, once a step:
        overlap        position_projection.py: moves apart balls that overlap visibly
        sleep          islands.py: islands that were still long enough fall asleep

Contacts come before impacts. A ball at rest on another would otherwise have an impact in every
substep, and a pile would have more and more of them in less and less time. What the contact
solver leaves, the impacts treat exactly, so nothing is passed through at any speed.

All phases work on the pairs of the neighbour list (neighbour_list.py), which is rebuilt only when a
ball leaves its margin, or when islands fall asleep or wake.
"""

from math import inf, sqrt

import numpy as np

from plinko.engine.jit.decorator import kernel, lean_kernel
from plinko.engine.multibody.solver.contact_solver import (
    new_contacts,
    prepare_contacts,
    resist_rolling,
    solve_contacts,
    store_impulses,
    take_back,
    warm_start,
)
from plinko.engine.multibody.solver.islands import (
    count_still_steps,
    put_islands_to_sleep,
    wake_touched,
)
from plinko.engine.multibody.solver.layout import body, shape, step_log
from plinko.engine.multibody.solver.layout.array_types import Floats
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.contact import Contacts
from plinko.engine.multibody.solver.layout.pair import NeighbourList
from plinko.engine.multibody.solver.layout.shape import StaticShapes
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.multibody.solver.layout.step_log import StepLog
from plinko.engine.multibody.solver.neighbour_list import owners, rebuild
from plinko.engine.multibody.solver.position_projection import project_positions
from plinko.engine.multibody.solver.sweeps import new_sweeps
from plinko.engine.multibody.solver.time_of_impact_loop import take_impacts
from plinko.engine.physics.flight import basis

CONTACT_PASSES = 4
"""Most passes over the contacts in a substep. Thanks to the warm start, a pile at rest needs one.
In a falling heap, more passes would cost more than the impacts that they save."""

CONVERGED = 0.02
"""Largest change of an approach by which a pass is the last, as a fraction of the speed that
gravity adds in a substep."""

TAMED = 16.0
"""As CONVERGED, after CONTACT_PASSES. The impulse that carries a heavy ball throws a far lighter
one if the light ball has lost another contact, and few passes would leave it some of that speed."""

MOST_PASSES = 32
"""Most passes if the change is not TAMED. The last CONTACT_PASSES begin without the impulses of the
last substep: from there, no pass adds energy."""


@lean_kernel
def _integrate_velocities(
    bodies: Bodies, n: int, settings: SolverSettings, decay: float, gain: float
) -> None:
    """Apply drag and gravity over a substep, in closed form, and the limit of the speed."""
    for i in range(n):
        if bodies.marks[i, body.FLAGS] & (body.ASLEEP | body.GONE):
            continue
        vx = bodies.vel[i, body.VX] * decay + settings.gravity_x * gain
        vy = bodies.vel[i, body.VY] * decay + settings.gravity_y * gain
        if settings.max_speed < inf:
            speed = sqrt(vx * vx + vy * vy)
            if speed > settings.max_speed:
                vx *= settings.max_speed / speed
                vy *= settings.max_speed / speed
        bodies.vel[i, body.VX] = vx
        bodies.vel[i, body.VY] = vy


@lean_kernel
def _damp(bodies: Bodies, n: int, damping: float) -> None:
    """Multiply all velocities by `damping`."""
    for i in range(n):
        bodies.vel[i, body.VX] *= damping
        bodies.vel[i, body.VY] *= damping
        bodies.vel[i, body.RIM_SPEED] *= damping


@lean_kernel
def _least_threshold(
    bodies: Bodies, n: int, statics: StaticShapes, settings: SolverSettings
) -> float:
    """A lower bound of all pairs' restitution thresholds, m/s; 0 if anything is elastic."""
    for i in range(n):
        if bodies.surface[i, body.RESTITUTION] >= 1.0:
            return 0.0
    for i in range(len(statics.items)):
        if statics.items[i, shape.RESTITUTION] >= 1.0:
            return 0.0
    return 2.0 * settings.gravity * settings.h


@lean_kernel
def _begin(bodies: Bodies, n: int, log: StepLog) -> int:
    """Clear the marks of the previous step and the log; return the number of sleeping balls."""
    asleep = 0
    for i in range(n):
        bodies.marks[i, body.FLAGS] &= ~body.BOUNCED
        if bodies.marks[i, body.FLAGS] & body.ASLEEP:
            asleep += 1
    log.counts[:] = 0
    log.counts[step_log.AWAKE_BEFORE] = n - asleep
    return asleep


@lean_kernel
def _solve_contacts(
    bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes, settings: SolverSettings,
    push_left: Floats, contacts: Contacts,
) -> None:  # fmt: skip
    """Run the contact solver for one substep."""
    count = prepare_contacts(bodies, n, pairs, statics, settings, push_left, contacts)
    warm_start(bodies, count, contacts)
    if settings.rolling > 0.0:
        resist_rolling(bodies, count, contacts, settings.rolling)
    gained = settings.gravity * settings.h
    for passes in range(1, MOST_PASSES + 1):
        change = solve_contacts(bodies.vel, count, contacts)
        if change <= (CONVERGED if passes < CONTACT_PASSES else TAMED) * gained:
            break
        if passes == MOST_PASSES - CONTACT_PASSES:
            take_back(bodies.vel, count, contacts)
    store_impulses(pairs, count, contacts)


@kernel
def step_balls(
    bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes, settings: SolverSettings,
    log: StepLog, is_listed: bool,
) -> NeighbourList:  # fmt: skip
    """Advance all balls by one step; return the current neighbour list.

    If all balls sleep, this only clears the marks of the previous step.

    is_listed: whether `pairs` is valid for these balls; if not, only its impulses are used.
    """
    decay, gain, _ = basis(settings.drag, settings.h)
    least_threshold = _least_threshold(bodies, n, statics, settings)
    asleep = _begin(bodies, n, log)
    if asleep == n:
        return pairs
    if is_listed:
        owner = owners(pairs)
    else:
        pairs, owner = rebuild(bodies, n, statics, pairs, settings)
    push_left = np.empty(n)
    sweeps = new_sweeps(n)
    contacts = new_contacts(pairs)
    if settings.damping != 1.0:
        _damp(bodies, n, settings.damping)
    for k in range(settings.substeps):
        if asleep > 0 and wake_touched(bodies, n, pairs, statics):
            pairs, owner = rebuild(bodies, n, statics, pairs, settings)
        _integrate_velocities(bodies, n, settings, decay, gain)
        if len(contacts.rows) < len(pairs.other):
            contacts = new_contacts(pairs)
        _solve_contacts(bodies, n, pairs, statics, settings, push_left, contacts)
        pairs, owner = take_impacts(
            bodies, n, pairs, owner, statics, settings, k * settings.h, least_threshold, sweeps, log
        )
    if settings.projecting:
        project_positions(bodies, n, pairs, statics, push_left)
    may_sleep = settings.sleep_steps > 0 and count_still_steps(bodies, n, settings) > 0
    if may_sleep and put_islands_to_sleep(bodies, n, pairs, statics, settings):
        pairs, _ = rebuild(bodies, n, statics, pairs, settings)
    return pairs
