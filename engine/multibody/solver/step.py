"""A frame of balls that touch each other: substeps of semi-implicit Euler, contacts, impacts."""

from math import inf, sqrt

import numpy as np

from engine.jit.decorator import kernel, lean_kernel
from engine.multibody.solver.contact_solver import (
    CONTACT_COLUMNS,
    PUSH_LIMIT,
    gather,
    keep_impulses,
    part_deep,
    solve,
    warm_start,
)
from engine.multibody.solver.islands import count_still, send_to_sleep, wake_touched
from engine.multibody.solver.layout import (
    ASLEEP,
    AWAKE_THEN,
    BOUNCED,
    CONTACTS,
    FLAGS,
    GONE,
    ITEM_RESTITUTION,
    RADIUS,
    REBUILDS,
    RESTITUTION,
    ROLL,
    VX,
    VY,
    Bodies,
    Log,
    Pairs,
    Settings,
    Statics,
)
from engine.multibody.solver.neighbour_list import owners, renew
from engine.multibody.solver.prediction import new_lines
from engine.multibody.solver.time_of_impact_loop import drift
from engine.physics.flight import basis

PASSES = 4
"""Passes over the contacts in a substep, at most. A pile at rest needs one, by its warm start; more
in a heap that falls cost more than the impacts that they save."""

SWEEPS = 64
"""Passes over the pairs that overlap too much at the end of a frame, at most; mostly none does."""

CALM = 0.02
"""Change of an approach, in what gravity adds in a substep, below which a pass was the last."""


@lean_kernel
def _kick(bodies: Bodies, n: int, settings: Settings, decay: float, gain: float) -> None:
    """New velocities: drag and gravity over a substep in closed form, and the clamp if there is."""
    for i in range(n):
        if bodies.marks[i, FLAGS] & (ASLEEP | GONE):
            continue
        vx = bodies.vel[i, VX] * decay
        vy = bodies.vel[i, VY] * decay + settings.gravity * gain
        if settings.max_speed < inf:
            speed = sqrt(vx * vx + vy * vy)
            if speed > settings.max_speed:
                vx *= settings.max_speed / speed
                vy *= settings.max_speed / speed
        bodies.vel[i, VX] = vx
        bodies.vel[i, VY] = vy


@lean_kernel
def _damp(bodies: Bodies, n: int, damping: float) -> None:
    for i in range(n):
        bodies.vel[i, VX] *= damping
        bodies.vel[i, VY] *= damping
        bodies.vel[i, ROLL] *= damping


@lean_kernel
def _least_resting_speed(bodies: Bodies, n: int, statics: Statics, settings: Settings) -> float:
    """The least resting speed, m/s, of any pair: none, if something here is elastic."""
    surface = bodies.surface
    items = statics.items
    for i in range(n):
        if surface[i, RESTITUTION] >= 1.0:
            return 0.0
    for i in range(len(items)):
        if items[i, ITEM_RESTITUTION] >= 1.0:
            return 0.0
    return 2.0 * settings.gravity * settings.h


@kernel
def frame(
    bodies: Bodies, n: int, pairs: Pairs, statics: Statics, settings: Settings, log: Log,
    is_listed: bool,
) -> Pairs:  # fmt: skip
    """Advance all balls by one frame; returns the list of pairs as it then is.

    Where all sleep it only takes away the marks of the frame before.

    `is_listed` says that `pairs` is a list of these balls; else it only has impulses to take over.
    """
    decay, gain, _ = basis(settings.drag, settings.h)
    horizon = settings.h * settings.substeps
    pos = bodies.pos
    vel = bodies.vel
    least = _least_resting_speed(bodies, n, statics, settings)
    asleep = 0
    for i in range(n):
        bodies.marks[i, FLAGS] &= ~BOUNCED
        if bodies.marks[i, FLAGS] & ASLEEP:
            asleep += 1
    log.counts[:] = 0
    log.counts[AWAKE_THEN] = n - asleep
    if asleep == n:
        return pairs
    if is_listed:
        owner = owners(pairs)
    else:
        pairs, owner = renew(bodies, n, statics, pairs, horizon, settings.gravity)
        log.counts[REBUILDS] += 1
    room = np.empty(n)
    lines = new_lines(n)
    rows = np.empty((len(pairs.other), CONTACT_COLUMNS))
    ends = np.empty((len(pairs.other), 3), np.int32)
    if settings.damping != 1.0:
        _damp(bodies, n, settings.damping)
    for k in range(settings.substeps):
        _kick(bodies, n, settings, decay, gain)
        if asleep > 0 and wake_touched(bodies, n, pairs, statics):
            pairs, owner = renew(bodies, n, statics, pairs, horizon, settings.gravity)
            log.counts[REBUILDS] += 1
        if len(rows) < len(pairs.other):
            rows = np.empty((len(pairs.other), CONTACT_COLUMNS))
            ends = np.empty((len(pairs.other), 3), np.int32)
        impulse = pairs.impulse
        count = gather(
            pos, vel, bodies.surface, bodies.marks, statics.items, pairs.starts, pairs.other,
            impulse, settings.gravity, settings.h, settings.correction, room, ends, rows,
        )  # fmt: skip
        warm_start(vel, count, ends, rows)
        for _ in range(PASSES):
            if solve(vel, count, ends, rows) <= CALM * settings.gravity * settings.h:
                break
        keep_impulses(impulse, count, ends, rows)
        log.counts[CONTACTS] = count
        pairs, owner = drift(
            bodies, n, pairs, owner, statics, settings, k * settings.h, least, lines, log
        )
    for i in range(n):
        room[i] = PUSH_LIMIT * pos[i, RADIUS]
    for _ in range(SWEEPS):
        if not part_deep(pos, vel, bodies.marks, statics.items, pairs.starts, pairs.other, room):
            break
    may_sleep = settings.sleep_frames > 0 and count_still(bodies, n, settings) > 0
    if may_sleep and send_to_sleep(bodies, n, pairs, statics, settings):
        pairs, _ = renew(bodies, n, statics, pairs, horizon, settings.gravity)
    return pairs
