"""Sweeps: the straight paths of the balls in a substep, and moving balls along them.

A path is stored by its place at the start of the substep, to which it is extrapolated back. So a
ball needs to be moved only when it has an impact and when the substep ends.
"""

from math import inf

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.multibody.solver.layout import body, step_log, sweep
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.step_log import StepLog
from plinko.engine.multibody.solver.layout.sweep import Sweeps
from plinko.engine.multibody.solver.position_projection import PUSH_LIMIT

FARTHEST = 1.0e9
"""Distance from the origin in m beyond which a ball has left. Within it, the numbers of its cell
fit into an integer."""


@inner_kernel
def new_sweeps(n: int) -> Sweeps:
    """Work space for n balls."""
    leaves = 1
    while leaves < n:
        leaves *= 2
    return Sweeps(
        np.zeros((n, sweep.COLUMNS)),
        np.zeros((n, 3), np.int32),
        np.zeros((n, 2), np.int32),
        np.full(2 * leaves, inf),
    )


@lean_kernel
def start_sweeps(bodies: Bodies, n: int, sweeps: Sweeps, now: float) -> None:
    """Set every ball's path from its place in `pos` and its velocity at `now`."""
    pos = bodies.pos
    marks = bodies.marks
    path = sweeps.path
    for i in range(n):
        flags = marks[i, body.FLAGS]
        vx = bodies.vel[i, body.VX]
        vy = bodies.vel[i, body.VY]
        if flags & (body.ASLEEP | body.GONE) or sweeps.state[i, sweep.FROZEN]:
            vx = 0.0
            vy = 0.0
        status = sweep.AWAKE
        if flags & body.GONE:
            status = sweep.GONE
        elif flags & body.ASLEEP:
            status = sweep.ASLEEP
        path[i, sweep.X0] = pos[i, body.X] - vx * now
        path[i, sweep.Y0] = pos[i, body.Y] - vy * now
        path[i, sweep.VX] = vx
        path[i, sweep.VY] = vy
        path[i, sweep.RADIUS] = pos[i, body.RADIUS]
        path[i, sweep.RESTITUTION] = bodies.surface[i, body.RESTITUTION]
        path[i, sweep.STATUS] = status
        path[i, sweep.SINCE] = now


@lean_kernel
def restart_sweep(bodies: Bodies, sweeps: Sweeps, i: int, now: float) -> None:
    """Set ball i's path from its place in `pos` and its new velocity at `now`."""
    path = sweeps.path
    vx = bodies.vel[i, body.VX]
    vy = bodies.vel[i, body.VY]
    if sweeps.state[i, sweep.FROZEN]:
        vx = 0.0
        vy = 0.0
    path[i, sweep.X0] = bodies.pos[i, body.X] - vx * now
    path[i, sweep.Y0] = bodies.pos[i, body.Y] - vy * now
    path[i, sweep.VX] = vx
    path[i, sweep.VY] = vy


@lean_kernel
def _land(
    bodies: Bodies, sweeps: Sweeps, bins_y: float, i: int, now: float, start: float, log: StepLog
) -> None:
    """Mark ball i as landed if it crossed the bins' line downward on its path until `now`.

    A ball that another pushed across the line has landed too.
    """
    pos = bodies.pos
    path = sweeps.path
    v = path[i, sweep.VY]
    y = path[i, sweep.Y0] + v * path[i, sweep.SINCE]
    if v > 0.0 and y < bins_y + PUSH_LIMIT * pos[i, body.RADIUS]:
        late = min((pos[i, body.Y] - bins_y) / v, now - path[i, sweep.SINCE])
        pos[i, body.X] -= path[i, sweep.VX] * late
        pos[i, body.Y] = bins_y
        pos[i, body.RIM_ARC] -= bodies.vel[i, body.RIM_SPEED] * late
        bodies.marks[i, body.FLAGS] |= body.LANDED
        path[i, sweep.STATUS] = sweep.GONE
        row = log.counts[step_log.LANDINGS]
        log.counts[step_log.LANDINGS] = row + 1
        if row < len(log.landed):
            log.landings[row, 0] = start + now - late
            log.landings[row, 1] = pos[i, body.X]
            log.landed[row] = bodies.marks[i, body.ID]


@lean_kernel
def advance(
    bodies: Bodies, sweeps: Sweeps, bins_y: float, i: int, now: float, start: float, log: StepLog
) -> None:
    """Move ball i in `pos` along its path to `now`; it lands if it crosses the bins' line.

    now: s since the start of the substep, which begins `start` s after the start of the step.
    """
    pos = bodies.pos
    path = sweeps.path
    if path[i, sweep.STATUS] == sweep.AWAKE and sweeps.state[i, sweep.FROZEN] == 0:
        y = path[i, sweep.Y0] + path[i, sweep.VY] * now
        pos[i, body.X] = path[i, sweep.X0] + path[i, sweep.VX] * now
        pos[i, body.Y] = y
        pos[i, body.RIM_ARC] += bodies.vel[i, body.RIM_SPEED] * (now - path[i, sweep.SINCE])
        if y >= bins_y:
            _land(bodies, sweeps, bins_y, i, now, start, log)
        path[i, sweep.SINCE] = now


@lean_kernel
def advance_all(
    bodies: Bodies, n: int, sweeps: Sweeps, bins_y: float, now: float, start: float, log: StepLog
) -> None:
    """`advance` all balls; those beyond FARTHEST, or whose place is NaN, have left."""
    pos = bodies.pos
    for i in range(n):
        advance(bodies, sweeps, bins_y, i, now, start, log)
        if not (abs(pos[i, body.X]) < FARTHEST and abs(pos[i, body.Y]) < FARTHEST):
            bodies.marks[i, body.FLAGS] |= body.LEFT
            log.counts[step_log.DEPARTURES] += 1
            sweeps.path[i, sweep.STATUS] = sweep.GONE
