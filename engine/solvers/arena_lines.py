"""The straight lines that balls are on in a substep, and what a ball meets first on its own."""

from math import inf, sqrt

import numpy as np

from engine.kernels.arena_data import (
    ARC,
    ASLEEP,
    BUDGET,
    FLAGS,
    GONE,
    HOME_X,
    HOME_Y,
    ID,
    ITEM_RESTITUTION,
    LANDED,
    LANDINGS,
    LEFT,
    LENGTH,
    RADIUS,
    RESTITUTION,
    ROLL,
    THICKNESS,
    TX,
    TY,
    VX,
    VY,
    X1,
    Y1,
    Bodies,
    Counts,
    Floats,
    Ints,
    Lines,
    Log,
    Pairs,
    Statics,
    X,
    Y,
)
from engine.kernels.jit import kernel, lean_kernel
from engine.kernels.place import SLACK, meets, meets_wall
from engine.solvers.arena_contacts import resting_speed

FARTHEST = 1.0e9
"""m from the origin beyond which a ball has left; nearer, its cell's number fits an integer."""

# Columns of `Lines.at`.
LINE_X = 0  # centre in m at the start of the substep, had the ball been on this line then
LINE_Y = 1
LINE_U = 2  # velocity along the line, m/s; zero for a ball that sleeps or waits
LINE_V = 3
LINE_RADIUS = 4
LINE_BOUNCE = 5  # restitution of the ball
LINE_KIND = 6
SINCE = 7  # s: when the ball came to this line
LINE_COLUMNS = 8

# Values of LINE_KIND.
AWAKE = 0.0
SLEEPS = 1.0
IS_GONE = 2.0

# Columns of `Lines.state`.
HITS = 0
STAMP = 1  # changes with each of the ball's impacts: what was foreseen before no longer holds
WAITING = 2

# Columns of `Lines.seen`: what a ball meets first.
PARTNER = 0  # a ball's row, -1 - item, END or NOTHING
STAMP_THEN = 1  # the partner's stamp when this was foreseen

NOTHING = -2147483648
END = -2147483647  # the ball has gone as far as its pairs are listed


@kernel
def new_lines(n: int) -> Lines:
    """Work space for n balls."""
    leaves = 1
    while leaves < n:
        leaves *= 2
    return Lines(
        np.zeros((n, LINE_COLUMNS)),
        np.zeros((n, 3), np.int32),
        np.zeros((n, 2), np.int32),
        np.full(2 * leaves, inf),
    )


@lean_kernel
def lay_lines(bodies: Bodies, n: int, lines: Lines, now: float) -> None:
    """Put every ball on the line that it is on at `now`, where `pos` says it is."""
    pos = bodies.pos
    vel = bodies.vel
    surface = bodies.surface
    marks = bodies.marks
    at = lines.at
    state = lines.state
    for i in range(n):
        flags = marks[i, FLAGS]
        vx = vel[i, VX]
        vy = vel[i, VY]
        if flags & (ASLEEP | GONE) or state[i, WAITING]:
            vx = 0.0
            vy = 0.0
        at[i, LINE_X] = pos[i, X] - vx * now
        at[i, LINE_Y] = pos[i, Y] - vy * now
        at[i, LINE_U] = vx
        at[i, LINE_V] = vy
        at[i, LINE_RADIUS] = pos[i, RADIUS]
        at[i, LINE_BOUNCE] = surface[i, RESTITUTION]
        at[i, LINE_KIND] = IS_GONE if flags & GONE else (SLEEPS if flags & ASLEEP else AWAKE)
        at[i, SINCE] = now


@lean_kernel
def _land(
    pos: Floats, at: Floats, marks: Ints, bins_y: float, i: int, now: float, start: float,
    turn: float, landings: Floats, landed: Ints, counts: Counts,
) -> None:  # fmt: skip
    """Let ball i land if it crossed the bins' line downward on its line, on which it is at `now`.

    `turn` is the speed of its rim.
    """
    v = at[i, LINE_V]
    if v > 0.0 and at[i, LINE_Y] + v * at[i, SINCE] < bins_y:
        late = (pos[i, Y] - bins_y) / v
        pos[i, X] -= at[i, LINE_U] * late
        pos[i, Y] = bins_y
        pos[i, ARC] -= turn * late
        marks[i, FLAGS] |= LANDED
        at[i, LINE_KIND] = IS_GONE
        row = counts[LANDINGS]
        counts[LANDINGS] = row + 1
        if row < landed.shape[0]:
            landings[row, 0] = start + now - late
            landings[row, 1] = pos[i, X]
            landed[row] = marks[i, ID]


@lean_kernel
def bring(
    pos: Floats, vel: Floats, at: Floats, marks: Ints, state: Ints, bins_y: float, i: int,
    now: float, start: float, landings: Floats, landed: Ints, counts: Counts,
) -> None:  # fmt: skip
    """Write to `pos` where ball i is at `now`; where it crosses the bins' line, it lands."""
    if at[i, LINE_KIND] == AWAKE and state[i, WAITING] == 0:
        turn = vel[i, ROLL]
        y = at[i, LINE_Y] + at[i, LINE_V] * now
        pos[i, X] = at[i, LINE_X] + at[i, LINE_U] * now
        pos[i, Y] = y
        pos[i, ARC] += turn * (now - at[i, SINCE])
        if y >= bins_y:
            _land(pos, at, marks, bins_y, i, now, start, turn, landings, landed, counts)
        at[i, SINCE] = now


@lean_kernel
def bring_all(
    bodies: Bodies, n: int, lines: Lines, statics: Statics, now: float, start: float, log: Log
) -> None:
    """`bring` for all balls, and those that are farther out than FARTHEST, or nowhere, leave."""
    pos = bodies.pos
    vel = bodies.vel
    marks = bodies.marks
    at = lines.at
    state = lines.state
    bins_y = statics.bins_y
    landings = log.landings
    landed = log.landed
    counts = log.counts
    for i in range(n):
        bring(pos, vel, at, marks, state, bins_y, i, now, start, landings, landed, counts)
        if not (abs(pos[i, X]) < FARTHEST and abs(pos[i, Y]) < FARTHEST):
            marks[i, FLAGS] |= LEFT
            at[i, LINE_KIND] = IS_GONE


@lean_kernel
def budget_time(home: Floats, i: int, x: float, y: float, vx: float, vy: float) -> float:
    """Seconds until ball i, now at (x, y), has used up its budget; inf if it does not move."""
    vv = vx * vx + vy * vy
    dx = x - home[i, HOME_X]
    dy = y - home[i, HOME_Y]
    left = home[i, BUDGET] * home[i, BUDGET] - dx * dx - dy * dy
    dv = dx * vx + dy * vy
    s = 0.0
    if vv == 0.0:
        s = inf
    elif left > 0.0:
        s = (sqrt(dv * dv + vv * left) - dv) / vv
    return s


@lean_kernel
def _meets_ball(
    px: float, py: float, vx: float, vy: float, ra: float, rb: float, bounce: float,
    is_asleep: bool, gravity: float, h: float, rest: float,
) -> float:  # fmt: skip
    """`meets` for two balls of radii ra, rb; one that sleeps is woken by the least touch."""
    small = min(ra, rb)
    threshold = 0.0
    slack = 0.0
    if not is_asleep:
        threshold = resting_speed(bounce, gravity, h, small)
        slack = SLACK * small
    return meets(px, py, vx, vy, ra + rb, slack, threshold, rest)


@lean_kernel
def foresee(
    at: Floats, home: Floats, items: Floats, near_starts: Ints, near: Ints, i: int, now: float,
    h: float, gravity: float, least: float,
) -> tuple[float, int]:  # fmt: skip
    """When, in s of the substep, ball i meets what next: a ball, -1 - item, END or NOTHING.

    One event for each ball is enough: who changes foresees all its pairs anew, and who finds that
    its partner changed does so too. Most pairs do not meet: those that part, that are too far from
    each other, or that touch and approach slower than `least`, the resting speed of any pair, are
    seen with few operations. Of meetings at one time the first in the list counts.
    """
    best = h
    partner = NOTHING
    u = at[i, LINE_U]
    v = at[i, LINE_V]
    x = at[i, LINE_X] + u * now
    y = at[i, LINE_Y] + v * now
    ra = at[i, LINE_RADIUS]
    dx = at[i, LINE_X] + u * h - home[i, HOME_X]
    dy = at[i, LINE_Y] + v * h - home[i, HOME_Y]
    if not dx * dx + dy * dy <= home[i, BUDGET] * home[i, BUDGET]:
        s = budget_time(home, i, x, y, u, v)
        if now + s < best:
            best = now + s
            partner = END
    for k in range(near_starts[i], near_starts[i + 1]):
        b = near[k]
        rest = best - now
        s = inf
        if b >= 0:
            ub = at[b, LINE_U]
            vb = at[b, LINE_V]
            vx = u - ub
            vy = v - vb
            px = x - (at[b, LINE_X] + ub * now)
            py = y - (at[b, LINE_Y] + vb * now)
            pv = px * vx + py * vy
            if pv < 0.0:
                rb = at[b, LINE_RADIUS]
                reach = ra + rb
                pp = px * px + py * py
                f = pp + 2.0 * pv * rest
                if f <= reach * reach and at[b, LINE_KIND] != IS_GONE:
                    is_asleep = at[b, LINE_KIND] == SLEEPS
                    reach -= SLACK * min(ra, rb)
                    is_slow = pv * pv < least * least * pp and not is_asleep
                    if not is_slow or f <= reach * reach:
                        bounce = max(at[i, LINE_BOUNCE], at[b, LINE_BOUNCE])
                        s = _meets_ball(px, py, vx, vy, ra, rb, bounce, is_asleep, gravity, h, rest)
        else:
            item = -1 - b
            dx = x - items[item, X1]
            dy = y - items[item, Y1]
            length = items[item, LENGTH]
            reach = ra + items[item, THICKNESS]
            if length == 0.0:
                pv = dx * u + dy * v
                if pv < 0.0 and dx * dx + dy * dy + 2.0 * pv * rest <= reach * reach:
                    bounce = max(at[i, LINE_BOUNCE], items[item, ITEM_RESTITUTION])
                    threshold = resting_speed(bounce, gravity, h, ra)
                    s = meets(dx, dy, u, v, reach, SLACK * ra, threshold, rest)
            else:
                tx = items[item, TX]
                ty = items[item, TY]
                if abs(tx * dy - ty * dx) - abs(tx * v - ty * u) * rest <= reach:
                    bounce = max(at[i, LINE_BOUNCE], items[item, ITEM_RESTITUTION])
                    threshold = resting_speed(bounce, gravity, h, ra)
                    s = meets_wall(dx, dy, u, v, tx, ty, length, reach, SLACK * ra, threshold, rest)
        if now + s < best:
            best = now + s
            partner = b
    return best, partner


@lean_kernel
def first_events(
    bodies: Bodies, n: int, lines: Lines, pairs: Pairs, statics: Statics, now: float, h: float,
    gravity: float, least: float,
) -> bool:  # fmt: skip
    """Note for every ball what it meets first of all that it owns a pair with; whether anything is.

    The same as `foresee` of each ball, but every pair is looked at once.
    """
    at = lines.at
    state = lines.state
    seen = lines.seen
    tree = lines.tree
    leaves = tree.shape[0] // 2
    home = bodies.home
    items = statics.items
    starts = pairs.starts
    other = pairs.other
    is_any = False
    for i in range(n):
        tree[leaves + i] = inf
        if at[i, LINE_KIND] != AWAKE:
            continue
        best, partner = foresee(at, home, items, starts, other, i, now, h, gravity, least)
        if partner != NOTHING:
            tree[leaves + i] = best
            seen[i, PARTNER] = partner
            seen[i, STAMP_THEN] = state[partner, STAMP] if partner >= 0 else 0
            is_any = True
    if is_any:
        for p in range(leaves - 1, 0, -1):
            left = tree[2 * p]
            right = tree[2 * p + 1]
            tree[p] = left if left <= right else right
    return is_any
