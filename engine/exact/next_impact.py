"""Finds the next impact of a ball in free flight: which surface it hits first, and when."""

from plinko.engine.exact.board_arrays import BoardArrays, cell_of
from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.physics import surface
from plinko.engine.physics.array_types import Floats
from plinko.engine.physics.circle_impact import (
    Motion,
    circle_hit_after_leaving,
    circle_hit_after_lifting,
    circle_hit_again,
    circle_search,
    third_derivative_bound,
)
from plinko.engine.physics.flight import SERIES_LIMIT, basis, half_chord, short_basis
from plinko.engine.physics.line_impact import line_hit, line_hit_again
from plinko.engine.physics.surface import side_of
from plinko.engine.physics.time_of_impact import NEGLIGIBLE, NO_HIT, SIXTH, stays_positive

MAX_WINDOWS = 1_000_000
"""Search windows in one flight, at most. A flight on a valid board has some thousands: 160 while
drag takes the ball to its terminal velocity, and then one for each `travel` of its way."""

SQRT2_LESS_1 = 0.41421356237309515  # rounded up

# What a flight ends at, if not at a surface, whose number is not negative.
BINS = -1
NOWHERE = -2  # nothing in this window; the search goes on
FAR_OUT = -3  # this code and the next two end the search
OUT_OF_TIME = -4
OUT_OF_WINDOWS = -5

# How the ball left the surface from which a flight starts. Listed is which of the distance f to it
# and of the derivatives of f are zero at the start: that root is divided out.
FREE = 0  # the flight does not start from a surface
BOUNCED = 1  # f
ROLLED_OFF = 2  # f, f' and f'': the normal force has just become zero
LIFTED = 3  # f and f': the ball has no speed off the surface, but is not pressed onto it


@inner_kernel
def origin_line_hit(
    items: Floats, origin: int, side: float, x: float, y: float, vx: float, vy: float,
    ax: float, ay: float, k: float, horizon: float,
) -> float:  # fmt: skip
    """When a ball that has just left `side` of the line `origin` hits it again, or NO_HIT."""
    nx = items[origin, surface.NX]
    ny = items[origin, surface.NY]
    hd = side * (nx * vx + ny * vy)
    hdd = side * (nx * ax + ny * ay)
    s = line_hit_again(hd, hdd, k, horizon, horizon)
    if s != NO_HIT and not _foot_inside(items, origin, x, y, vx, vy, ax, ay, k, s):
        s = NO_HIT
    return s


@inner_kernel
def _hit_again(
    items: Floats, item: int, side: float, how: int, motion: Motion, horizon: float
) -> float:
    """When the ball hits again a surface that it has just left, or NO_HIT."""
    x, y, vx, vy, ax, ay, k = motion
    if items[item, surface.DISTANCE] == 0.0:
        if how == LIFTED:
            return NO_HIT  # the acceleration off a line keeps its sign
        return origin_line_hit(items, item, side, x, y, vx, vy, ax, ay, k, horizon)
    d2 = items[item, surface.DISTANCE2]
    qx = x - items[item, surface.X]
    qy = y - items[item, surface.Y]
    if how == BOUNCED:
        return circle_hit_again(qx, qy, vx, vy, ax, ay, k, horizon, horizon)
    if how == LIFTED:
        return circle_hit_after_lifting(qx, qy, vx, vy, ax, ay, k, d2, horizon, horizon)
    return circle_hit_after_leaving(qx, qy, vx, vy, ax, ay, k, d2, horizon, horizon)


@lean_kernel
def _foot_inside(
    items: Floats, line: int, x: float, y: float, vx: float, vy: float, ax: float, ay: float,
    k: float, s: float,
) -> bool:  # fmt: skip
    """Whether the ball's foot lies between a line's ends, within rounding, s seconds into a flight.

    A line and its end meet without an angle, so a ball may touch both there. Without the rounding,
    neither could own the place where they meet.
    """
    _, _, psi = short_basis(k, s)
    x = x + vx * s + ax * psi
    y = y + vy * s + ay * psi
    foot = (x - items[line, surface.X]) * items[line, surface.TX] + (
        y - items[line, surface.Y]
    ) * items[line, surface.TY]
    near = surface.rounding(x, y)
    return bool(-near <= foot <= items[line, surface.LENGTH] + near)


@lean_kernel
def _line_hit_between_ends(
    items: Floats,
    wall: int,
    radius: float,
    x: float,
    y: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    k: float,
    horizon: float,
    best: float,
) -> tuple[float, float]:
    """When the ball hits a wall between its ends, or NO_HIT; and on which side."""
    nx = items[wall, surface.NX]
    ny = items[wall, surface.NY]
    d = nx * (x - items[wall, surface.X]) + ny * (y - items[wall, surface.Y])
    dv = nx * vx + ny * vy
    da = nx * ax + ny * ay
    near = surface.rounding(x, y)
    found = NO_HIT
    found_side = 0.0
    for way in range(2):
        side = 1.0 - 2.0 * way
        h = side * d - radius
        hd = side * dv
        hdd = side * da
        if h > 0.0:
            if h + hd * horizon > 0.0 and hdd >= 0.0:
                continue  # cannot reach the line
        elif side * d <= 0.0 and h + hd * horizon <= 0.0:
            continue  # behind the line, and does not come out on this side within the window
        s = line_hit(h, hd, hdd, k, horizon, best, near)
        if s == NO_HIT or (found != NO_HIT and s >= found):
            continue
        if not _foot_inside(items, wall, x, y, vx, vy, ax, ay, k, s):
            s = _onto_line(items, wall, s, h, hd, hdd, x, y, vx, vy, ax, ay, k, horizon, best)
        if s != NO_HIT and (found == NO_HIT or s < found):
            found = s
            found_side = side
    return found, found_side


@inner_kernel
def _onto_line(
    items: Floats, wall: int, begin: float, h: float, hd: float, hdd: float, x: float, y: float,
    vx: float, vy: float, ax: float, ay: float, k: float, horizon: float, best: float,
) -> float:  # fmt: skip
    """When a ball that touches the extension of a line from `begin` on comes onto the line itself.

    NO_HIT if it does not. h, hd, hdd: the distance to the line as in `line_hit`. A ball that leaves
    a wall's end may meet the next wall with no angle and no distance, within rounding. It is behind
    that wall by less than rounding when its foot comes between the ends.
    """
    tx = items[wall, surface.TX]
    ty = items[wall, surface.TY]
    near = surface.rounding(x, y)
    foot = tx * (x - items[wall, surface.X]) + ty * (y - items[wall, surface.Y])
    beyond = foot - items[wall, surface.LENGTH]
    along = tx * vx + ty * vy
    pull = tx * ax + ty * ay
    if foot < 0.0:
        s = line_hit(-foot, -along, -pull, k, horizon, best, near)
    else:
        s = line_hit(beyond, along, pull, k, horizon, best, near)
    if s == NO_HIT:
        return NO_HIT
    _, _, psi = short_basis(k, s)
    if s < begin or abs(h + hd * s + hdd * psi) > near:
        return NO_HIT
    return s


@lean_kernel
def _leaves_by(
    first: float, last: float, end: int, tx: float, ty: float, u: float, v: float
) -> bool:
    """Whether `end` is one of a line's ends, and the velocity (u, v) points outwards past it.

    At the joint of a line and its end a ball touches both, within rounding. A ball that leaves the
    end outwards has passed the line, even if rounding puts its foot between the ends. Without this
    rule it would hit the line at once.
    """
    along = u * tx + v * ty
    return (end == int(first) and along < 0.0) or (end == int(last) and along > 0.0)


@inner_kernel
def wall_hit(
    items: Floats, wall: int, origin: int, how: int, radius: float, motion: Motion,
    horizon: float, best: float,
) -> tuple[float, float]:  # fmt: skip
    """When the ball hits the line `wall` between its ends, or NO_HIT; and on which side.

    `origin` is the surface that the ball has just left, unless `how` is FREE. The hit does not
    count if `origin` is an end of this line, and the ball moves outwards both now and then.
    """
    x, y, vx, vy, ax, ay, k = motion
    s, side = _line_hit_between_ends(items, wall, radius, x, y, vx, vy, ax, ay, k, horizon, best)
    if s != NO_HIT and how != FREE:
        first = items[wall, surface.FIRST_END]
        last = items[wall, surface.LAST_END]
        tx = items[wall, surface.TX]
        ty = items[wall, surface.TY]
        if _leaves_by(first, last, origin, tx, ty, vx, vy):
            _, phi, _ = short_basis(k, s)
            if _leaves_by(first, last, origin, tx, ty, vx + ax * phi, vy + ay * phi):
                s = NO_HIT
    return s, side


@lean_kernel
def length_bound(x: float, y: float) -> float:
    """An upper bound of the length of (x, y), at most 1.083 times the length; no square root."""
    x = abs(x)
    y = abs(y)
    return max(x, y) + SQRT2_LESS_1 * min(x, y)


@lean_kernel
def next_impact(
    board: BoardArrays,
    x0: float,
    y0: float,
    vx0: float,
    vy0: float,
    origin: int,
    origin_side: float,
    how: int,
    second_surface: int,
    time_left: float,
) -> tuple[float, int, float]:
    """The end of a flight from a state: its duration, the surface hit (or a code) and the side.

    The ball has left `origin` as `how` says. `second_surface`, unless negative, is another surface
    that it has left at the same time: the ball touches it and does not move into it.

    The flight is searched window by window. In each window the ball moves at most `travel`, so that
    the grid's cell at the middle between the window's ends lists all surfaces that it can touch.

    At equal times the lower surface number counts, and a surface before the bins. This makes the
    result independent of the order in which cells list their surfaces.
    """
    items = board.items
    starts = board.starts
    members = board.members
    centres = board.centres
    travel = board.travel
    fall = board.fall
    k = board.drag
    radius = board.radius
    bins_y = board.bins_y
    ax0 = -k * vx0
    ay0 = board.gravity - k * vy0
    x, y, vx, vy, ax, ay = x0, y0, vx0, vy0, ax0, ay0
    # An upper bound of w = sqrt(2 |a| travel): the mean of 2 travel / fall and fall |a|, whose
    # product is w^2. Equal to w if a is gravity.
    rise = travel / fall + 0.5 * fall * length_bound(ax0, ay0)
    # Under drag an acceleration a moves the ball by at most |a| / k^2 in all. Below this limit that
    # is nothing within rounding: the ball continues straight at its terminal velocity.
    straight = NEGLIGIBLE * radius * k * k
    start = 0.0
    for _ in range(MAX_WINDOWS):
        vv = vx * vx + vy * vy
        va = vx * ax + vy * ay
        aa = ax * ax + ay * ay
        # The ball moves at most |v| s + |a| s^2 / 2 in s seconds. That equals `travel` at
        # s = 2 travel / (|v| + sqrt(|v|^2 + 2 |a| travel)); the upper bounds in the denominator
        # make the horizon at most this s.
        speed = length_bound(vx, vy)
        horizon = 2.0 * travel / (speed + length_bound(speed, rise))
        if k * horizon > SERIES_LIMIT:
            horizon = SERIES_LIMIT / k
        phi, psi = half_chord(k, horizon)
        cell = cell_of(board, x + vx * phi + ax * psi, y + vy * phi + ay * psi)
        if cell < 0:
            return start, FAR_OUT, 0.0
        best = horizon
        item = NOWHERE
        side = 0.0
        skipped = -1
        if how != FREE:
            skipped = origin
            motion = Motion(x, y, vx, vy, ax, ay, k)
            s = _hit_again(items, origin, origin_side, how, motion, horizon)
            if s != NO_HIT:
                best = s
                item = origin
                side = origin_side
            if second_surface >= 0:
                other_side = side_of(items, second_surface, x, y)
                other_how = LIFTED if vv == 0.0 else BOUNCED
                s = _hit_again(items, second_surface, other_side, other_how, motion, horizon)
                if s != NO_HIT and (s < best or item == NOWHERE):
                    best = s
                    item = second_surface
                    side = other_side
        for j in range(starts[cell], starts[cell + 1]):
            other = int(members[j])
            if other == skipped:
                continue
            d2 = centres[other, 2]
            if d2 == 0.0:
                s, other_side = wall_hit(
                    items,
                    other,
                    origin,
                    how,
                    radius,
                    Motion(x, y, vx, vy, ax, ay, k),
                    horizon,
                    best,
                )
            else:
                # Most candidates are excluded here, without a call or a square root.
                qx = x - centres[other, 0]
                qy = y - centres[other, 1]
                f = qx * qx + qy * qy - d2
                b = qx * vx + qy * vy
                qa = qx * ax + qy * ay
                c = vv + qa
                low3 = third_derivative_bound(va, aa, qa, k, horizon)
                if stays_positive(f, b, c + low3 * horizon * SIXTH, horizon):
                    continue
                other_side = 0.0
                if f > 0.0:
                    s = circle_search(
                        Motion(qx, qy, vx, vy, ax, ay, k), d2, horizon, best,
                        0.0, f, 2.0 * b, 2.0 * c, low3,
                    )  # fmt: skip
                elif b < 0.0:
                    s = 0.0
                else:
                    s = circle_hit_again(qx, qy, vx, vy, ax, ay, k, horizon, best)
            if (
                s != NO_HIT
                and other != second_surface
                and (s < best or item == NOWHERE or (s == best and other < item))
            ):
                best = s
                item = other
                side = other_side
        if y + travel >= bins_y:  # if not, the ball cannot reach the bins in this window
            s = line_hit(bins_y - y, -vy, -ay, k, horizon, best, 0.0)
            if s != NO_HIT and (s < best or item == NOWHERE):
                best = s
                item = BINS
        if item != NOWHERE:
            return start + best, item, side
        start = start + horizon
        if start > time_left:
            return start, OUT_OF_TIME, 0.0
        how = FREE
        second_surface = -1
        k = board.drag
        decay, phi, psi = basis(k, start)
        x = x0 + vx0 * start + ax0 * psi
        y = y0 + vy0 * start + ay0 * psi
        vx = vx0 + ax0 * phi
        vy = vy0 + ay0 * phi
        ax = ax0 * decay
        ay = ay0 * decay
        if k > 0.0 and length_bound(ax, ay) <= straight:
            vx += ax / k
            vy += ay / k
            ax, ay, k = 0.0, 0.0, 0.0
            if vx != 0.0 or vy != 0.0:
                rise = 0.0
    return start, OUT_OF_WINDOWS, 0.0
