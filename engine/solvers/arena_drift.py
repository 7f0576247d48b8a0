"""The swept move of balls that touch each other: impacts in the order of time, within a substep.

Every ball moves along a straight line at its new velocity. Pairs that meet do so at the time and
place where they meet, with restitution and friction, and go on from there: nothing is passed
through, at any speed. Between the impacts each ball has its own time; a heap holds what is next.
"""

from math import inf, sqrt

import numpy as np
import numpy.typing as npt

from engine.kernels.arena_data import (
    ARC,
    ASLEEP,
    BOUNCED,
    BUDGET,
    EVENTS,
    FLAGS,
    GONE,
    HOME_X,
    HOME_Y,
    ID,
    INVERSE_MASS,
    LANDED,
    LANDINGS,
    LOG_A,
    LOG_B,
    LOG_SPEED,
    LOG_T,
    LOG_X,
    LOG_Y,
    RADIUS,
    REBUILDS,
    RING,
    ROLL,
    STILL,
    TOUCHES,
    VX,
    VY,
    WAITS,
    Bodies,
    Floats,
    Ints,
    Log,
    Pairs,
    Settings,
    Statics,
    X,
    Y,
)
from engine.kernels.jit import kernel
from engine.kernels.pair_grid import beyond_budget, budget_time, renew
from engine.kernels.place import SLACK, meets, meets_item
from engine.solvers.arena_contacts import any_direction, pair_surface, resting_speed, separation

MAX_HITS = 16
"""Impacts of one ball in one substep. A ball that meets more is caught between others; it waits
where it is for the next substep, so it cannot be pushed through anything."""

LIVELY_HITS = 8
"""Impacts of one ball in one substep that rebound by less than all; further ones do not rebound.
Balls caught between others would bounce infinitely often otherwise."""

MAX_WINDOWS = 32
"""Lists of pairs made in one substep; a ball that outruns the last one waits likewise."""

PART = 1.0e-3
"""Speed at which a pair that has reached the allowed overlap parts, in allowed overlaps a substep:
above rounding, so that it does not meet again at once, and far below anything seen."""


@kernel
def wake(marks: Ints, i: int) -> None:
    """Wake ball i and all that fell asleep with it."""
    if marks[i, FLAGS] & ASLEEP == 0:
        return
    j = i
    while True:
        marks[j, FLAGS] &= ~ASLEEP
        marks[j, STILL] = 0
        following = marks[j, RING]
        marks[j, RING] = j
        j = following
        if j == i:
            return


Counts = npt.NDArray[np.int64]

# Columns of what is foreseen.
PAIR = 0  # row of the pair, or -1 - ball for the end of its budget
SEER = 1  # who foresaw it
MINE = 2  # stamps of the two at that time
OTHERS = 3
KEYS = 4
NOTHING = -2147483648

# Columns of a drift's work space, for each ball.
HITS = 0
STAMP = 1  # changes with each of the ball's impacts: what was foreseen before no longer holds
WAITING = 2


@kernel
def advance(
    pos: Floats,
    vel: Floats,
    marks: Ints,
    bins_y: float,
    i: int,
    seconds: float,
    end: float,
    landings: Floats,
    landed: Ints,
    counts: Counts,
) -> None:
    """Move ball i along its line; `end` is the time in the frame at which it arrives.

    Where it crosses the bins' line downward, it lands.
    """
    y = pos[i, Y]
    vy = vel[i, VY]
    pos[i, X] += vel[i, VX] * seconds
    pos[i, Y] = y + vy * seconds
    pos[i, ARC] += vel[i, ROLL] * seconds
    if vy > 0.0 and pos[i, Y] >= bins_y > y:
        late = (pos[i, Y] - bins_y) / vy
        pos[i, X] -= vel[i, VX] * late
        pos[i, Y] = bins_y
        pos[i, ARC] -= vel[i, ROLL] * late
        marks[i, FLAGS] |= LANDED
        row = counts[LANDINGS]
        counts[LANDINGS] = row + 1
        if row < landed.shape[0]:
            landings[row, 0] = end - late
            landings[row, 1] = pos[i, X]
            landed[row] = marks[i, ID]


@kernel
def foresee(
    pos: Floats,
    vel: Floats,
    surface: Floats,
    marks: Ints,
    items: Floats,
    gravity: float,
    h: float,
    a: int,
    b: int,
    times: Floats,
    state: Ints,
    now: float,
) -> float:
    """Seconds from `now` until a meets b (a ball, or -1 - item) within the substep, or inf."""
    rest = h - now
    if (marks[a, FLAGS] & GONE) or (b < 0 and state[a, WAITING]):
        return inf
    late = now - times[a]
    vx = vel[a, VX]
    vy = vel[a, VY]
    if state[a, WAITING]:
        vx = 0.0
        vy = 0.0
    x = pos[a, X] + vx * late
    y = pos[a, Y] + vy * late
    ra = pos[a, RADIUS]
    restitution, _ = pair_surface(surface, items, a, b)
    if b < 0:
        threshold = resting_speed(restitution, gravity, h, ra)
        return meets_item(items, -1 - b, x, y, vx, vy, ra, SLACK * ra, threshold, rest)
    if marks[b, FLAGS] & GONE:
        return inf
    if not state[b, WAITING]:
        late = now - times[b]
        x -= vel[b, VX] * late
        y -= vel[b, VY] * late
        vx -= vel[b, VX]
        vy -= vel[b, VY]
    elif state[a, WAITING]:
        return inf
    rb = pos[b, RADIUS]
    small = min(ra, rb)
    threshold = 0.0
    slack = 0.0
    if marks[b, FLAGS] & ASLEEP == 0:
        threshold = resting_speed(restitution, gravity, h, small)
        slack = SLACK * small
    return meets(x - pos[b, X], y - pos[b, Y], vx, vy, ra + rb, slack, threshold, rest)


@kernel
def _note_touch(
    pos: Floats,
    marks: Ints,
    a: int,
    b: int,
    t: float,
    speed: float,
    floats: Floats,
    ints: Ints,
    counts: Counts,
) -> None:
    marks[a, FLAGS] |= BOUNCED
    other = b
    if b >= 0:
        marks[b, FLAGS] |= BOUNCED
        other = marks[b, ID]
    row = counts[TOUCHES]
    counts[TOUCHES] = row + 1
    if row < floats.shape[0]:
        floats[row, LOG_T] = t
        floats[row, LOG_X] = pos[a, X]
        floats[row, LOG_Y] = pos[a, Y]
        floats[row, LOG_SPEED] = speed
        ints[row, LOG_A] = marks[a, ID]
        ints[row, LOG_B] = other


@kernel
def _hold(
    vel: Floats, state: Ints, i: int, is_dead: bool, gravity: float, rest: float, counts: Counts
) -> None:
    """Let ball i wait out the `rest` of the substep: it neither moves nor falls faster meanwhile.

    After impacts that do not rebound it is at rest between others, if gravity presses it there.
    """
    if state[i, WAITING]:
        return
    state[i, WAITING] = 1
    counts[WAITS] += 1
    if is_dead and gravity > 0.0:
        vel[i, VX] = 0.0
        vel[i, VY] = 0.0
    else:
        vel[i, VY] -= gravity * rest


@kernel
def impact(
    pos: Floats,
    vel: Floats,
    surface: Floats,
    marks: Ints,
    items: Floats,
    impulse: Floats,
    gravity: float,
    h: float,
    k: int,
    a: int,
    b: int,
    state: Ints,
    now: float,
    start: float,
    floats: Floats,
    ints: Ints,
    counts: Counts,
) -> bool:
    """Impact of a and b (a ball, or -1 - item), which both are where they are at `now`.

    Velocities of semi-implicit Euler lag half a substep behind the places: a ball that hits what
    is fixed at `now` has fallen g (now - h/2) faster. With that, elastic impacts keep the energy.
    Between balls it cancels. Returns whether somebody woke.
    """
    dx, dy, reach, small = separation(pos, items, a, b)
    distance = sqrt(dx * dx + dy * dy)
    if distance > 0.0:
        nx = dx / distance
        ny = dy / distance
    else:
        nx, ny = any_direction(marks[a, ID], marks[b, ID] if b >= 0 else b)
    woke = False
    partner = vel.shape[0] - 1
    if b >= 0:
        partner = b
        woke = marks[b, FLAGS] & ASLEEP != 0
        wake(marks, b)
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
    if wa + wb > 0.0 and un < part:
        mass = 1.0 / (wa + wb)
        normal = mass * (max(part, -restitution * un) - un)
        tangent = 0.0
        if grip > 0.0:
            slip = uy * nx - ux * ny - vel[a, ROLL] - vel[partner, ROLL]
            tangent = -mass * slip * (1.0 / 3.0)
            limit = grip * normal
            if tangent > limit:
                tangent = limit
            elif tangent < -limit:
                tangent = -limit
        jx = normal * nx - tangent * ny
        jy = normal * ny + tangent * nx
        vel[a, VX] += wa * jx
        vel[a, VY] += wa * jy
        vel[a, ROLL] -= 2.0 * wa * tangent
        vel[partner, VX] -= wb * jx
        vel[partner, VY] -= wb * jy
        vel[partner, ROLL] -= 2.0 * wb * tangent
        if is_slow:
            impulse[k, 0] += normal
            impulse[k, 1] += tangent
    if not is_slow:
        _note_touch(pos, marks, a, b, start + now, approach, floats, ints, counts)
    _count_hit(vel, state, a, is_dead, gravity, h - now, counts)
    if b >= 0:
        _count_hit(vel, state, b, is_dead, gravity, h - now, counts)
        if state[b, WAITING] and vel[a, VX] * nx + vel[a, VY] * ny < 0.0:
            _hold(vel, state, a, is_dead, gravity, h - now, counts)
        if state[a, WAITING] and vel[b, VX] * nx + vel[b, VY] * ny > 0.0:
            _hold(vel, state, b, is_dead, gravity, h - now, counts)
    return woke


@kernel
def _count_hit(
    vel: Floats, state: Ints, i: int, is_dead: bool, gravity: float, rest: float, counts: Counts
) -> None:
    state[i, HITS] += 1
    state[i, STAMP] += 1
    if state[i, HITS] > MAX_HITS:
        _hold(vel, state, i, is_dead, gravity, rest, counts)


@kernel
def _precedes(ts: Floats, keys: Ints, a: int, b: int) -> bool:
    """Total order of what is foreseen: by time, then by pair."""
    return bool(ts[a] < ts[b] or (ts[a] == ts[b] and keys[a, PAIR] < keys[b, PAIR]))


@kernel
def _swap(ts: Floats, keys: Ints, a: int, b: int) -> None:
    t = ts[a]
    ts[a] = ts[b]
    ts[b] = t
    for c in range(KEYS):
        key = keys[a, c]
        keys[a, c] = keys[b, c]
        keys[b, c] = key


@kernel
def push_event(
    ts: Floats, keys: Ints, size: int, t: float, pair: int, i: int, mine: int, others: int
) -> int:
    """Put what ball i foresees into the heap; its new size. The stamps are of now."""
    ts[size] = t
    keys[size, PAIR] = pair
    keys[size, SEER] = i
    keys[size, MINE] = mine
    keys[size, OTHERS] = others
    child = size
    while child > 0:
        parent = (child - 1) // 2
        if not _precedes(ts, keys, child, parent):
            break
        _swap(ts, keys, child, parent)
        child = parent
    return size + 1


@kernel
def drop_first(ts: Floats, keys: Ints, size: int) -> int:
    """Take the first event out of the heap; its new size."""
    size -= 1
    _swap(ts, keys, 0, size)
    parent = 0
    while True:
        child = 2 * parent + 1
        if child >= size:
            return size
        if child + 1 < size and _precedes(ts, keys, child + 1, child):
            child += 1
        if not _precedes(ts, keys, child, parent):
            return size
        _swap(ts, keys, child, parent)
        parent = child


@kernel
def _foresee_next(
    pos: Floats,
    vel: Floats,
    surface: Floats,
    home: Floats,
    marks: Ints,
    items: Floats,
    starts: Ints,
    other: Ints,
    reverse_starts: Ints,
    reverse: Ints,
    owner: Ints,
    gravity: float,
    h: float,
    i: int,
    times: Floats,
    state: Ints,
    now: float,
    ts: Floats,
    keys: Ints,
    size: int,
) -> int:
    """Put the next thing that ball i will meet, or the end of its budget, into the heap.

    Ball i is where it is now. Returns the heap's size. One event of each ball is enough: whoever
    changes foresees all its pairs anew, and who finds that its partner has changed its own.
    """
    if marks[i, FLAGS] & GONE:
        return size
    best = h
    pair = NOTHING
    partner = -1
    rest = h - now
    x = pos[i, X]
    y = pos[i, Y]
    vx = vel[i, VX]
    vy = vel[i, VY]
    is_moving = state[i, WAITING] == 0
    for k in range(starts[i], starts[i + 1]):
        b = other[k]
        if b >= 0 and is_moving and state[b, WAITING] == 0:
            late = now - times[b]
            ux = vx - vel[b, VX]
            uy = vy - vel[b, VY]
            px = x - pos[b, X] - vel[b, VX] * late
            py = y - pos[b, Y] - vel[b, VY] * late
            pv = px * ux + py * uy
            reach = pos[i, RADIUS] + pos[b, RADIUS]
            if pv >= 0.0 or px * px + py * py + 2.0 * pv * rest > reach * reach:
                continue
        t = now + foresee(pos, vel, surface, marks, items, gravity, h, i, b, times, state, now)
        if t < best or (t == best and pair == NOTHING):
            best = t
            pair = k
            partner = b
    for m in range(reverse_starts[i], reverse_starts[i + 1]):
        k = reverse[m]
        a = owner[k]
        if is_moving and state[a, WAITING] == 0:
            late = now - times[a]
            ux = vx - vel[a, VX]
            uy = vy - vel[a, VY]
            px = x - pos[a, X] - vel[a, VX] * late
            py = y - pos[a, Y] - vel[a, VY] * late
            pv = px * ux + py * uy
            reach = pos[i, RADIUS] + pos[a, RADIUS]
            if pv >= 0.0 or px * px + py * py + 2.0 * pv * rest > reach * reach:
                continue
        t = now + foresee(pos, vel, surface, marks, items, gravity, h, a, i, times, state, now)
        if t < best or (t == best and pair == NOTHING):
            best = t
            pair = k
            partner = a
    if not state[i, WAITING]:
        t = now + budget_time(home, vel, i, pos[i, X], pos[i, Y])
        if t < best:
            best = t
            pair = -1 - i
            partner = -1
    if pair == NOTHING:
        return size
    stamp = state[partner, STAMP] if partner >= 0 else 0
    return push_event(ts, keys, size, best, pair, i, state[i, STAMP], stamp)


@kernel
def _first_events(
    pos: Floats,
    vel: Floats,
    surface: Floats,
    home: Floats,
    marks: Ints,
    items: Floats,
    starts: Ints,
    other: Ints,
    gravity: float,
    h: float,
    least: float,
    times: Floats,
    state: Ints,
    now: float,
    ts: Floats,
    keys: Ints,
) -> int:
    """Fill the heap with all that is foreseen at `now`; its size.

    The heap has room for all pairs and all balls. Most pairs do not meet: those that part, that are
    too far from each other, or that touch and approach slower than `least`, the resting speed of
    any pair here, are seen with few operations.
    """
    n = starts.shape[0] - 1
    rest = h - now
    size = 0
    for a in range(n):
        if marks[a, FLAGS] & (ASLEEP | GONE):
            continue
        x = pos[a, X]
        y = pos[a, Y]
        ra = pos[a, RADIUS]
        vx = vel[a, VX]
        vy = vel[a, VY]
        is_moving = state[a, WAITING] == 0
        for k in range(starts[a], starts[a + 1]):
            b = other[k]
            if b >= 0 and is_moving and state[b, WAITING] == 0:
                px = x - pos[b, X]
                py = y - pos[b, Y]
                pv = px * (vx - vel[b, VX]) + py * (vy - vel[b, VY])
                if pv >= 0.0:
                    continue
                reach = ra + pos[b, RADIUS]
                pp = px * px + py * py
                f = pp + 2.0 * pv * rest
                if f > reach * reach:
                    continue
                reach -= SLACK * min(ra, pos[b, RADIUS])
                is_slow = pv * pv < least * least * pp and marks[b, FLAGS] & ASLEEP == 0
                if is_slow and f > reach * reach:
                    continue
            s = foresee(pos, vel, surface, marks, items, gravity, h, a, b, times, state, now)
            if s < inf:
                stamp = state[b, STAMP] if b >= 0 else 0
                size = push_event(ts, keys, size, now + s, k, a, state[a, STAMP], stamp)
        if is_moving:
            dx = x + vx * rest - home[a, HOME_X]
            dy = y + vy * rest - home[a, HOME_Y]
            if not dx * dx + dy * dy <= home[a, BUDGET] * home[a, BUDGET]:
                s = budget_time(home, vel, a, x, y)
                if now + s < h:
                    size = push_event(ts, keys, size, now + s, -1 - a, a, state[a, STAMP], 0)
    return size


@kernel
def _bring(
    pos: Floats,
    vel: Floats,
    marks: Ints,
    bins_y: float,
    i: int,
    times: Floats,
    state: Ints,
    now: float,
    start: float,
    landings: Floats,
    landed: Ints,
    counts: Counts,
) -> None:
    """Bring ball i to the time `now`."""
    if state[i, WAITING] == 0 and marks[i, FLAGS] & (ASLEEP | GONE) == 0 and now > times[i]:
        advance(pos, vel, marks, bins_y, i, now - times[i], start + now, landings, landed, counts)
    times[i] = now


@kernel
def drift(
    bodies: Bodies,
    n: int,
    pairs: Pairs,
    statics: Statics,
    settings: Settings,
    start: float,
    least: float,
    log: Log,
) -> Pairs:
    """Move all balls by one substep, which begins `start` seconds into the frame.

    `least` is the least resting speed of all pairs.

    Returns the list of pairs, renewed if balls went farther than it holds.
    """
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
    gravity = settings.gravity
    h = settings.h
    horizon = h * settings.substeps
    now = 0.0
    windows = 0
    times = np.zeros(n)
    state = np.zeros((n, 3), np.int32)
    if beyond_budget(pos, vel, home, marks, n, h):
        pairs = renew(bodies, n, statics, pairs, horizon, settings.gravity)
        counts[REBUILDS] += 1
    while True:
        room = pairs.other.shape[0] + 4 * n + 64
        ts = np.empty(room)
        keys = np.empty((room, KEYS), np.int32)
        starts = pairs.starts
        other = pairs.other
        impulse = pairs.impulse
        reverse_starts = pairs.reverse_starts
        reverse = pairs.reverse
        owner = pairs.owner
        size = _first_events(
            pos, vel, surface, home, marks, items, starts, other, gravity, h, least,
            times, state, now, ts, keys,
        )  # fmt: skip
        is_stale = False
        while size > 0:
            t = ts[0]
            k = int(keys[0, PAIR])
            i = int(keys[0, SEER])
            mine = keys[0, MINE]
            others = keys[0, OTHERS]
            size = drop_first(ts, keys, size)
            if state[i, STAMP] != mine:
                continue
            now = t
            a = int(owner[k]) if k >= 0 else i
            b = int(other[k]) if k >= 0 else -1
            j = -1
            if k >= 0 and b >= 0:
                j = a + b - i
            _bring(pos, vel, marks, bins_y, i, times, state, now, start, landings, landed, counts)
            if j < 0 or state[j, STAMP] == others:
                if j >= 0:
                    _bring(
                        pos, vel, marks, bins_y, j, times, state, now, start,
                        landings, landed, counts,
                    )  # fmt: skip
                if marks[a, FLAGS] & GONE or (b >= 0 and marks[b, FLAGS] & GONE):
                    state[i, STAMP] += 1
                elif k >= 0:
                    counts[EVENTS] += 1
                    if impact(
                        pos, vel, surface, marks, items, impulse, gravity, h, k,
                        a, b, state, now, start, floats, ints, counts,
                    ):  # fmt: skip
                        is_stale = True
                        break
                elif windows < MAX_WINDOWS:
                    is_stale = True
                    break
                else:
                    _hold(vel, state, a, False, gravity, h - now, counts)
                    state[a, STAMP] += 1
            else:
                j = -1  # the partner changed, and foresaw on its own account
            if size + 2 > ts.shape[0]:
                more = np.empty(2 * size + 64)
                more[:size] = ts[:size]
                ts = more
                more_keys = np.empty((2 * size + 64, KEYS), np.int32)
                more_keys[:size] = keys[:size]
                keys = more_keys
            size = _foresee_next(
                pos, vel, surface, home, marks, items, starts, other, reverse_starts, reverse,
                owner, gravity, h, i, times, state, now, ts, keys, size,
            )  # fmt: skip
            if j >= 0:
                size = _foresee_next(
                    pos, vel, surface, home, marks, items, starts, other, reverse_starts, reverse,
                    owner, gravity, h, j, times, state, now, ts, keys, size,
                )  # fmt: skip
        if not is_stale:
            break
        for i in range(n):
            _bring(pos, vel, marks, bins_y, i, times, state, now, start, landings, landed, counts)
        pairs = renew(bodies, n, statics, pairs, horizon, gravity)
        counts[REBUILDS] += 1
        windows += 1
    for i in range(n):
        if state[i, WAITING] or marks[i, FLAGS] & (ASLEEP | GONE):
            continue
        seconds = h - times[i]
        y = pos[i, Y] + vel[i, VY] * seconds
        if y >= bins_y:
            _bring(pos, vel, marks, bins_y, i, times, state, h, start, landings, landed, counts)
        else:
            pos[i, X] += vel[i, VX] * seconds
            pos[i, Y] = y
            pos[i, ARC] += vel[i, ROLL] * seconds
    return pairs
