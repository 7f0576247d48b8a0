"""What ends a stretch of motion on a surface: each cause is the first zero of a polynomial."""

from engine.jit.decorator import inner_kernel
from engine.physics.contact import FORCE, NORMAL_X, NORMAL_Y, ORDER, PATH, SCRATCH, SPEED, SPIN
from engine.physics.layout import (
    DISTANCE,
    DISTANCE2,
    FIRST_LINE,
    LENGTH,
    LINE_SLOTS,
    NX,
    NY,
    TX,
    TY,
    Layout,
    X,
    Y,
)
from engine.physics.series import Series, first_zero, value
from engine.physics.time_of_impact import NO_HIT


@inner_kernel
def leaving_time(series: Series, horizon: float) -> float:
    """When the normal force vanishes, or NO_HIT."""
    return first_zero(series[FORCE], 0, horizon)


@inner_kernel
def slip_end_time(series: Series, slip_sign: float, skip: int, radius: float, h: float) -> float:
    """When a sliding ball's slip, u - omega R of sign slip_sign, reaches zero, or NO_HIT."""
    f = series[SCRATCH]
    for i in range(ORDER + 1):
        f[i] = slip_sign * (series[SPEED, i] - radius * series[SPIN, i])
    return first_zero(f, skip, h)


@inner_kernel
def grip_end_time(
    series: Series, gravity: float, drag: float, friction: float, horizon: float
) -> tuple[float, float]:
    """When a rolling ball needs more friction than mu N, and the sign of its slip then.

    Rolling takes |g.t - k u| / 3 of friction.
    """
    f = series[SCRATCH]
    best = NO_HIT
    sign = 0.0
    for way in range(2):
        drive_sign = 1.0 - 2.0 * way
        for i in range(ORDER + 1):
            drive = gravity * series[NORMAL_X, i] - drag * series[SPEED, i]
            f[i] = 3.0 * friction * series[FORCE, i] - drive_sign * drive
        s = first_zero(f, 0, horizon)
        if s != NO_HIT and (best == NO_HIT or s < best):
            best = s
            sign = drive_sign
    return best, sign


@inner_kernel
def landing_time(board: Layout, series: Series, item: int, y: float, horizon: float) -> float:
    """When the centre, at height y now, crosses the bins' line on `item`, or NO_HIT."""
    f = series[SCRATCH]
    distance = board.items[item, DISTANCE]
    row = NORMAL_Y if distance > 0.0 else PATH
    rate = distance if distance > 0.0 else board.items[item, TY]
    _affine(f, series, row, -rate, 0.0)
    f[0] = board.bins_y - y
    return first_zero(f, 0, horizon)


@inner_kernel
def _affine(f: Series, series: Series, row: int, rate: float, start: float) -> None:
    """f = start + rate * (the row less its first term)."""
    f[0] = start
    for i in range(1, ORDER + 1):
        f[i] = rate * series[row, i]


@inner_kernel
def _first_touch(f: Series, horizon: float) -> float:
    """First zero of a distance function, at which a touching ball counts as touching again.

    f[0] <= 0 is a touch within rounding: 0 if the ball moves on inwards (or rests against what
    pulls it inwards), otherwise the touch at 0 is divided out.
    """
    if f[0] > 0.0:
        return first_zero(f, 0, horizon)
    if f[1] < 0.0:
        return 0.0
    if f[1] > 0.0:
        return first_zero(f, 1, horizon)
    return 0.0 if f[2] < 0.0 else NO_HIT


@inner_kernel
def touch_time(
    board: Layout, series: Series, item: int, x: float, y: float, other: int, h: float
) -> tuple[float, float]:
    """When a ball on `item`, now at (x, y), touches `other`, or NO_HIT; and the side of a line."""
    f = series[SCRATCH]
    items = board.items
    on_circle = items[item, DISTANCE] > 0.0
    dx = x - items[other, X]
    dy = y - items[other, Y]
    if items[other, DISTANCE] > 0.0:
        if on_circle:
            px = items[item, X] - items[other, X]
            py = items[item, Y] - items[other, Y]
            twice = 2.0 * items[item, DISTANCE]
            for i in range(1, ORDER + 1):
                f[i] = twice * (px * series[NORMAL_X, i] + py * series[NORMAL_Y, i])
        else:
            _circle_seen_from_line(f, series, dx, dy)
        f[0] = dx * dx + dy * dy - items[other, DISTANCE2]
        return _first_touch(f, h), 0.0
    nx = items[other, NX]
    ny = items[other, NY]
    d = nx * dx + ny * dy
    side = 1.0 if d > 0.0 else -1.0
    if on_circle:
        reach = side * items[item, DISTANCE]
        for i in range(1, ORDER + 1):
            f[i] = reach * (nx * series[NORMAL_X, i] + ny * series[NORMAL_Y, i])
    else:
        tx = -series[NORMAL_Y, 0]
        ty = series[NORMAL_X, 0]
        _affine(f, series, PATH, side * (nx * tx + ny * ty), 0.0)
    f[0] = side * d - board.radius
    s = _first_touch(f, h)
    if s == NO_HIT or not _foot_inside(board, series, item, x, y, other, s):
        return NO_HIT, side
    return s, side


@inner_kernel
def _circle_seen_from_line(f: Series, series: Series, dx: float, dy: float) -> None:
    """|d + t l(s)|^2 less its first term, for a ball that moves by l(s) along t."""
    tx = -series[NORMAL_Y, 0]
    ty = series[NORMAL_X, 0]
    path = series[PATH]
    along = 2.0 * (dx * tx + dy * ty)
    for i in range(1, ORDER + 1):
        square = 0.0
        for j in range(1, i):
            square += path[j] * path[i - j]
        f[i] = along * path[i] + square


@inner_kernel
def position(
    board: Layout, series: Series, item: int, x: float, y: float, s: float
) -> tuple[float, float]:
    """Centre at time s of a ball on `item` that is at (x, y) at time 0, in m."""
    distance = board.items[item, DISTANCE]
    if distance > 0.0:
        px = board.items[item, X] + distance * value(series[NORMAL_X], s)
        py = board.items[item, Y] + distance * value(series[NORMAL_Y], s)
        return px, py
    path = value(series[PATH], s)
    return x - series[NORMAL_Y, 0] * path, y + series[NORMAL_X, 0] * path


@inner_kernel
def _foot_inside(
    board: Layout, series: Series, item: int, x: float, y: float, other: int, s: float
) -> bool:
    """Whether at time s the foot of the ball on the line `other` lies between its ends."""
    px, py = position(board, series, item, x, y, s)
    line = board.items[other]
    foot = (px - line[X]) * line[TX] + (py - line[Y]) * line[TY]
    return bool(0.0 <= foot <= line[LENGTH])


@inner_kernel
def line_end_time(
    board: Layout, series: Series, item: int, x: float, y: float, horizon: float
) -> tuple[float, int]:
    """When a ball on a line passes one of its ends, or NO_HIT; and which end (0 or 1)."""
    line = board.items[item]
    foot = (x - line[X]) * line[TX] + (y - line[Y]) * line[TY]
    along = -series[NORMAL_Y, 0] * line[TX] + series[NORMAL_X, 0] * line[TY]
    f = series[SCRATCH]
    best = NO_HIT
    end = 0
    for way in range(2):
        sign = 1.0 - 2.0 * way
        _affine(f, series, PATH, sign * along, foot if way == 0 else line[LENGTH] - foot)
        s = _first_touch(f, horizon)
        if s != NO_HIT and (best == NO_HIT or s < best):
            best = s
            end = way
    return best, end


@inner_kernel
def line_entry_time(board: Layout, series: Series, item: int, horizon: float) -> tuple[float, int]:
    """When a ball on a wall's end rolls onto one of the lines that end there, or NO_HIT."""
    f = series[SCRATCH]
    best = NO_HIT
    entered = -1
    for slot in range(LINE_SLOTS):
        line = int(board.items[item, FIRST_LINE + slot])
        if line < 0:
            continue
        tx = board.items[line, TX]
        ty = board.items[line, TY]
        first = board.items[line, X] == board.items[item, X] and (
            board.items[line, Y] == board.items[item, Y]
        )
        outwards = -1.0 if first else 1.0
        for i in range(ORDER + 1):
            f[i] = outwards * (tx * series[NORMAL_X, i] + ty * series[NORMAL_Y, i])
        s = _first_touch(f, horizon)
        if s != NO_HIT and (best == NO_HIT or s < best):
            best = s
            entered = line
    return best, entered
