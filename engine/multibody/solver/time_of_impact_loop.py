"""The swept move of balls that touch each other: impacts in the order of time, within a substep.

Every ball moves along a straight line at its new velocity. Pairs that meet do so at the time and
place where they meet, with restitution and friction, and go on from there: nothing is passed
through, at any speed. Each ball knows what it meets first; a tree of times knows who is next.
"""

from math import inf

import numpy as np

from engine.jit.decorator import kernel, lean_kernel
from engine.multibody.solver.broad_phase import beyond_budget
from engine.multibody.solver.impact import hold, impact, wake
from engine.multibody.solver.layout import (
    ASLEEP,
    EVENTS,
    FLAGS,
    REBUILDS,
    VX,
    VY,
    Bodies,
    Floats,
    Ints,
    Lines,
    Log,
    Pairs,
    Settings,
    Statics,
    X,
    Y,
)
from engine.multibody.solver.neighbour_list import renew
from engine.multibody.solver.prediction import (
    END,
    IS_GONE,
    LINE_KIND,
    LINE_U,
    LINE_V,
    LINE_X,
    LINE_Y,
    NOTHING,
    PARTNER,
    STAMP,
    STAMP_THEN,
    WAITING,
    bring,
    bring_all,
    first_events,
    foresee,
    lay_lines,
)

MAX_WINDOWS = 32
"""Lists of pairs made in one substep; a ball that outruns the last one waits for the next."""

# Why a window of events ended.
DONE = 0
STALE = 1


@lean_kernel
def _set_time(tree: Floats, i: int, t: float) -> None:
    """Ball i's next event is at t: the least of each pair of the tree's branches goes up.

    What goes up is at hand, so only the other branch is read, and nothing waits for what was just
    written. Farther up all is as it was where the least is.
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
def _first(tree: Floats) -> int:
    """Whose event is next; of several at one time the first row."""
    t = tree[1]
    leaves = len(tree) // 2
    p = 1
    while p < leaves:
        p *= 2
        p += int(tree[p] != t)
    return p - leaves


@lean_kernel
def _turn(pos: Floats, vel: Floats, at: Floats, state: Ints, i: int, now: float) -> None:
    """Put ball i, now at its place in `pos`, on the line of its new velocity."""
    vx = vel[i, VX]
    vy = vel[i, VY]
    if state[i, WAITING]:
        vx = 0.0
        vy = 0.0
    at[i, LINE_X] = pos[i, X] - vx * now
    at[i, LINE_Y] = pos[i, Y] - vy * now
    at[i, LINE_U] = vx
    at[i, LINE_V] = vy


@lean_kernel
def _keep_impulse(
    starts: Ints, other: Ints, impulse: Floats, a: int, b: int, normal: float, tangent: float
) -> None:
    """Add to the impulse of a pair, which is in the list of one of its balls."""
    for k in range(starts[a], starts[a + 1]):
        if other[k] == b:
            impulse[k, 0] += normal
            impulse[k, 1] += tangent
    if b >= 0:
        for k in range(starts[b], starts[b + 1]):
            if other[k] == a:
                impulse[k, 0] += normal
                impulse[k, 1] += tangent


@lean_kernel
def _play(
    bodies: Bodies, lines: Lines, pairs: Pairs, statics: Statics, settings: Settings,
    start: float, least: float, may_renew: bool, found: Ints, log: Log,
) -> tuple[int, float]:  # fmt: skip
    """Take the events in their order until there are no more, or the list of pairs has to be made
    anew: which it was, and when."""
    pos = bodies.pos
    vel = bodies.vel
    surface = bodies.surface
    marks = bodies.marks
    home = bodies.home
    items = statics.items
    bins_y = statics.bins_y
    floats = log.floats
    ints = log.ints
    landings = log.landings
    landed = log.landed
    counts = log.counts
    at = lines.at
    state = lines.state
    seen = lines.seen
    tree = lines.tree
    near_starts = pairs.near_starts
    near = pairs.near
    gravity = settings.gravity
    h = settings.h
    while tree[1] < h:
        now = tree[1]
        i = _first(tree)
        j = int(seen[i, PARTNER])
        if j == END:
            if may_renew:
                return STALE, now
            bring(pos, vel, at, marks, state, bins_y, i, now, start, landings, landed, counts)
            hold(vel, state, i, False, gravity, h - now, counts)
            state[i, STAMP] += 1
            _turn(pos, vel, at, state, i, now)
        elif j < 0 or state[j, STAMP] == seen[i, STAMP_THEN]:
            bring(pos, vel, at, marks, state, bins_y, i, now, start, landings, landed, counts)
            is_met = at[i, LINE_KIND] != IS_GONE
            if j >= 0:
                bring(pos, vel, at, marks, state, bins_y, j, now, start, landings, landed, counts)
                is_met = is_met and at[j, LINE_KIND] != IS_GONE
            if is_met:
                counts[EVENTS] += 1
                a = i
                b = j
                if j >= 0:
                    a = min(i, j)
                    b = max(i, j)
                woke = False
                if j >= 0 and (marks[i, FLAGS] | marks[j, FLAGS]) & ASLEEP:
                    woke = True
                    wake(marks, i)
                    wake(marks, j)
                normal, tangent = impact(
                    pos, vel, surface, marks, items, state, a, b, gravity, h, now, start,
                    floats, ints, counts,
                )  # fmt: skip
                if normal > 0.0:
                    _keep_impulse(pairs.starts, pairs.other, pairs.impulse, a, b, normal, tangent)
                _turn(pos, vel, at, state, i, now)
                if j >= 0:
                    _turn(pos, vel, at, state, j, now)
                if woke:
                    return STALE, now
            else:
                state[i, STAMP] += 1
        else:
            j = NOTHING  # the partner changed, and foresaw on its own account
        ball = i
        while True:
            t = inf
            if at[ball, LINE_KIND] != IS_GONE:
                s, partner = foresee(
                    at, home, items, near_starts, near, ball, now, h, gravity, least, found
                )
                if partner != NOTHING:
                    t = s
                    seen[ball, PARTNER] = partner
                    if partner >= 0:
                        seen[ball, STAMP_THEN] = state[partner, STAMP]
            _set_time(tree, ball, t)
            if ball == j or j < 0:
                break
            ball = j
    return DONE, h


@kernel
def drift(
    bodies: Bodies, n: int, pairs: Pairs, owner: Ints, statics: Statics, settings: Settings,
    start: float, least: float, lines: Lines, log: Log,
) -> tuple[Pairs, Ints]:  # fmt: skip
    """Move all balls by one substep, which begins `start` seconds into the frame.

    `owner` (p,) is who owns each pair, `least` the least resting speed of all pairs. Returns both
    of the list, renewed if balls went farther than it holds.
    """
    gravity = settings.gravity
    h = settings.h
    horizon = h * settings.substeps
    may_end = beyond_budget(bodies.pos, bodies.vel, bodies.home, bodies.marks, n, h)
    if may_end:
        pairs, owner = renew(bodies, n, statics, pairs, horizon, gravity)
        log.counts[REBUILDS] += 1
    lines.state[:] = 0
    now = 0.0
    windows = 0
    found = np.empty(len(owner) + 1, np.int32)
    while True:
        lay_lines(bodies, n, lines, now)
        why = DONE
        if first_events(
            lines, bodies.home, n, owner, pairs.other, statics.items, found, now, h, gravity, least,
            may_end,
        ):  # fmt: skip
            why, now = _play(
                bodies, lines, pairs, statics, settings, start, least, windows < MAX_WINDOWS, found,
                log,
            )  # fmt: skip
        if why == DONE:
            break
        bring_all(bodies, n, lines, statics, now, start, log)
        pairs, owner = renew(bodies, n, statics, pairs, horizon, gravity)
        found = np.empty(len(owner) + 1, np.int32)
        log.counts[REBUILDS] += 1
        may_end = True
        windows += 1
    bring_all(bodies, n, lines, statics, h, start, log)
    return pairs, owner
