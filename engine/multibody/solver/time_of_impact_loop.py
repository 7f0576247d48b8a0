"""The time-of-impact loop: moves all balls by one substep, impact by impact in the order of time.

Every ball moves along a straight path at its new velocity. Each impact happens at its exact time
and place, with restitution and friction, and both balls continue from there. So no ball passes
through anything, at any speed.

Only the first impact of each ball is predicted, and a winner tree of these times finds the next
one. This is the event-driven simulation of hard discs (Alder and Wainwright, J. Chem. Phys. 1959;
one event per ball: Lubachevsky, J. Comput. Phys. 1991).
"""

from math import inf

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.multibody.solver.broad_phase import beyond_margin
from plinko.engine.multibody.solver.impact import freeze, impact
from plinko.engine.multibody.solver.islands import wake_island
from plinko.engine.multibody.solver.layout import body, pair, sweep
from plinko.engine.multibody.solver.layout.array_types import Floats, Ints
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.pair import NeighbourList
from plinko.engine.multibody.solver.layout.shape import StaticShapes
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.multibody.solver.layout.step_log import StepLog
from plinko.engine.multibody.solver.layout.sweep import Sweeps
from plinko.engine.multibody.solver.neighbour_list import rebuild
from plinko.engine.multibody.solver.prediction import predict, predict_all
from plinko.engine.multibody.solver.sweeps import advance, advance_all, restart_sweep, start_sweeps

MAX_REBUILDS = 32
"""Most rebuilds of the neighbour list in a substep; then leaving its margin freezes a ball."""

# Reasons why the loop stopped.
DONE = 0
STALE = 1


@lean_kernel
def _set_time(tree: Floats, i: int, t: float) -> None:
    """Set the time of ball i's next event, and update the minima on the way to the tree's root.

    On each level, only the sibling is read, because the other value is `t`; so no read waits for
    the previous write. The loop ends at a node whose minimum does not change.
    """
    p = len(tree) // 2 + i
    tree[p] = t
    while p > 1:
        other = tree[p ^ 1]
        t = t if t <= other else other
        p //= 2
        if tree[p] == t:
            break
        tree[p] = t


@lean_kernel
def _next_ball(tree: Floats) -> int:
    """The ball with the next event; of several at the same time, the one with the lowest row."""
    t = tree[1]
    leaves = len(tree) // 2
    p = 1
    while p < leaves:
        p *= 2
        p += int(tree[p] != t)
    return p - leaves


@lean_kernel
def _add_impulse(pairs: NeighbourList, a: int, b: int, normal: float, tangent: float) -> None:
    """Add to the impulse of a pair, which either of its balls may own."""
    starts = pairs.starts
    other = pairs.other
    impulse = pairs.impulse
    for k in range(starts[a], starts[a + 1]):
        if other[k] == b:
            impulse[k, pair.NORMAL] += normal
            impulse[k, pair.TANGENT] += tangent
    if b >= 0:
        for k in range(starts[b], starts[b + 1]):
            if other[k] == a:
                impulse[k, pair.NORMAL] += normal
                impulse[k, pair.TANGENT] += tangent


@lean_kernel
def _collide(
    bodies: Bodies, sweeps: Sweeps, pairs: NeighbourList, items: Floats, i: int, j: int,
    settings: SolverSettings, now: float, start: float, log: StepLog,
) -> bool:  # fmt: skip
    """Compute the impact of ball i with j (a ball, or -1 - item) at `now`, and their new paths.

    Both must be at their places at `now`. Returns whether the impact woke an island.
    """
    marks = bodies.marks
    a = i
    b = j
    woke = False
    if j >= 0:
        a = min(i, j)
        b = max(i, j)
        if (marks[i, body.FLAGS] | marks[j, body.FLAGS]) & body.ASLEEP:
            woke = True
            wake_island(marks, i)
            wake_island(marks, j)
    normal, tangent = impact(bodies, items, sweeps.state, a, b, settings, now, start, log)
    if normal > 0.0:
        _add_impulse(pairs, a, b, normal, tangent)
    restart_sweep(bodies, sweeps, i, now)
    if j >= 0:
        restart_sweep(bodies, sweeps, j, now)
    return woke


@lean_kernel
def _take_from_tree(
    bodies: Bodies, sweeps: Sweeps, pairs: NeighbourList, statics: StaticShapes,
    settings: SolverSettings, start: float, least_threshold: float, may_rebuild: bool,
    candidates: Ints, log: StepLog,
) -> tuple[int, float]:  # fmt: skip
    """Process events in order, until there are no more or the neighbour list must be rebuilt.

    Returns DONE or STALE, and the time in the substep.
    """
    items = statics.items
    bins_y = statics.bins_y
    path = sweeps.path
    state = sweeps.state
    predicted = sweeps.predicted
    tree = sweeps.tree
    h = settings.h
    while tree[1] < h:
        now = tree[1]
        i = _next_ball(tree)
        j = int(predicted[i, sweep.PARTNER])
        if j == sweep.EXPIRY:
            if may_rebuild:
                return STALE, now
            advance(bodies, sweeps, bins_y, i, now, start, log)
            freeze(bodies.vel, state, i, False, settings, h - now)
            state[i, sweep.VERSION] += 1
            restart_sweep(bodies, sweeps, i, now)
        elif j < 0 or state[j, sweep.VERSION] == predicted[i, sweep.PARTNER_VERSION]:
            advance(bodies, sweeps, bins_y, i, now, start, log)
            is_impact = path[i, sweep.STATUS] != sweep.GONE
            if j >= 0:
                advance(bodies, sweeps, bins_y, j, now, start, log)
                is_impact = is_impact and path[j, sweep.STATUS] != sweep.GONE
            if is_impact:
                if _collide(bodies, sweeps, pairs, items, i, j, settings, now, start, log):
                    return STALE, now
            else:
                state[i, sweep.VERSION] += 1
        else:
            j = sweep.NOTHING  # the partner has changed and was predicted again: predict only i
        ball = i
        while True:
            t = inf
            if path[ball, sweep.STATUS] != sweep.GONE:
                s, partner = predict(
                    sweeps, bodies.anchor, items, pairs, ball, now, settings, least_threshold,
                    candidates,
                )  # fmt: skip
                if partner != sweep.NOTHING:
                    t = s
                    predicted[ball, sweep.PARTNER] = partner
                    if partner >= 0:
                        predicted[ball, sweep.PARTNER_VERSION] = state[partner, sweep.VERSION]
            _set_time(tree, ball, t)
            if ball == j or j < 0:
                break
            ball = j
    return DONE, h


@inner_kernel
def take_impacts(
    bodies: Bodies, n: int, pairs: NeighbourList, owner: Ints, statics: StaticShapes,
    settings: SolverSettings, start: float, least_threshold: float, sweeps: Sweeps, log: StepLog,
) -> tuple[NeighbourList, Ints]:  # fmt: skip
    """Move all balls by one substep, which begins `start` s after the start of the step.

    owner (p,): the owner of each pair. least_threshold: a lower bound of all pairs' restitution
    thresholds. Returns the neighbour list and its owners, rebuilt if balls left their margins or
    an island woke.
    """
    h = settings.h
    may_expire = beyond_margin(bodies, n, h)
    if may_expire:
        pairs, owner = rebuild(bodies, n, statics, pairs, settings)
    sweeps.state[:] = 0
    now = 0.0
    rebuilds = 0
    candidates = np.empty(len(owner) + 1, np.int32)
    while True:
        start_sweeps(bodies, n, sweeps, now)
        why = DONE
        if predict_all(
            sweeps, bodies.anchor, n, owner, pairs.other, statics.items, now, settings,
            least_threshold, may_expire, candidates,
        ):  # fmt: skip
            why, now = _take_from_tree(
                bodies, sweeps, pairs, statics, settings, start, least_threshold,
                rebuilds < MAX_REBUILDS, candidates, log,
            )  # fmt: skip
        if why == DONE:
            break
        advance_all(bodies, n, sweeps, statics.bins_y, now, start, log)
        pairs, owner = rebuild(bodies, n, statics, pairs, settings)
        candidates = np.empty(len(owner) + 1, np.int32)
        may_expire = True
        rebuilds += 1
    advance_all(bodies, n, sweeps, statics.bins_y, h, start, log)
    return pairs, owner
