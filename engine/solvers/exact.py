"""The exact solver: closed-form flight, the next impact found to the last bits, impulse, repeat."""

from math import sqrt

import numpy as np
import numpy.typing as npt

from engine.constants import (
    KIND_CONTACT_BEGIN,
    KIND_CONTACT_END,
)
from engine.kernels.contact import new_series
from engine.kernels.flight import SERIES_LIMIT, advance_flight, basis
from engine.kernels.impact_time import (
    NO_HIT,
    circle_hit,
    circle_hit_after_leaving,
    circle_hit_again,
    line_hit,
    line_hit_again,
)
from engine.kernels.impulse import bounce
from engine.kernels.jit import kernel
from engine.kernels.layout import (
    DISTANCE,
    DISTANCE2,
    FIRST_END,
    LAST_END,
    LENGTH,
    NX,
    NY,
    TX,
    TY,
    Layout,
    X,
    Y,
    bucket_of,
)
from engine.kernels.log import (
    EVENTS,
    IMPACTS,
    IN_FLIGHT,
    OMEGA,
    PX,
    PY,
    VX,
    VY,
    Log,
    T,
    note_event,
    note_segment,
)
from engine.kernels.series import Series
from engine.kernels.surface import (
    curvature,
    friction_of,
    is_wedged,
    restitution_of,
    touch,
)
from engine.solvers import riding
from engine.solvers.landing import land, note_impact
from engine.solvers.outcome import (
    BALANCED,
    ESCAPED,
    EVENT_LIMIT,
    LANDED,
    TIME_LIMIT,
    WEDGED,
)

State = npt.NDArray[np.float64]

DYING_BOUNCE = 1.0e-8
"""m/s. A bounce that leaves a surface slower than this, and is pressed back, has died: the ball
stays on the surface. What is cut off of the infinite sequence moves the ball by about 1e-19 m where
friction holds it and 1e-12 m where it slips; a larger value would be seen in the digest only."""

MAX_WINDOWS = 1_000_000
"""Search windows in one flight, each at least the layout's travel long or 0.25 / k."""

# What a flight ends at, besides the number of a surface.
_BINS = -1
_NOWHERE = -2

# How the surface that a flight starts from was left.
_FREE = 0
_BOUNCED = 1
_ROLLED_OFF = 2


@kernel
def _held_hit(
    board: Layout,
    item: int,
    side: float,
    how: int,
    x: float,
    y: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    horizon: float,
) -> float:
    """When the surface that the ball has just left is hit again."""
    surface = board.items[item]
    if surface[DISTANCE] > 0.0:
        qx = x - surface[X]
        qy = y - surface[Y]
        if how == _ROLLED_OFF:
            return circle_hit_after_leaving(
                qx, qy, vx, vy, ax, ay, board.drag, surface[DISTANCE2], horizon, horizon
            )
        return circle_hit_again(qx, qy, vx, vy, ax, ay, board.drag, horizon, horizon)
    hd = side * (surface[NX] * vx + surface[NY] * vy)
    hdd = side * (surface[NX] * ax + surface[NY] * ay)
    s = line_hit_again(hd, hdd, board.drag, horizon, horizon)
    if s != NO_HIT and not _foot_inside(board, item, x, y, vx, vy, ax, ay, s):
        return NO_HIT
    return s


@kernel
def _foot_inside(
    board: Layout,
    item: int,
    x: float,
    y: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    s: float,
) -> bool:
    """Whether the foot of the ball on a line lies between its ends after a flight of s."""
    line = board.items[item]
    _, _, psi = basis(board.drag, s)
    foot = (x + vx * s + ax * psi - line[X]) * line[TX]
    foot += (y + vy * s + ay * psi - line[Y]) * line[TY]
    return bool(0.0 <= foot <= line[LENGTH])


@kernel
def _leaves_by(board: Layout, item: int, end: int, vx: float, vy: float) -> bool:
    """Whether `end` is an end of the line `item`, and a ball at this velocity moves out past it.

    At the joint of a line and its end the ball touches both, within rounding. From there on it is
    past the line, whatever side of the joint rounding puts it on, until it moves back.
    """
    line = board.items[item]
    along = vx * line[TX] + vy * line[TY]
    if end == int(line[FIRST_END]):
        return bool(along < 0.0)
    return bool(end == int(line[LAST_END]) and along > 0.0)


@kernel
def _wall_hit(
    board: Layout,
    item: int,
    x: float,
    y: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    horizon: float,
    best: float,
) -> tuple[float, float]:
    """When the ball hits the line `item` between its ends, or NO_HIT; and on which side."""
    line = board.items[item]
    d = line[NX] * (x - line[X]) + line[NY] * (y - line[Y])
    dv = line[NX] * vx + line[NY] * vy
    da = line[NX] * ax + line[NY] * ay
    found = NO_HIT
    found_side = 0.0
    for way in range(2):
        side = 1.0 - 2.0 * way
        h = side * d - board.radius
        hd = side * dv
        if side * d <= 0.0 and h + hd * horizon <= 0.0:
            continue  # behind the line, and not out on this side within the window
        s = line_hit(h, hd, side * da, board.drag, horizon, best)
        if s == NO_HIT or (found != NO_HIT and s >= found):
            continue
        if _foot_inside(board, item, x, y, vx, vy, ax, ay, s):
            found = s
            found_side = side
    return found, found_side


@kernel
def _window_hit(
    board: Layout,
    bucket: int,
    held: int,
    held_side: float,
    how: int,
    x: float,
    y: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    horizon: float,
) -> tuple[float, int, float]:
    """First thing met within the horizon: time, surface (or _BINS, _NOWHERE) and side.

    At equal times the lower surface number counts, and a surface before the bins.
    """
    best = horizon
    item = _NOWHERE
    side = 0.0
    if how != _FREE:
        s = _held_hit(board, held, held_side, how, x, y, vx, vy, ax, ay, horizon)
        if s != NO_HIT:
            best = s
            item = held
            side = held_side
    for k in range(board.starts[bucket], board.starts[bucket + 1]):
        other = board.members[k]
        if how != _FREE and other == held:
            continue
        surface = board.items[other]
        other_side = 0.0
        if surface[DISTANCE] > 0.0:
            s = circle_hit(
                x - surface[X],
                y - surface[Y],
                vx,
                vy,
                ax,
                ay,
                board.drag,
                surface[DISTANCE2],
                horizon,
                best,
            )
        else:
            s, other_side = _wall_hit(board, other, x, y, vx, vy, ax, ay, horizon, best)
            if s != NO_HIT and how != _FREE and _leaves_by(board, other, held, vx, vy):
                _, phi, _ = basis(board.drag, s)
                if _leaves_by(board, other, held, vx + ax * phi, vy + ay * phi):
                    s = NO_HIT
        if s != NO_HIT and (s < best or item == _NOWHERE or (s == best and other < item)):
            best = s
            item = other
            side = other_side
    s = line_hit(board.bins_y - y, -vy, -ay, board.drag, horizon, best)
    if s != NO_HIT and (s < best or item == _NOWHERE):
        best = s
        item = _BINS
    return best, item, side


@kernel
def next_hit(
    board: Layout, state: State, held: int, held_side: float, how: int, max_time: float
) -> tuple[float, int, float]:
    """Flight from `state` to whatever it meets first: duration, surface (or code) and side.

    The flight is searched window by window; in each the ball moves at most the layout's travel, so
    that the bucket of the window's start lists all it can touch.
    """
    k = board.drag
    x0 = state[PX]
    y0 = state[PY]
    vx0 = state[VX]
    vy0 = state[VY]
    ax0 = -k * vx0
    ay0 = board.gravity - k * vy0
    x, y, vx, vy, ax, ay = x0, y0, vx0, vy0, ax0, ay0
    start = 0.0
    for _ in range(MAX_WINDOWS):
        bucket = bucket_of(board, x, y)
        if bucket < 0:
            return start, _NOWHERE, 0.0
        vv = vx * vx + vy * vy
        a = sqrt(ax * ax + ay * ay)
        # |v| h + |a| h^2 / 2 = travel
        horizon = 2.0 * board.travel / (sqrt(vv) + sqrt(vv + 2.0 * a * board.travel))
        if k * horizon > SERIES_LIMIT:
            horizon = SERIES_LIMIT / k
        s, item, side = _window_hit(
            board, bucket, held, held_side, how, x, y, vx, vy, ax, ay, horizon
        )
        if item != _NOWHERE:
            return start + s, item, side
        start = start + horizon
        if state[T] + start > max_time:
            return start, _NOWHERE, 0.0
        how = _FREE
        decay, phi, psi = basis(k, start)
        x = x0 + vx0 * start + ax0 * psi
        y = y0 + vy0 * start + ay0 * psi
        vx = vx0 + ax0 * phi
        vy = vy0 + ay0 * phi
        ax = ax0 * decay
        ay = ay0 * decay
    return start, _NOWHERE, 0.0


@kernel
def _impact(
    board: Layout, state: State, item: int, side: float, log: Log
) -> tuple[float, float, float, float, bool]:
    """Bounce the state off `item`: the normal, the speed left along it before and after, grip."""
    nx, ny, state[PX], state[PY] = touch(board, item, side, state[PX], state[PY])
    before = state[VX] * nx + state[VY] * ny
    grips = False
    if before < 0.0:
        state[VX], state[VY], state[OMEGA], grips = bounce(
            state[VX],
            state[VY],
            state[OMEGA],
            nx,
            ny,
            board.radius,
            restitution_of(board, item),
            friction_of(board, item),
        )
    note_impact(board, state, item, log)
    return nx, ny, before, state[VX] * nx + state[VY] * ny, grips


@kernel
def _stays(board: Layout, state: State, item: int, nx: float, ny: float, speed: float) -> bool:
    """Whether a ball that leaves `item` at this normal speed has stopped bouncing on it."""
    if speed > DYING_BOUNCE:
        return False
    u = state[VY] * nx - state[VX] * ny
    return bool(-board.gravity * ny - curvature(board, item) * u * u > 0.0)


@kernel
def trace(
    board: Layout, state: State, max_events: int, max_time: float, log: Log, series: Series
) -> tuple[int, int]:
    """Follow a ball from `state` (T, PX, … OMEGA; changed in place) until its drop ends.

    Returns the outcome and the bin, -1 if it did not land.
    """
    held = -1
    held_side = 0.0
    how = _FREE
    ridden = -1  # the surface that the ball rode until it hit another, else -1
    ridden_nx = 0.0
    ridden_ny = 0.0
    while True:
        if ridden < 0:
            if log.counts[EVENTS] >= max_events:
                return EVENT_LIMIT, -1
            note_segment(log, state, IN_FLIGHT, 0.0, 0.0, 0.0)
            s, held, held_side = next_hit(board, state, held, held_side, how, max_time)
            if held == _NOWHERE:
                return TIME_LIMIT if state[T] + s > max_time else ESCAPED, -1
            advance_flight(state, board.gravity, board.drag, s)
            if held == _BINS:
                return LANDED, land(board, state, log)
        nx, ny, before, after, grips = _impact(board, state, held, held_side, log)
        if ridden >= 0:
            slow = before >= -DYING_BOUNCE
            if slow and is_wedged(board, ridden_nx, ridden_ny, nx, ny):
                return WEDGED, -1
            ridden = -1
        how = _BOUNCED
        if not _stays(board, state, held, nx, ny, after):
            continue
        u = state[VY] * nx - state[VX] * ny
        state[VX] = -u * ny
        state[VY] = u * nx
        note_event(log, state, KIND_CONTACT_BEGIN, riding.surface_index(board, held))
        cause, held, held_side, other, other_side = riding.ride(
            board, series, state, held, held_side, grips, max_time, max_events, log
        )
        if cause == riding.LANDED:
            return LANDED, land(board, state, log)
        if cause == riding.HIT:
            ridden = held
            ridden_nx, ridden_ny, _, _ = touch(board, held, held_side, state[PX], state[PY])
            held = other
            held_side = other_side
            continue
        if cause == riding.LEFT:
            how = _ROLLED_OFF
        elif cause == riding.AT_REST:
            return BALANCED, -1
        elif cause == riding.OUT_OF_TIME:
            return TIME_LIMIT, -1
        elif cause == riding.OUT_OF_EVENTS:
            return EVENT_LIMIT, -1
        elif cause == riding.OUT_OF_BOARD:
            return ESCAPED, -1
        note_event(log, state, KIND_CONTACT_END, riding.surface_index(board, held))


@kernel
def trace_many(
    board: Layout,
    xs: npt.NDArray[np.float64],
    y: float,
    max_events: int,
    max_time: float,
    log: Log,
    bins: npt.NDArray[np.int32],
    durations: npt.NDArray[np.float64],
    x_ends: npt.NDArray[np.float64],
    impacts: npt.NDArray[np.int32],
    outcomes: npt.NDArray[np.int8],
) -> None:
    """Drop a ball at rest from each (xs[i], y) and write down its outcome; all arrays shape (n,).

    `log` has room for nothing: it only counts.
    """
    series = new_series()
    state = np.zeros(7)
    for i in range(xs.shape[0]):
        state[:] = 0.0
        state[PX] = xs[i]
        state[PY] = y
        log.counts[:] = 0
        outcome, where = trace(board, state, max_events, max_time, log, series)
        bins[i] = where
        outcomes[i] = outcome
        durations[i] = state[T]
        x_ends[i] = state[PX]
        impacts[i] = log.counts[IMPACTS]
