"""Finds what ends a stretch of rolling or sliding: each cause is the first zero of a polynomial.

All times are in s from the start of the stretch; NO_HIT means not within the horizon.
"""

from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.free_flight import is_near
from plinko.engine.jit.decorator import inner_kernel
from plinko.engine.physics import contact, surface
from plinko.engine.physics.series import Series, first_zero, value
from plinko.engine.physics.surface import ends_in, is_flush, rounding
from plinko.engine.physics.time_of_impact import NO_HIT


@inner_kernel
def leaving_time(series: Series, horizon: float) -> float:
    """When the normal force becomes zero, or NO_HIT."""
    return first_zero(series[contact.FORCE], 0, horizon)


@inner_kernel
def slip_end_time(
    series: Series, slip_sign: float, slip_root: int, radius: float, h: float
) -> float:
    """When the slip of a sliding ball, u - omega R with the sign slip_sign, is zero, or NO_HIT."""
    f = series[contact.SCRATCH]
    for i in range(contact.ORDER + 1):
        f[i] = slip_sign * (series[contact.SPEED, i] - radius * series[contact.SPIN, i])
    return first_zero(f, slip_root, h)


@inner_kernel
def rolling_end_time(series: Series, law: contact.Law, horizon: float) -> tuple[float, float]:
    """When a rolling ball needs more friction than mu N, or NO_HIT, and the sign of its slip then.

    Rolling needs the friction |g.t - k u| / 3. A ball that begins to roll at the limit, within
    rounding, continues to roll unless it then needs more.
    """
    f = series[contact.SCRATCH]
    best = NO_HIT
    sign = 0.0
    for way in range(2):
        drive_sign = 1.0 - 2.0 * way
        for i in range(contact.ORDER + 1):
            drive = law.gravity * series[contact.NORMAL_X, i] - law.drag * series[contact.SPEED, i]
            f[i] = 3.0 * law.friction * series[contact.FORCE, i] - drive_sign * drive
        s = _first_touch(f, horizon)
        if s != NO_HIT and (best == NO_HIT or s < best):
            best = s
            sign = drive_sign
    return best, sign


@inner_kernel
def landing_time(board: BoardArrays, series: Series, item: int, y: float, horizon: float) -> float:
    """When the centre of a ball on `item`, at height y now, crosses the bins' line, or NO_HIT."""
    f = series[contact.SCRATCH]
    distance = board.items[item, surface.DISTANCE]
    row = contact.NORMAL_Y if distance > 0.0 else contact.PATH
    rate = distance if distance > 0.0 else board.items[item, surface.TY]
    _affine(f, series, row, -rate, 0.0)
    f[0] = board.bins_y - y
    return first_zero(f, 0, horizon)


@inner_kernel
def _affine(f: Series, series: Series, row: int, rate: float, start: float) -> None:
    """f = start + rate * (the series of this row without its first term)."""
    f[0] = start
    for i in range(1, contact.ORDER + 1):
        f[i] = rate * series[row, i]


@inner_kernel
def _first_touch(f: Series, horizon: float) -> float:
    """First zero of a distance function.

    f[0] <= 0 is a touch within rounding. Returns 0 if the ball moves further in, or is at rest and
    accelerates inwards. If not, the root at 0 is divided out.
    """
    if f[0] > 0.0:
        return first_zero(f, 0, horizon)
    if f[1] < 0.0 or (f[1] == 0.0 and f[2] < 0.0):
        return 0.0
    return _next_touch(f, horizon)


@inner_kernel
def _next_touch(f: Series, horizon: float) -> float:
    """First zero after 0 of the distance to a surface that the ball touches and moves off."""
    if f[1] != 0.0:
        return first_zero(f, 1, horizon) if f[1] > 0.0 else NO_HIT
    return first_zero(f, 2, horizon) if f[2] > 0.0 else NO_HIT


@inner_kernel
def touch_time(
    board: BoardArrays,
    series: Series,
    item: int,
    x: float,
    y: float,
    other: int,
    moves_off: bool,
    h: float,
) -> tuple[float, float]:
    """When a ball on `item`, now at (x, y), touches `other`, or NO_HIT; and the side of a line.

    `moves_off`: whether the ball is known to touch `other` now and to move off it, which rounding
    may hide. Instead of a side, 0 with a time means that the ball, past the end of a line and
    behind it, comes out from behind it then: only from there on can it be seen to touch the line.
    """
    f = series[contact.SCRATCH]
    items = board.items
    on_circle = items[item, surface.DISTANCE] > 0.0
    dx = x - items[other, surface.X]
    dy = y - items[other, surface.Y]
    if items[other, surface.DISTANCE] > 0.0:
        if on_circle:
            px = items[item, surface.X] - items[other, surface.X]
            py = items[item, surface.Y] - items[other, surface.Y]
            twice = 2.0 * items[item, surface.DISTANCE]
            for i in range(1, contact.ORDER + 1):
                f[i] = twice * (px * series[contact.NORMAL_X, i] + py * series[contact.NORMAL_Y, i])
        else:
            _circle_seen_from_line(f, series, dx, dy)
        f[0] = dx * dx + dy * dy - items[other, surface.DISTANCE2]
        return _next_touch(f, h) if moves_off else _first_touch(f, h), 0.0
    nx = items[other, surface.NX]
    ny = items[other, surface.NY]
    d = nx * dx + ny * dy
    side = 1.0 if d > 0.0 else -1.0
    if on_circle:
        reach = side * items[item, surface.DISTANCE]
        for i in range(1, contact.ORDER + 1):
            f[i] = reach * (nx * series[contact.NORMAL_X, i] + ny * series[contact.NORMAL_Y, i])
    else:
        tx = -series[contact.NORMAL_Y, 0]
        ty = series[contact.NORMAL_X, 0]
        _affine(f, series, contact.PATH, side * (nx * tx + ny * ty), 0.0)
    f[0] = side * d - board.radius
    if not moves_off and f[0] < -rounding(x, y):
        for i in range(contact.ORDER + 1):
            f[i] = -f[i]
        return first_zero(f, 0, h), 0.0
    s = _next_touch(f, h) if moves_off else _first_touch(f, h)
    if s != NO_HIT and not _foot_inside(board, series, item, x, y, other, s):
        s = _onto_line(board, series, item, x, y, other, side, s, h)
    return s, side


@inner_kernel
def _onto_line(
    board: BoardArrays, series: Series, item: int, x: float, y: float, other: int, side: float,
    begin: float, h: float,
) -> float:  # fmt: skip
    """When a ball that touches the extension of a line from `begin` on comes onto the line itself.

    NO_HIT if it does not. A ball on a wall's end may meet the next wall with no angle and no
    distance, within rounding, as in `next_impact`.
    """
    line = board.items[other]
    foot = (x - line[surface.X]) * line[surface.TX] + (y - line[surface.Y]) * line[surface.TY]
    outwards = -1.0 if foot < 0.0 else 1.0
    beyond = -foot if foot < 0.0 else foot - line[surface.LENGTH]
    f = series[contact.SCRATCH]
    distance = board.items[item, surface.DISTANCE]
    if distance > 0.0:
        reach = outwards * distance
        for i in range(1, contact.ORDER + 1):
            f[i] = reach * (
                line[surface.TX] * series[contact.NORMAL_X, i]
                + line[surface.TY] * series[contact.NORMAL_Y, i]
            )
        f[0] = beyond
    else:
        tx = -series[contact.NORMAL_Y, 0]
        ty = series[contact.NORMAL_X, 0]
        along = outwards * (tx * line[surface.TX] + ty * line[surface.TY])
        _affine(f, series, contact.PATH, along, beyond)
    s = _first_touch(f, h)
    if s == NO_HIT or s < begin:
        return NO_HIT
    px, py = position(board, series, item, x, y, s)
    dx = px - line[surface.X]
    dy = py - line[surface.Y]
    gap = side * (line[surface.NX] * dx + line[surface.NY] * dy) - board.radius
    return s if abs(gap) <= rounding(px, py) else NO_HIT


@inner_kernel
def _circle_seen_from_line(f: Series, series: Series, dx: float, dy: float) -> None:
    """|d + t l(s)|^2 without its first term, for a ball that moves by l(s) along t."""
    tx = -series[contact.NORMAL_Y, 0]
    ty = series[contact.NORMAL_X, 0]
    path = series[contact.PATH]
    along = 2.0 * (dx * tx + dy * ty)
    for i in range(1, contact.ORDER + 1):
        square = 0.0
        for j in range(1, i):
            square += path[j] * path[i - j]
        f[i] = along * path[i] + square


@inner_kernel
def position(
    board: BoardArrays, series: Series, item: int, x: float, y: float, s: float
) -> tuple[float, float]:
    """Centre, in m, at time s of a ball on `item` that is at (x, y) at time 0."""
    distance = board.items[item, surface.DISTANCE]
    if distance > 0.0:
        px = board.items[item, surface.X] + distance * value(series[contact.NORMAL_X], s)
        py = board.items[item, surface.Y] + distance * value(series[contact.NORMAL_Y], s)
        return px, py
    path = value(series[contact.PATH], s)
    return x - series[contact.NORMAL_Y, 0] * path, y + series[contact.NORMAL_X, 0] * path


@inner_kernel
def _foot_inside(
    board: BoardArrays, series: Series, item: int, x: float, y: float, other: int, s: float
) -> bool:
    """Whether at time s the foot of the ball on the line `other` lies between its ends."""
    px, py = position(board, series, item, x, y, s)
    line = board.items[other]
    foot = (px - line[surface.X]) * line[surface.TX] + (py - line[surface.Y]) * line[surface.TY]
    near = rounding(px, py)
    return bool(-near <= foot <= line[surface.LENGTH] + near)


@inner_kernel
def line_end_time(
    board: BoardArrays, series: Series, item: int, x: float, y: float, horizon: float
) -> tuple[float, int]:
    """When a ball on a line passes one of its ends, or NO_HIT; and which one, 0 or 1."""
    line = board.items[item]
    foot = (x - line[surface.X]) * line[surface.TX] + (y - line[surface.Y]) * line[surface.TY]
    along = (
        -series[contact.NORMAL_Y, 0] * line[surface.TX]
        + series[contact.NORMAL_X, 0] * line[surface.TY]
    )
    f = series[contact.SCRATCH]
    best = NO_HIT
    end = 0
    for way in range(2):
        sign = 1.0 - 2.0 * way
        _affine(
            f, series, contact.PATH, sign * along, foot if way == 0 else line[surface.LENGTH] - foot
        )
        s = _first_touch(f, horizon)
        if s != NO_HIT and (best == NO_HIT or s < best):
            best = s
            end = way
    return best, end


@inner_kernel
def onto_line_time(
    board: BoardArrays, series: Series, item: int, cell: int, horizon: float
) -> tuple[float, int]:
    """When a ball on a circle rolls onto a line that ends there, or NO_HIT; and which line.

    The circle is a wall's end, or a peg with which the line is flush on one side. `cell` lists all
    surfaces that the ball can touch.
    """
    f = series[contact.SCRATCH]
    best = NO_HIT
    entered = -1
    for k in range(board.starts[cell], board.starts[cell + 1]):
        line = int(board.members[k])
        row = board.items[line]
        if not ends_in(board.items, line, item):
            continue
        outwards = -1.0 if row[surface.FIRST_END] == item else 1.0
        for i in range(contact.ORDER + 1):
            f[i] = outwards * (
                row[surface.TX] * series[contact.NORMAL_X, i]
                + row[surface.TY] * series[contact.NORMAL_Y, i]
            )
        s = _first_touch(f, horizon)
        if s == NO_HIT or (best != NO_HIT and s >= best):
            continue
        up = (
            value(series[contact.NORMAL_X], s) * row[surface.NX]
            + value(series[contact.NORMAL_Y], s) * row[surface.NY]
        )
        side = 1.0 if up > 0.0 else -1.0
        px, py = position(board, series, item, 0.0, 0.0, s)
        if is_flush(board.items, board.radius, line, side, item) and is_near(
            board.items, line, side, px, py, board.radius
        ):
            best = s
            entered = line
    return best, entered
