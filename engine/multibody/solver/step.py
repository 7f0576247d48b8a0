"""A step of balls that touch each other: substeps of semi-implicit Euler, contacts, impacts.

Start here. Of each substep: new velocities, contact solver, time-of-impact loop; of each step:
position projection, then sleep.
"""

from math import inf, sqrt

import numpy as np

from engine.jit.decorator import kernel, lean_kernel
from engine.multibody.solver.contact_solver import (
    new_contacts,
    prepare_contacts,
    solve_contacts,
    store_impulses,
    warm_start,
)
from engine.multibody.solver.islands import count_still_steps, put_islands_to_sleep, wake_touched
from engine.multibody.solver.layout import body, shape, step_log
from engine.multibody.solver.layout.array_types import Floats
from engine.multibody.solver.layout.body import Bodies
from engine.multibody.solver.layout.contact import Contacts
from engine.multibody.solver.layout.pair import NeighbourList
from engine.multibody.solver.layout.shape import StaticShapes
from engine.multibody.solver.layout.solver_settings import SolverSettings
from engine.multibody.solver.layout.step_log import StepLog
from engine.multibody.solver.neighbour_list import owners, rebuild
from engine.multibody.solver.position_projection import project_positions
from engine.multibody.solver.sweeps import new_sweeps
from engine.multibody.solver.time_of_impact_loop import take_impacts
from engine.physics.flight import basis

CONTACT_PASSES = 4
"""Passes over the contacts in a substep, at most. A pile at rest needs one, by its warm start; more
in a heap that falls cost more than the impacts that they save."""

CONVERGED = 0.02
"""Change of an approach, in what gravity adds in a substep, below which a pass was the last."""


@lean_kernel
def _integrate_velocities(
    bodies: Bodies, n: int, settings: SolverSettings, decay: float, gain: float
) -> None:
    """New velocities: drag and gravity over a substep in closed form, and the clamp if there is."""
    for i in range(n):
        if bodies.marks[i, body.FLAGS] & (body.ASLEEP | body.GONE):
            continue
        vx = bodies.vel[i, body.VX] * decay
        vy = bodies.vel[i, body.VY] * decay + settings.gravity * gain
        if settings.max_speed < inf:
            speed = sqrt(vx * vx + vy * vy)
            if speed > settings.max_speed:
                vx *= settings.max_speed / speed
                vy *= settings.max_speed / speed
        bodies.vel[i, body.VX] = vx
        bodies.vel[i, body.VY] = vy


@lean_kernel
def _damp(bodies: Bodies, n: int, damping: float) -> None:
    """Keep that part of all velocities."""
    for i in range(n):
        bodies.vel[i, body.VX] *= damping
        bodies.vel[i, body.VY] *= damping
        bodies.vel[i, body.RIM_SPEED] *= damping


@lean_kernel
def _least_threshold(
    bodies: Bodies, n: int, statics: StaticShapes, settings: SolverSettings
) -> float:
    """The least restitution threshold, m/s, of any pair: none, if something here is elastic."""
    for i in range(n):
        if bodies.surface[i, body.RESTITUTION] >= 1.0:
            return 0.0
    for i in range(len(statics.items)):
        if statics.items[i, shape.RESTITUTION] >= 1.0:
            return 0.0
    return 2.0 * settings.gravity * settings.h


@lean_kernel
def _begin(bodies: Bodies, n: int, log: StepLog) -> int:
    """Take away the marks of the step before and empty the log; how many balls sleep."""
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
    """The contact solver's part of a substep."""
    count = prepare_contacts(bodies, n, pairs, statics, settings, push_left, contacts)
    warm_start(bodies.vel, count, contacts)
    for _ in range(CONTACT_PASSES):
        change = solve_contacts(bodies.vel, count, contacts)
        if change <= CONVERGED * settings.gravity * settings.h:
            break
    store_impulses(pairs, count, contacts)


@kernel
def step_balls(
    bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes, settings: SolverSettings,
    log: StepLog, is_listed: bool,
) -> NeighbourList:  # fmt: skip
    """Advance all balls by one step; returns the neighbour list as it then is.

    Where all sleep it only takes away the marks of the step before.

    `is_listed` says that `pairs` is a list of these balls; else it only has impulses to take over.
    """
    decay, gain, _ = basis(settings.drag, settings.h)
    horizon = settings.h * settings.substeps
    least_threshold = _least_threshold(bodies, n, statics, settings)
    asleep = _begin(bodies, n, log)
    if asleep == n:
        return pairs
    if is_listed:
        owner = owners(pairs)
    else:
        pairs, owner = rebuild(bodies, n, statics, pairs, horizon, settings.gravity)
    push_left = np.empty(n)
    sweeps = new_sweeps(n)
    contacts = new_contacts(pairs)
    if settings.damping != 1.0:
        _damp(bodies, n, settings.damping)
    for k in range(settings.substeps):
        _integrate_velocities(bodies, n, settings, decay, gain)
        if asleep > 0 and wake_touched(bodies, n, pairs, statics):
            pairs, owner = rebuild(bodies, n, statics, pairs, horizon, settings.gravity)
        if len(contacts.rows) < len(pairs.other):
            contacts = new_contacts(pairs)
        _solve_contacts(bodies, n, pairs, statics, settings, push_left, contacts)
        pairs, owner = take_impacts(
            bodies, n, pairs, owner, statics, settings, k * settings.h, least_threshold, sweeps, log
        )
    project_positions(bodies, n, pairs, statics, push_left)
    may_sleep = settings.sleep_steps > 0 and count_still_steps(bodies, n, settings) > 0
    if may_sleep and put_islands_to_sleep(bodies, n, pairs, statics, settings):
        pairs, _ = rebuild(bodies, n, statics, pairs, horizon, settings.gravity)
    return pairs
