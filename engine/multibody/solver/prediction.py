"""The straight lines that balls are on in a substep, and what a ball meets first on its own."""

from math import inf, sqrt

import numpy as np

from engine.jit.decorator import kernel, lean_kernel
from engine.multibody.solver.contact_solver import PUSH_LIMIT, resting_speed
from engine.multibody.solver.layout import (
    ARC,
    ASLEEP,
    BUDGET,
    DEPARTURES,
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
    Statics,
    X,
    Y,
)
from engine.multibody.solver.narrow_phase import SLACK, meets, meets_wall

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

    `turn` is the speed of its rim. One that was pushed across the line by another lands as well.
    """
    v = at[i, LINE_V]
    y = at[i, LINE_Y] + v * at[i, SINCE]
    if v > 0.0 and y < bins_y + PUSH_LIMIT * pos[i, RADIUS]:
        late = min((pos[i, Y] - bins_y) / v, now - at[i, SINCE])
        pos[i, X] -= at[i, LINE_U] * late
        pos[i, Y] = bins_y
        pos[i, ARC] -= turn * late
        marks[i, FLAGS] |= LANDED
        at[i, LINE_KIND] = IS_GONE
        row = counts[LANDINGS]
        counts[LANDINGS] = row + 1
        if row < len(landed):
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
            counts[DEPARTURES] += 1
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
def _meets_item(
    at: Floats, items: Floats, i: int, item: int, x: float, y: float, gravity: float, h: float,
    rest: float,
) -> float:  # fmt: skip
    """Seconds until ball i, now at (x, y), meets a peg or a wall, within `rest`, or inf."""
    u = at[i, LINE_U]
    v = at[i, LINE_V]
    radius = at[i, LINE_RADIUS]
    dx = x - items[item, X1]
    dy = y - items[item, Y1]
    length = items[item, LENGTH]
    reach = radius + items[item, THICKNESS]
    bounce = max(at[i, LINE_BOUNCE], items[item, ITEM_RESTITUTION])
    threshold = resting_speed(bounce, gravity, h, radius)
    tx = items[item, TX]
    ty = items[item, TY]
    s = inf
    if length == 0.0:
        s = meets(dx, dy, u, v, reach, SLACK * radius, threshold, rest)
    elif abs(tx * dy - ty * dx) - abs(tx * v - ty * u) * rest <= reach:
        s = meets_wall(dx, dy, u, v, tx, ty, length, reach, SLACK * radius, threshold, rest)
    return s


@lean_kernel
def _meets_ball(
    at: Floats, a: int, b: int, px: float, py: float, gravity: float, h: float, rest: float
) -> float:
    """Seconds until ball a, seen from ball b at (px, py), meets it within `rest`, or inf.

    One that sleeps is woken by the least touch.
    """
    ra = at[a, LINE_RADIUS]
    rb = at[b, LINE_RADIUS]
    small = ra if ra < rb else rb
    threshold = 0.0
    slack = 0.0
    if at[b, LINE_KIND] == AWAKE:
        bounce = max(at[a, LINE_BOUNCE], at[b, LINE_BOUNCE])
        threshold = resting_speed(bounce, gravity, h, small)
        slack = SLACK * small
    vx = at[a, LINE_U] - at[b, LINE_U]
    vy = at[a, LINE_V] - at[b, LINE_V]
    return meets(px, py, vx, vy, ra + rb, slack, threshold, rest)


@lean_kernel
def may_meet(at: Floats, a: int, b: int, px: float, py: float, least: float, rest: float) -> bool:
    """Whether ball a, seen from ball b at (px, py), can meet it within `rest`.

    Most pairs cannot: those that part, that are too far from each other, or that touch and approach
    slower than `least`, the resting speed of any pair. No branches: they would be guessed badly.
    """
    vx = at[a, LINE_U] - at[b, LINE_U]
    vy = at[a, LINE_V] - at[b, LINE_V]
    ra = at[a, LINE_RADIUS]
    rb = at[b, LINE_RADIUS]
    small = ra if ra < rb else rb
    pv = px * vx + py * vy
    pp = px * px + py * py
    reach = ra + rb
    inner = reach - SLACK * small
    nearest = pp + 2.0 * pv * rest
    is_lively = (pv * pv >= least * least * pp) | (at[b, LINE_KIND] != AWAKE)
    return bool((pv < 0.0) & (nearest <= reach * reach) & (is_lively | (nearest <= inner * inner)))


@lean_kernel
def end_time(at: Floats, home: Floats, i: int, now: float, h: float) -> float:
    """When, in s of the substep, ball i will have gone as far as its pairs hold, or inf."""
    u = at[i, LINE_U]
    v = at[i, LINE_V]
    dx = at[i, LINE_X] + u * h - home[i, HOME_X]
    dy = at[i, LINE_Y] + v * h - home[i, HOME_Y]
    t = inf
    if not dx * dx + dy * dy <= home[i, BUDGET] * home[i, BUDGET]:
        t = now + budget_time(home, i, at[i, LINE_X] + u * now, at[i, LINE_Y] + v * now, u, v)
    return t


@lean_kernel
def _near_that_may(
    at: Floats, near: Ints, first: int, last: int, i: int, x: float, y: float, now: float,
    rest: float, least: float, found: Ints,
) -> int:  # fmt: skip
    """List who of a stretch of `near` ball i, now at (x, y), can meet, and all that is fixed; how
    many there are."""
    count = 0
    for k in range(first, last):
        b = near[k]
        found[count] = b
        ball = b if b >= 0 else i
        px = x - (at[ball, LINE_X] + at[ball, LINE_U] * now)
        py = y - (at[ball, LINE_Y] + at[ball, LINE_V] * now)
        count += int((b < 0) | may_meet(at, i, ball, px, py, least, rest))
    return count


@lean_kernel
def foresee(
    at: Floats, home: Floats, items: Floats, near_starts: Ints, near: Ints, i: int, now: float,
    h: float, gravity: float, least: float, found: Ints,
) -> tuple[float, int]:  # fmt: skip
    """When, in s of the substep, ball i meets what next: a ball, -1 - item, END or NOTHING.

    One event for each ball is enough: who changes foresees all its pairs anew, and who finds that
    its partner changed does so too. Of meetings at one time the first in the list counts.
    """
    best = h
    partner = NOTHING
    x = at[i, LINE_X] + at[i, LINE_U] * now
    y = at[i, LINE_Y] + at[i, LINE_V] * now
    t = end_time(at, home, i, now, h)
    if t < best:
        best = t
        partner = END
    first = near_starts[i]
    last = near_starts[i + 1]
    for m in range(_near_that_may(at, near, first, last, i, x, y, now, best - now, least, found)):
        b = found[m]
        s = inf
        if b < 0:
            s = _meets_item(at, items, i, -1 - b, x, y, gravity, h, best - now)
        elif at[b, LINE_KIND] != IS_GONE:
            px = x - (at[b, LINE_X] + at[b, LINE_U] * now)
            py = y - (at[b, LINE_Y] + at[b, LINE_V] * now)
            s = _meets_ball(at, i, b, px, py, gravity, h, best - now)
        if now + s < best:
            best = now + s
            partner = b
    return best, partner


@lean_kernel
def _candidates(
    at: Floats, owner: Ints, other: Ints, now: float, rest: float, least: float, found: Ints
) -> int:
    """List the pairs of balls that can meet, and all with what is fixed; how many there are."""
    count = 0
    for k in range(len(other)):
        a = owner[k]
        b = other[k]
        found[count] = k
        if b >= 0:
            px = at[a, LINE_X] - at[b, LINE_X] + (at[a, LINE_U] - at[b, LINE_U]) * now
            py = at[a, LINE_Y] - at[b, LINE_Y] + (at[a, LINE_V] - at[b, LINE_V]) * now
            count += int(may_meet(at, a, b, px, py, least, rest))
        else:
            count += 1
    return count


@lean_kernel
def first_events(
    lines: Lines, home: Floats, n: int, owner: Ints, other: Ints, items: Floats, found: Ints,
    now: float, h: float, gravity: float, least: float, may_end: bool,
) -> bool:  # fmt: skip
    """Note for every ball what it meets first of all that it owns a pair with; whether anything is.

    The same as `foresee` of each ball, but every pair is looked at once. `may_end`: whether balls
    may go farther than their pairs hold.
    """
    at = lines.at
    state = lines.state
    seen = lines.seen
    tree = lines.tree
    leaves = len(tree) // 2
    for i in range(n):
        tree[leaves + i] = inf
        if may_end and at[i, LINE_KIND] == AWAKE:
            t = end_time(at, home, i, now, h)
            if t < h:
                tree[leaves + i] = t
                seen[i, PARTNER] = END
    for m in range(_candidates(at, owner, other, now, h - now, least, found)):
        k = found[m]
        a = owner[k]
        b = other[k]
        if at[a, LINE_KIND] != AWAKE:
            continue
        x = at[a, LINE_X] + at[a, LINE_U] * now
        y = at[a, LINE_Y] + at[a, LINE_V] * now
        s = inf
        if b < 0:
            s = _meets_item(at, items, a, -1 - b, x, y, gravity, h, h - now)
        elif at[b, LINE_KIND] != IS_GONE:
            px = x - (at[b, LINE_X] + at[b, LINE_U] * now)
            py = y - (at[b, LINE_Y] + at[b, LINE_V] * now)
            s = _meets_ball(at, a, b, px, py, gravity, h, h - now)
        if now + s < min(h, tree[leaves + a]):
            tree[leaves + a] = now + s
            seen[a, PARTNER] = b
            if b >= 0:
                seen[a, STAMP_THEN] = state[b, STAMP]
    for p in range(leaves - 1, 0, -1):
        left = tree[2 * p]
        right = tree[2 * p + 1]
        tree[p] = left if left <= right else right
    return bool(tree[1] < h)
