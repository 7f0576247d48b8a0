"""Finds what the balls hit first in their windows, by searches side by side.

The chord test excludes most candidates, for all balls at once. The others are searched.

Each loop has the body of the search in circle_impact.py that it names, but computes all cases
without branches. Searches that have ended are computed further, and their results are discarded.
"""

import numpy as np

from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.lanes import lane
from plinko.engine.exact.lanes.flight import dot, look_at
from plinko.engine.exact.lanes.lane import Space
from plinko.engine.exact.next_impact import BINS, BOUNCED, FREE, NOWHERE, origin_line_hit, wall_hit
from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.physics import surface
from plinko.engine.physics.array_types import Floats, Indices, Ints
from plinko.engine.physics.flight import phi2
from plinko.engine.physics.line_impact import line_hit
from plinko.engine.physics.time_of_impact import (
    LEAST_X,
    NEGLIGIBLE,
    NO_HIT,
    SIXTH,
    THIRD,
    stays_positive,
)

RARE = 8
"""A slot is tested for all balls only if at least one ball in RARE has a member in it."""

LOW = 1 << lane.SLOTS
"""The mark of a ball that may reach the bins in this window."""

BEYOND = 2 << lane.SLOTS
"""The mark of a ball whose cell has more members than were tested for all balls."""

FIRST_STEPS = 4
"""Steps of all searches of a list; those that need more are gathered and continued."""

MOST_STEPS = 20
"""Steps of a search, at most; on presets the most are 17."""

# Where the columns of `r` begin, shape (SEARCH_COLUMNS * SEARCHES,): the window's length,
# the motion relative to the circle's centre, bounds of f''', …
SEARCHED = 0 * lane.SEARCHES
FROM_X = 1 * lane.SEARCHES
FROM_Y = 2 * lane.SEARCHES
SPEED_X = 3 * lane.SEARCHES
SPEED_Y = 4 * lane.SEARCHES
ACC_X = 5 * lane.SEARCHES
ACC_Y = 6 * lane.SEARCHES
SQUARE = 7 * lane.SEARCHES  # D^2; 0 for a line
LOW3 = 8 * lane.SEARCHES
SIZE3 = 9 * lane.SEARCHES
# … the search's time s, …
S = 10 * lane.SEARCHES
F = 11 * lane.SEARCHES  # f, f' and f''; for a surface that was just left g(0), g and g'
FD = 12 * lane.SEARCHES
FDD = 13 * lane.SEARCHES
TRUST = 14 * lane.SEARCHES  # h of `circle_search`
STATUS = 15 * lane.SEARCHES  # … and its status:

MISS = 0.0
HIT = 1.0
# Both need the solver for one ball.
SEARCHING = 2.0  # after MOST_STEPS
ALONE = 3.0  # it touches, moves away at first, or does not leave, or its step is lost in rounding


@lean_kernel
def bound3(va: float, aa: float, qa: float, k: float, horizon: float, drags: bool) -> float:
    """`third_derivative_bound` without branches."""
    bound = 6.0 * va if va < 0.0 else 0.0
    if drags:
        rise = qa + 0.5 * aa * horizon * horizon
        rise = rise + va * horizon if va > 0.0 else rise
        bound = bound - 2.0 * k * rise if rise > 0.0 else bound
    return bound


@lean_kernel
def is_far(w: Floats, i: int, x: float, y: float, d2: float, k: float, drags: bool) -> bool:
    """Whether the chord test of `next_impact` excludes a circle at (x, y) for ball i."""
    qx = w[lane.WX + i] - x
    qy = w[lane.WY + i] - y
    horizon = w[lane.HORIZON + i]
    f = qx * qx + qy * qy - d2
    b = qx * w[lane.WVX + i] + qy * w[lane.WVY + i]
    qa = dot(qx, qy, w[lane.WAX + i], w[lane.WAY + i], drags)
    c = w[lane.VV + i] + qa
    low3 = bound3(w[lane.VA + i], w[lane.AA + i], qa, k, horizon, drags)
    return stays_positive(f, b, c + low3 * horizon * SIXTH, horizon)


@lean_kernel
def _mark_slot(w: Floats, m: Ints, n: int, slot: int, k: float, drags: bool) -> None:
    """Mark the balls that may hit their current candidate, member number `slot` of their cells."""
    bit = 1 << slot
    for i in range(n):
        d2 = w[lane.CD2 + i]
        far = is_far(w, i, w[lane.CX + i], w[lane.CY + i], d2, k, drags)
        may_hit = (d2 == 0.0) | (not far)
        may_hit &= (m[lane.MORE + i] > slot) & (m[lane.MEMBER + i] != m[lane.ORIGIN + i])
        m[lane.MARK + i] |= bit if may_hit else 0


@lean_kernel
def _slots_of(m: Ints, n: int) -> int:
    """The number of members of each cell that are tested for all balls together."""
    slots = 1  # the first members are already the current candidates
    while slots < lane.SLOTS:
        longer = 0
        for i in range(n):
            longer += int(m[lane.MORE + i] > slots)
        if RARE * longer < n:
            break
        slots += 1
    return slots


@lean_kernel
def mark(board: BoardArrays, space: Space, n: int, drags: bool) -> tuple[int, int]:
    """Mark what the balls may hit in their windows, and list the lanes with any mark.

    Returns the number of members of each cell that were tested, and the number of lanes listed.
    """
    w, m, members, marked = space.w, space.m, space.members, space.marked
    starts, centres = board.starts, board.centres
    slots = _slots_of(m, n)
    for i in range(n):
        beyond = BEYOND if m[lane.MORE + i] > slots else 0
        is_low = w[lane.WY + i] + board.travel >= board.bins_y
        m[lane.MARK + i] = beyond | (LOW if is_low else 0)
    for slot in range(slots):
        if slot > 0:
            for i in range(n):
                member = members[starts[np.uint32(m[lane.CELL + i])] + slot]
                look_at(w, m, i, member, centres)
        _mark_slot(w, m, n, slot, board.drag, drags)
    found = 0
    for i in range(n):
        marked[np.uint32(found)] = i
        found += int(m[lane.MARK + i] != 0)
    return slots, found


@lean_kernel
def reach_bins(board: BoardArrays, w: Floats, m: Ints, marked: Indices, count: int) -> None:
    """Record which of the balls in marked[:count] land before they hit a surface."""
    for c in range(count):
        i = int(marked[c])
        if m[lane.MARK + i] & LOW:
            best = w[lane.BEST + i]
            y, vy, ay = w[lane.WY + i], w[lane.WVY + i], w[lane.WAY + i]
            s = line_hit(board.bins_y - y, -vy, -ay, board.drag, w[lane.HORIZON + i], best, 0.0)
            if s != NO_HIT and (s < best or m[lane.ITEM + i] == NOWHERE):
                w[lane.BEST + i] = s
                m[lane.ITEM + i] = BINS


@lean_kernel
def _set_search(r: Floats, p: int, w: Floats, i: int, x: float, y: float, d2: float) -> None:
    """Make search p that of ball i for a circle at (x, y)."""
    r[FROM_X + p] = w[lane.WX + i] - x
    r[FROM_Y + p] = w[lane.WY + i] - y
    r[SPEED_X + p] = w[lane.WVX + i]
    r[SPEED_Y + p] = w[lane.WVY + i]
    r[ACC_X + p] = w[lane.WAX + i]
    r[ACC_Y + p] = w[lane.WAY + i]
    r[SEARCHED + p] = w[lane.HORIZON + i]
    r[SQUARE + p] = d2


@lean_kernel
def open_searches(r: Floats, count: int, k: float, drags: bool) -> int:
    """Compute what `circle_search` needs before its first step; returns the padded number."""
    for p in range(count):
        qx, qy = r[FROM_X + p], r[FROM_Y + p]
        vx, vy = r[SPEED_X + p], r[SPEED_Y + p]
        ax, ay = r[ACC_X + p], r[ACC_Y + p]
        horizon = r[SEARCHED + p]
        va = dot(vx, vy, ax, ay, drags)
        aa = dot(ax, ay, ax, ay, drags)
        qa = dot(qx, qy, ax, ay, drags)
        f = qx * qx + qy * qy - r[SQUARE + p]
        size3 = 6.0 * (abs(va) + aa * horizon)
        if drags:
            size3 += 2.0 * k * (abs(qa) + (abs(va) + 0.5 * aa * horizon) * horizon)
        r[S + p] = 0.0
        r[F + p] = f
        r[FD + p] = 2.0 * (qx * vx + qy * vy)
        r[FDD + p] = 2.0 * (vx * vx + vy * vy + qa)
        r[TRUST + p] = horizon
        r[LOW3 + p] = bound3(va, aa, qa, k, horizon, drags)
        r[SIZE3 + p] = size3
        r[STATUS + p] = ALONE if f <= 0.0 else SEARCHING
    return _fill_up(r, count)


@lean_kernel
def _fill_up(r: Floats, count: int) -> int:
    """Pad with ended searches to a multiple of WIDTH; returns the number with these."""
    full = (count + lane.WIDTH - 1) // lane.WIDTH * lane.WIDTH
    for p in range(count, full):
        r[STATUS + p] = MISS
    return full


@lean_kernel
def _some_go_on(r: Floats, count: int) -> bool:
    """Whether any search has not ended."""
    left = 0.0
    for p in range(count):
        left += 1.0 if r[STATUS + p] == SEARCHING else 0.0
    return left > 0.0


@lean_kernel
def _gather(r: Floats, few: Floats, back: Indices, count: int) -> int:
    """Copy the searches that have not ended to `few`; returns their number."""
    found = 0
    for p in range(count):
        back[np.uint32(found)] = p
        found += int(r[STATUS + p] == SEARCHING)
    for column in range(lane.SEARCH_COLUMNS):
        for q in range(found):
            few[column * lane.SEARCHES + q] = r[column * lane.SEARCHES + int(back[q])]
    return found


@lean_kernel
def _put_back(r: Floats, few: Floats, back: Indices, found: int) -> None:
    """Copy the results of the searches in `few` back to `r`."""
    for q in range(found):
        p = int(back[q])
        r[S + p] = few[S + q]
        r[STATUS + p] = few[STATUS + q]


@lean_kernel
def open_again(r: Floats, count: int) -> None:
    """Turn opened searches into those of `circle_hit_again`: g(0) = f'(0), g'(0) = f''(0) / 2."""
    for p in range(count):
        g = r[FD + p]
        gd = 0.5 * r[FDD + p]
        far = stays_positive(g, 0.5 * gd, 0.5 * (r[LOW3 + p] * THIRD), r[SEARCHED + p])
        r[F + p] = g
        r[FDD + p] = gd
        r[STATUS + p] = ALONE if g <= 0.0 else (MISS if far else SEARCHING)


@lean_kernel
def step_again(r: Floats, count: int, k: float, drags: bool) -> bool:
    """One step of each `circle_hit_again`; returns whether any has not ended."""
    for p in range(count):
        g0 = r[F + p]
        g, gd = r[FD + p], r[FDD + p]
        m = r[LOW3 + p] * THIRD
        vx, vy = r[SPEED_X + p], r[SPEED_Y + p]
        ax, ay = r[ACC_X + p], r[ACC_Y + p]
        qa = dot(r[FROM_X + p], r[FROM_Y + p], ax, ay, drags)
        before, status = r[S + p], r[STATUS + p]
        # `halley_step`, and both forms of `minorant_root`
        square = gd * gd
        gm = g * m
        discriminant = square - 2.0 * m * g
        root = np.sqrt(discriminant if discriminant > 0.0 else 0.0)
        falls = gd < 0.0
        rises = gd > 0.0
        divisor = root - gd
        nears = 2.0 * g * gd / (gm - (square + square))
        turns = (gd + root) / -m if rises else 2.0 * g / divisor
        steps = falls & (gm >= LEAST_X * square) & (before + nears != before)
        step = nears if steps else turns
        has_none = (discriminant < 0.0) | (rises & (m >= 0.0)) | ((not rises) & (divisor <= 0.0))
        is_out = square < gm + gm if falls else has_none
        s = before + step
        is_out |= s > r[SEARCHED + p]
        is_near = 2.0 * (r[SIZE3 + p] * THIRD) * step * step <= NEGLIGIBLE * g0
        c = phi2(k * s) if drags else 0.5
        c1 = s * c
        c1d = 1.0 - k * c1 - c if drags else 0.5
        wx = vx + ax * c1 if drags else vx
        wy = vy + ay * c1
        ww = wx * wx + wy * wy
        g = g0 + 2.0 * qa * c1 + s * ww
        is_hit = is_near | (s == before) | (g <= 0.0)
        found = MISS if is_out else (HIT if is_hit else SEARCHING)
        goes_on = status == SEARCHING
        r[S + p] = s if goes_on else before
        r[STATUS + p] = found if goes_on else status
        r[FD + p] = g
        r[FDD + p] = 2.0 * qa * c1d + ww + 2.0 * s * c1d * dot(wx, wy, ax, ay, drags)
    return _some_go_on(r, count)


@lean_kernel
def search_again(board: BoardArrays, space: Space, fresh: int, active: int, drags: bool) -> None:
    """Record which balls in the lanes ended[:fresh] hit again the surface that they have left."""
    w, m, r, few, back, whose = space.w, space.m, space.r, space.few, space.back, space.whose
    items = board.items
    k = board.drag
    count = 0
    for c in range(fresh):
        i = int(space.ended[c])
        origin = m[lane.ORIGIN + i]
        if i >= active or origin < 0:
            continue
        if items[origin, surface.DISTANCE] > 0.0:
            x, y = items[origin, surface.X], items[origin, surface.Y]
            whose[np.uint32(count)] = i
            _set_search(r, count, w, i, x, y, items[origin, surface.DISTANCE2])
            count += 1
        else:
            x, y, vx, vy, ax, ay, _ = lane.motion_of(w, i, k)
            side, horizon = w[lane.ORIGIN_SIDE + i], w[lane.HORIZON + i]
            s = origin_line_hit(items, origin, side, x, y, vx, vy, ax, ay, k, horizon)
            _note_again(w, m, i, s)
    open_searches(r, count, k, drags)
    open_again(r, count)
    found = _gather(r, few, back, count)
    full = _fill_up(few, found)
    for _ in range(MOST_STEPS):
        if not step_again(few, full, k, drags):
            break
    _put_back(r, few, back, found)
    for p in range(count):
        i = int(whose[p])
        m[lane.ODD + i] |= int(r[STATUS + p] >= SEARCHING)
        _note_again(w, m, i, r[S + p] if r[STATUS + p] == HIT else NO_HIT)


@lean_kernel
def _note_again(w: Floats, m: Ints, i: int, s: float) -> None:
    """Record that ball i hits again after s the surface it has left, unless s is NO_HIT."""
    if s != NO_HIT:
        w[lane.BEST + i] = s
        m[lane.ITEM + i] = m[lane.ORIGIN + i]
        w[lane.HIT_SIDE + i] = w[lane.ORIGIN_SIDE + i]


@lean_kernel
def _list_marked(
    board: BoardArrays, space: Space, at: int, count: int, slots: int, drags: bool
) -> tuple[int, int]:
    """List the candidates of the lanes marked[at:count] as searches, until the list is half full.

    The first `slots` members of each cell have been tested; the others are tested here. A ball with
    too many candidates for the list goes to the solver for one ball. Returns the next lane's place
    in `marked`, and the number of searches.
    """
    w, m, whose, which, members = space.w, space.m, space.whose, space.which, space.members
    starts, centres = board.starts, board.centres
    length = 0
    while at < count and length < lane.SEARCHES // 2:
        i = int(space.marked[at])
        at += 1
        cell = np.uint32(m[lane.CELL + i])
        first = starts[cell]
        more = starts[cell + 1] - first
        for slot in range(slots):
            which[np.uint32(length)] = members[first + slot]
            whose[np.uint32(length)] = i
            length += (m[lane.MARK + i] >> slot) & 1
        for slot in range(slots, more):
            if length == lane.SEARCHES - lane.WIDTH:
                m[lane.ODD + i] = 1
                break
            other = members[first + slot]
            x, y, d2 = centres[other, 0], centres[other, 1], centres[other, 2]
            may_hit = (d2 == 0.0) | (not is_far(w, i, x, y, d2, board.drag, drags))
            which[np.uint32(length)] = other
            whose[np.uint32(length)] = i
            length += int(may_hit & (other != m[lane.ORIGIN + i]))
    for p in range(length):
        other = which[p]
        x, y, d2 = centres[other, 0], centres[other, 1], centres[other, 2]
        _set_search(space.r, p, w, int(whose[p]), x, y, d2)
    return at, length


@lean_kernel
def step_searches(r: Floats, count: int, k: float, drags: bool) -> bool:
    """One step of each `circle_search`; returns whether any has not ended."""
    for p in range(count):
        f, fd = r[F + p], r[FD + p]
        h, low3 = r[TRUST + p], r[LOW3 + p]
        d2, horizon = r[SQUARE + p], r[SEARCHED + p]
        before, status = r[S + p], r[STATUS + p]
        vx, vy = r[SPEED_X + p], r[SPEED_Y + p]
        ax, ay = r[ACC_X + p], r[ACC_Y + p]
        m = r[FDD + p] + low3 * h * THIRD
        square = fd * fd
        fm = f * m
        step = 2.0 * f * fd / (fm - (square + square))
        is_free = (square < fm + fm) | (step > h)
        is_out = is_free & (before + h >= horizon)
        enough = NEGLIGIBLE * d2
        change = r[SIZE3 + p] * step - low3 * h
        is_near = (change * step * step <= 3.0 * enough) & (f * fm * fm <= enough * square * square)
        step = h if is_free else step
        h = h + h if is_free else step
        s = before + step
        psi = s * s * phi2(k * s) if drags else 0.5 * s * s
        phi = s - k * psi if drags else s
        px = r[FROM_X + p] + vx * s
        px = px + ax * psi if drags else px
        py = r[FROM_Y + p] + vy * s + ay * psi
        ux = vx + ax * phi if drags else vx
        uy = vy + ay * phi
        f = px * px + py * py - d2
        pull = dot(px, py, ax, ay, drags)
        pull = (1.0 - k * phi) * pull if drags else pull
        rest = horizon - s
        is_hit = ((not is_free) & is_near) | (f <= 0.0)
        is_over = is_out | ((not is_hit) & (h > rest) & (rest <= 0.0))
        found = MISS if is_over else (HIT if is_hit else SEARCHING)
        found = ALONE if (fd >= 0.0) | (s == before) else found
        goes_on = status == SEARCHING
        r[S + p] = s if goes_on else before
        r[STATUS + p] = found if goes_on else status
        r[F + p] = f
        r[FD + p] = 2.0 * (px * ux + py * uy)
        r[FDD + p] = 2.0 * (ux * ux + uy * uy + pull)
        r[TRUST + p] = rest if h > rest else h
    return _some_go_on(r, count)


@lean_kernel
def _keep_first(board: BoardArrays, space: Space, count: int) -> None:
    """Record the first hit of each ball; at equal times the lower surface number counts."""
    w, m, r = space.w, space.m, space.r
    for p in range(count):
        i = int(space.whose[p])
        other = int(space.which[p])
        status = r[STATUS + p]
        best = w[lane.BEST + i]
        s = r[S + p] if status == HIT else NO_HIT
        side = 0.0
        if r[SQUARE + p] == 0.0:
            origin = m[lane.ORIGIN + i]
            how = FREE if origin < 0 else BOUNCED
            motion = lane.motion_of(w, i, board.drag)
            horizon = w[lane.HORIZON + i]
            s, side = wall_hit(
                board.items, other, origin, how, board.radius, motion, horizon, best
            )  # fmt: skip
        elif status >= SEARCHING:
            m[lane.ODD + i] = 1
        item = m[lane.ITEM + i]
        if s != NO_HIT and (s < best or item == NOWHERE or (s == best and other < item)):
            w[lane.BEST + i] = s
            m[lane.ITEM + i] = other
            w[lane.HIT_SIDE + i] = side


@lean_kernel
def search_marked(board: BoardArrays, space: Space, count: int, slots: int, drags: bool) -> None:
    """Record the first surface of its cell that each ball in the lanes marked[:count] hits."""
    r, few, back = space.r, space.few, space.back
    k = board.drag
    at = 0
    while at < count:
        at, length = _list_marked(board, space, at, count, slots, drags)
        full = open_searches(r, length, k, drags)
        goes_on = True
        for _ in range(FIRST_STEPS):
            if goes_on:
                goes_on = step_searches(r, full, k, drags)
        if goes_on:
            found = _gather(r, few, back, full)
            wide = _fill_up(few, found)
            for _ in range(FIRST_STEPS, MOST_STEPS):
                if not step_searches(few, wide, k, drags):
                    break
            _put_back(r, few, back, found)
        _keep_first(board, space, length)
