"""Flight of the exact solver: from impact to impact, until a ball lands or stays on a surface.

These kernels take arrays and scalars one by one instead of a Layout: in the innermost loops the
reference counting of a tuple of arrays would cost more than the physics.
"""

import numpy as np
import numpy.typing as npt

from engine.constants import KIND_PEG, KIND_WALL
from engine.exact.event_log import EVENTS, IMPACTS, IN_FLIGHT, SEGMENTS, write_event, write_segment
from engine.jit.decorator import lean_kernel
from engine.physics.ball import OMEGA, PX, PY, THETA, VX, VY, T
from engine.physics.flight import SERIES_LIMIT, basis, half_chord, short_basis
from engine.physics.impulse import bounce
from engine.physics.layout import (
    DISTANCE,
    DISTANCE2,
    FIRST_END,
    INVERSE,
    LAST_END,
    LENGTH,
    NX,
    NY,
    TX,
    TY,
    X,
    Y,
    cell_at,
)
from engine.physics.time_of_impact import (
    NO_HIT,
    SIXTH,
    circle_hit,
    circle_hit_after_leaving,
    circle_hit_again,
    circle_search,
    line_hit,
    line_hit_again,
    stays_positive,
    third_derivative_bound,
)

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Indices = npt.NDArray[np.uint32]

DYING_BOUNCE = 1.0e-8
"""m/s. A bounce that leaves a surface slower than this, and is pressed back, has died: the ball
stays on the surface. What is cut off of the infinite sequence moves the ball by about 1e-19 m where
friction holds it and 1e-12 m where it slips; a larger value would be seen in the digest only."""

MAX_WINDOWS = 1_000_000
"""Search windows in one flight, each at least the layout's travel long or 0.25 / k."""

SQRT2_LESS_1 = 0.41421356237309515  # rounded up

# What a flight ends at, besides the number of a surface.
BINS = -1
NOWHERE = -2

# How the surface that a flight starts from was left.
FREE = 0
BOUNCED = 1
ROLLED_OFF = 2

# Why `fly` returned.
AT_BINS = 0
ON_SURFACE = 1
OUT_OF_EVENTS = 2
OUT_OF_TIME = 3
OUT_OF_BOARD = 4


@lean_kernel
def held_line_hit(
    items: Array, held: int, side: float, x: float, y: float, vx: float, vy: float,
    ax: float, ay: float, k: float, horizon: float,
) -> float:  # fmt: skip
    """When a ball that has just left `side` of the line `held` hits it again."""
    nx = items[held, NX]
    ny = items[held, NY]
    hd = side * (nx * vx + ny * vy)
    hdd = side * (nx * ax + ny * ay)
    s = line_hit_again(hd, hdd, k, horizon, horizon)
    if s != NO_HIT:
        dx = x - items[held, X]
        dy = y - items[held, Y]
        if not _foot_inside(dx, dy, vx, vy, ax, ay, ny, -nx, items[held, LENGTH], k, s):
            s = NO_HIT
    return s


@lean_kernel
def _foot_inside(
    dx: float,
    dy: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    tx: float,
    ty: float,
    length: float,
    k: float,
    s: float,
) -> bool:
    """Whether the foot of a ball on a line lies between its ends after a flight of s.

    (dx, dy) is where the flight begins, seen from the line's first end.
    """
    _, _, psi = short_basis(k, s)
    foot = (dx + vx * s + ax * psi) * tx + (dy + vy * s + ay * psi) * ty
    return 0.0 <= foot <= length


@lean_kernel
def _line_hit_between_ends(
    lx: float,
    ly: float,
    length: float,
    nx: float,
    ny: float,
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
    dx = x - lx
    dy = y - ly
    d = nx * dx + ny * dy
    dv = nx * vx + ny * vy
    da = nx * ax + ny * ay
    found = NO_HIT
    found_side = 0.0
    for way in range(2):
        side = 1.0 - 2.0 * way
        h = side * d - radius
        hd = side * dv
        hdd = side * da
        if h > 0.0:
            if h + hd * horizon > 0.0 and hdd >= 0.0:
                continue  # out of reach
        elif side * d <= 0.0 and h + hd * horizon <= 0.0:
            continue  # behind the line, and not out on this side within the window
        s = line_hit(h, hd, hdd, k, horizon, best)
        if s == NO_HIT or (found != NO_HIT and s >= found):
            continue
        if _foot_inside(dx, dy, vx, vy, ax, ay, ny, -nx, length, k, s):
            found = s
            found_side = side
    return found, found_side


@lean_kernel
def _leaves_by(
    first: float, last: float, end: int, tx: float, ty: float, u: float, v: float
) -> bool:
    """Whether `end` is the first or last end of a line, and (u, v) leads out past it.

    At the joint of a line and its end a ball touches both, within rounding. From there on it is
    past the line, whatever side of the joint rounding puts it on, until it moves back.
    """
    along = u * tx + v * ty
    return (end == int(first) and along < 0.0) or (end == int(last) and along > 0.0)


@lean_kernel
def wall_hit(
    items: Array, wall: int, held: int, how: int, radius: float, x: float, y: float,
    vx: float, vy: float, ax: float, ay: float, k: float, horizon: float, best: float,
) -> tuple[float, float]:  # fmt: skip
    """When the ball hits the line `wall` between its ends, or NO_HIT; and on which side.

    `held` is the surface that it has just left, unless `how` is FREE.
    """
    s, side = _line_hit_between_ends(
        items[wall, X], items[wall, Y], items[wall, LENGTH], items[wall, NX], items[wall, NY],
        radius, x, y, vx, vy, ax, ay, k, horizon, best,
    )  # fmt: skip
    if s != NO_HIT and how != FREE:
        first = items[wall, FIRST_END]
        last = items[wall, LAST_END]
        tx = items[wall, TX]
        ty = items[wall, TY]
        if _leaves_by(first, last, held, tx, ty, vx, vy):
            _, phi, _ = short_basis(k, s)
            if _leaves_by(first, last, held, tx, ty, vx + ax * phi, vy + ay * phi):
                s = NO_HIT
    return s, side


@lean_kernel
def length_bound(x: float, y: float) -> float:
    """At least the length of (x, y), and at most 1.083 of it: no square root is waited for."""
    x = abs(x)
    y = abs(y)
    return max(x, y) + SQRT2_LESS_1 * min(x, y)


@lean_kernel
def next_hit(
    items: Array,
    left: float,
    top: float,
    cells_per_metre: float,
    columns: int,
    rows: int,
    starts: Indices,
    members: Indices,
    centres: Array,
    travel: float,
    fall: float,
    gravity: float,
    k: float,
    radius: float,
    bins_y: float,
    x0: float,
    y0: float,
    vx0: float,
    vy0: float,
    held: int,
    held_side: float,
    how: int,
    time_left: float,
) -> tuple[float, int, float]:
    """Flight from a state to whatever it meets first: duration, surface (or code) and side.

    The arguments up to bins_y are those of the layout. The flight is searched window by window; in
    each the ball moves at most `travel`, so that the cell midway between its ends lists all it can
    touch. At equal times the lower surface number counts, and a surface before the bins.
    """
    ax0 = -k * vx0
    ay0 = gravity - k * vy0
    x, y, vx, vy, ax, ay = x0, y0, vx0, vy0, ax0, ay0
    # At least sqrt(2 |a| travel), the mean of whose factors this is; equal where a is gravity.
    rise = travel / fall + 0.5 * fall * length_bound(ax0, ay0)
    start = 0.0
    for _ in range(MAX_WINDOWS):
        vv = vx * vx + vy * vy
        va = vx * ax + vy * ay
        aa = ax * ax + ay * ay
        # In s the ball moves |v| s + |a| s^2 / 2 at most, which is no more than the travel here.
        speed = length_bound(vx, vy)
        horizon = 2.0 * travel / (speed + length_bound(speed, rise))
        if k * horizon > SERIES_LIMIT:
            horizon = SERIES_LIMIT / k
        phi, psi = half_chord(k, horizon)
        cell = cell_at(
            x + vx * phi + ax * psi, y + vy * phi + ay * psi,
            left, top, cells_per_metre, columns, rows,
        )  # fmt: skip
        if cell < 0:
            return start, NOWHERE, 0.0
        best = horizon
        item = NOWHERE
        side = 0.0
        skipped = -1
        if how != FREE:
            skipped = held
            d2 = items[held, DISTANCE2]
            qx = x - items[held, X]
            qy = y - items[held, Y]
            if items[held, DISTANCE] == 0.0:
                s = held_line_hit(items, held, held_side, x, y, vx, vy, ax, ay, k, horizon)
            elif how == BOUNCED:
                s = circle_hit_again(qx, qy, vx, vy, ax, ay, k, horizon, horizon)
            else:
                s = circle_hit_after_leaving(qx, qy, vx, vy, ax, ay, k, d2, horizon, horizon)
            if s != NO_HIT:
                best = s
                item = held
                side = held_side
        for j in range(starts[cell], starts[cell + 1]):
            other = int(members[j])
            if other == skipped:
                continue
            d2 = centres[other, 2]
            if d2 == 0.0:
                s, other_side = wall_hit(
                    items, other, held, how, radius, x, y, vx, vy, ax, ay, k, horizon, best
                )
            else:
                # Most candidates are turned down here, with neither a call nor a square root.
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
                        qx, qy, vx, vy, ax, ay, k, d2, horizon, best,
                        0.0, f, 2.0 * b, 2.0 * c, low3,
                    )  # fmt: skip
                else:
                    s = circle_hit(qx, qy, vx, vy, ax, ay, k, d2, horizon, best)
            if s != NO_HIT and (s < best or item == NOWHERE or (s == best and other < item)):
                best = s
                item = other
                side = other_side
        if y + travel >= bins_y:  # else no window from here comes as far
            s = line_hit(bins_y - y, -vy, -ay, k, horizon, best)
            if s != NO_HIT and (s < best or item == NOWHERE):
                best = s
                item = BINS
        if item != NOWHERE:
            return start + best, item, side
        start = start + horizon
        if start > time_left:
            return start, NOWHERE, 0.0
        how = FREE
        decay, phi, psi = basis(k, start)
        x = x0 + vx0 * start + ax0 * psi
        y = y0 + vy0 * start + ay0 * psi
        vx = vx0 + ax0 * phi
        vy = vy0 + ay0 * phi
        ax = ax0 * decay
        ay = ay0 * decay
    return start, NOWHERE, 0.0


@lean_kernel
def rebound(
    items: Array, item: int, side: float, x: float, y: float, vx: float, vy: float, omega: float,
    radius: float, restitution: float, friction: float,
) -> tuple[float, float, float, float, float, float, float, bool]:  # fmt: skip
    """A ball at (x, y) hits a surface: its centre put on it, velocity and spin after, the normal,
    and whether friction stopped the slip."""
    dx = x - items[item, X]
    dy = y - items[item, Y]
    distance = items[item, DISTANCE]
    if distance > 0.0:
        # The ball is at D within rounding: one step of Newton's for 1 / sqrt makes it exact.
        nx = dx * items[item, INVERSE]
        ny = dy * items[item, INVERSE]
        unit = 1.5 - 0.5 * (nx * nx + ny * ny)
        nx = nx * unit
        ny = ny * unit
        x = items[item, X] + distance * nx
        y = items[item, Y] + distance * ny
    else:
        nx = side * items[item, NX]
        ny = side * items[item, NY]
        gap = radius - (dx * nx + dy * ny)
        x = x + gap * nx
        y = y + gap * ny
    grips = False
    if vx * nx + vy * ny < 0.0:
        vx, vy, omega, grips = bounce(vx, vy, omega, nx, ny, radius, restitution, friction)
    return x, y, vx, vy, omega, nx, ny, grips


@lean_kernel
def stays_on(
    items: Array, item: int, vx: float, vy: float, nx: float, ny: float, gravity: float
) -> bool:
    """Whether a bounce off a surface has died, and gravity presses the ball back onto it."""
    stays = False
    if vx * nx + vy * ny <= DYING_BOUNCE:
        u = vy * nx - vx * ny
        distance = items[item, DISTANCE]
        bend = 1.0 / distance if distance > 0.0 else 0.0
        stays = -gravity * ny - bend * u * u > 0.0
    return stays


@lean_kernel
def fly(
    items: Array,
    left: float,
    top: float,
    cells_per_metre: float,
    columns: int,
    rows: int,
    starts: Indices,
    members: Indices,
    centres: Array,
    travel: float,
    fall: float,
    gravity: float,
    k: float,
    radius: float,
    bins_y: float,
    peg_count: int,
    peg_restitution: float,
    peg_friction: float,
    wall_restitution: float,
    wall_friction: float,
    state: Array,
    item: int,
    side: float,
    how: int,
    touching: bool,
    event_limit: int,
    max_time: float,
    events: Array,
    marks: npt.NDArray[np.int32],
    segments: Array,
    counts: Ints,
) -> tuple[int, int, float, bool]:
    """Flights and bounces from `state`, changed in place, until something else than a bounce.

    `item` and `side` name the surface that was left, and `how`; or, if `touching`, the one that is
    being hit. Returns the cause, the surface and side the ball is on, and whether friction stopped
    its slip there. The arguments up to wall_friction are those of the layout, the last four are the
    log.
    """
    t = state[T]
    x = state[PX]
    y = state[PY]
    vx = state[VX]
    vy = state[VY]
    theta = state[THETA]
    omega = state[OMEGA]
    grips = False
    cause = ON_SURFACE
    while True:
        if not touching:
            if counts[EVENTS] >= event_limit:
                cause = OUT_OF_EVENTS
                break
            row = counts[SEGMENTS]
            counts[SEGMENTS] = row + 1
            if row < len(segments):
                write_segment(segments, row, t, x, y, vx, vy, theta, omega, IN_FLIGHT)
            s, item, side = next_hit(
                items, left, top, cells_per_metre, columns, rows, starts, members, centres,
                travel, fall, gravity, k, radius, bins_y,
                x, y, vx, vy, item, side, how, max_time - t,
            )  # fmt: skip
            if item == NOWHERE:
                cause = OUT_OF_TIME if t + s > max_time else OUT_OF_BOARD
                break
            ax = -k * vx
            ay = gravity - k * vy
            _, phi, psi = basis(k, s)
            t += s
            x = x + vx * s + ax * psi
            y = y + vy * s + ay * psi
            vx = vx + ax * phi
            vy = vy + ay * phi
            theta = theta + omega * s
            if item == BINS:
                cause = AT_BINS
                break
        touching = False
        how = BOUNCED
        is_peg = item < peg_count
        restitution = peg_restitution if is_peg else wall_restitution
        friction = peg_friction if is_peg else wall_friction
        x, y, vx, vy, omega, nx, ny, grips = rebound(
            items, item, side, x, y, vx, vy, omega, radius, restitution, friction
        )
        row = counts[EVENTS]
        counts[EVENTS] = row + 1
        counts[IMPACTS] += 1
        if row < len(events):
            kind = KIND_PEG if is_peg else KIND_WALL
            index = item if is_peg else (item - peg_count) // 3
            write_event(events, marks, row, t, x, y, vx, vy, omega, kind, index)
        if stays_on(items, item, vx, vy, nx, ny, gravity):
            u = vy * nx - vx * ny
            vx = -u * ny
            vy = u * nx
            break
    state[T] = t
    state[PX] = x
    state[PY] = y
    state[VX] = vx
    state[VY] = vy
    state[THETA] = theta
    state[OMEGA] = omega
    return cause, item, side, grips
