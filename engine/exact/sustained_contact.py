"""Contact phases of the exact solver: a ball that rides a peg or a wall until something ends it."""

import numpy as np
import numpy.typing as npt

from engine.constants import KIND_CONTACT_CHANGE
from engine.exact.event_log import EVENTS, Log, note_event, note_segment
from engine.jit.decorator import inner_kernel
from engine.physics.ball import OMEGA, PX, PY, THETA, VX, VY, T
from engine.physics.contact import (
    ANGLE,
    NORMAL_X,
    NORMAL_Y,
    PATH,
    ROLLING,
    SLIDING,
    SPEED,
    SPIN,
    choose_mode,
    expand,
    step_length,
)
from engine.physics.contact_end import (
    grip_end_time,
    landing_time,
    leaving_time,
    line_end_time,
    line_entry_time,
    position,
    slip_end_time,
    touch_time,
)
from engine.physics.layout import (
    DISTANCE,
    FIRST_END,
    FIRST_LINE,
    LAST_END,
    LINE_SLOTS,
    NX,
    NY,
    Layout,
    X,
    Y,
    cell_of,
)
from engine.physics.series import Series, value
from engine.physics.surface import curvature, friction_of, touch
from engine.physics.time_of_impact import NO_HIT

# Why a ride ended.
LEFT = 0  # the normal force vanished
OFF = 1  # there was none from the start
HIT = 2  # it touched another surface
LANDED = 3
AT_REST = 4
OUT_OF_TIME = 5
OUT_OF_EVENTS = 6
OUT_OF_BOARD = 7
# What happens within a ride.
STEP_END = 8
REGRIPPED = 9
ROLLED_OVER = 10


@inner_kernel
def start_series(
    board: Layout,
    series: Series,
    state: npt.NDArray[np.float64],
    item: int,
    side: float,
    mode: int,
    slip_sign: float,
) -> None:
    """Series of the motion on `item` from `state` on; the same bits whenever it is made again."""
    nx, ny, _, _ = touch(board, item, side, state[PX], state[PY])
    series[NORMAL_X, 0] = nx
    series[NORMAL_Y, 0] = ny
    series[SPEED, 0] = state[VY] * nx - state[VX] * ny
    series[SPIN, 0] = state[OMEGA]
    series[ANGLE, 0] = state[THETA]
    series[PATH, 0] = 0.0
    if mode == ROLLING:
        series[SPIN, 0] = series[SPEED, 0] / board.radius
    expand(
        series,
        mode,
        slip_sign,
        curvature(board, item),
        board.gravity,
        board.drag,
        friction_of(board, item),
        board.radius,
    )


@inner_kernel
def advance_ride(
    board: Layout, series: Series, state: npt.NDArray[np.float64], item: int, s: float
) -> None:
    """Move the state along its series by s."""
    x, y = position(board, series, item, state[PX], state[PY], s)
    u = value(series[SPEED], s)
    state[T] += s
    state[PX] = x
    state[PY] = y
    state[VX] = -u * value(series[NORMAL_Y], s)
    state[VY] = u * value(series[NORMAL_X], s)
    state[THETA] = value(series[ANGLE], s)
    state[OMEGA] = value(series[SPIN], s)


@inner_kernel
def _first_touch_of_others(
    board: Layout, series: Series, state: npt.NDArray[np.float64], item: int, horizon: float
) -> tuple[float, int, float]:
    """First surface touched within the horizon: time (horizon if none), item (-1) and side."""
    best = horizon
    hit = -1
    hit_side = 0.0
    x, y = position(board, series, item, state[PX], state[PY], horizon)
    cell = cell_of(board, 0.5 * (state[PX] + x), 0.5 * (state[PY] + y))
    for k in range(board.starts[cell], board.starts[cell + 1]):
        other = int(board.members[k])
        if other == item or _belongs(board, item, other):
            continue
        s, side = touch_time(board, series, item, state[PX], state[PY], other, best)
        if s != NO_HIT and (s < best or hit < 0):
            best = s
            hit = other
            hit_side = side
    return best, hit, hit_side


@inner_kernel
def _belongs(board: Layout, item: int, other: int) -> bool:
    """Whether `other` is an end of the line `item`, or a line that ends in the circle `item`."""
    row = board.items[item]
    if row[DISTANCE] == 0.0:
        return bool(other == row[FIRST_END] or other == row[LAST_END])
    for slot in range(LINE_SLOTS):
        if other == row[FIRST_LINE + slot]:
            return True
    return False


@inner_kernel
def _surface_change(
    board: Layout, series: Series, state: npt.NDArray[np.float64], item: int, horizon: float
) -> tuple[float, int]:
    """When the ball rolls over from a line to its end or back, and onto which item; or NO_HIT."""
    row = board.items[item]
    if row[DISTANCE] == 0.0:
        s, end = line_end_time(board, series, item, state[PX], state[PY], horizon)
        return s, int(row[FIRST_END + end])
    return line_entry_time(board, series, item, horizon)


@inner_kernel
def surface_index(board: Layout, item: int) -> int:
    """How contact events name a surface: a peg by its index, wall w as -1 - w."""
    if item < board.peg_count:
        return item
    return -1 - (item - board.peg_count) // 3


@inner_kernel
def _next_cause(
    board: Layout,
    series: Series,
    state: npt.NDArray[np.float64],
    item: int,
    side: float,
    mode: int,
    slip_sign: float,
    skip: int,
) -> tuple[float, int, int, float]:
    """What comes first on this stretch: its time, the cause, and a surface with a side.

    For REGRIPPED the last value is the sign of the slip that begins, 0 if slipping ends. Of
    causes at the same instant the one asked first counts.
    """
    h = step_length(series, board.radius, board.travel)
    s, hit, hit_side = _first_touch_of_others(board, series, state, item, h)
    cause = HIT if hit >= 0 else STEP_END
    other = hit if hit >= 0 else item
    sign = hit_side if hit >= 0 else side
    when = landing_time(board, series, item, state[PY], s)
    if when != NO_HIT and (when < s or cause == STEP_END):
        s, cause, other, sign = when, LANDED, item, side
    when = leaving_time(series, s)
    if when != NO_HIT and (when < s or cause == STEP_END):
        s, cause, other, sign = when, LEFT, item, side
    if item >= board.peg_count:
        when, onto = _surface_change(board, series, state, item, s)
        if when != NO_HIT and (when < s or cause == STEP_END):
            s, cause, other, sign = when, ROLLED_OVER, onto, 0.0
    new_sign = 0.0
    when = NO_HIT
    if mode == SLIDING:
        when = slip_end_time(series, slip_sign, skip, board.radius, s)
    elif mode == ROLLING:
        when, new_sign = grip_end_time(
            series, board.gravity, board.drag, friction_of(board, item), s
        )
    if when != NO_HIT and (when < s or cause == STEP_END):
        s, cause, other, sign = when, REGRIPPED, item, new_sign
    return s, cause, other, sign


@inner_kernel
def ride(
    board: Layout,
    series: Series,
    state: npt.NDArray[np.float64],
    item: int,
    side: float,
    grips: bool,
    max_time: float,
    event_limit: int,
    log: Log,
) -> tuple[int, int, float, int, float]:
    """Move a ball that lies on `item` until its contact phase ends.

    `grips` says that the impact before stopped the slip. Returns the cause, the surface and side
    it rode last, and the surface and side that it hit if it hit one.
    """
    # How many roots the slip has at the start of the stretch by what went before: none (computed),
    # one (it is zero), two (a rolling ball just lost its grip, in the direction slip_sign).
    skip = 1 if grips else 0
    slip_sign = 0.0
    while True:
        if log.counts[EVENTS] >= event_limit:
            return OUT_OF_EVENTS, item, side, item, side
        if not state[T] <= max_time:
            return OUT_OF_TIME, item, side, item, side
        if cell_of(board, state[PX], state[PY]) < 0:
            return OUT_OF_BOARD, item, side, item, side
        nx, ny, state[PX], state[PY] = touch(board, item, side, state[PX], state[PY])
        u = state[VY] * nx - state[VX] * ny
        normal_force = -board.gravity * ny - curvature(board, item) * u * u
        if normal_force <= 0.0:
            return OFF, item, side, item, side
        mode = SLIDING
        if skip != 2:
            mode, slip_sign = choose_mode(
                u,
                state[OMEGA],
                normal_force,
                board.gravity * nx - board.drag * u,
                board.radius,
                friction_of(board, item),
                skip == 1,
            )
        if nx == 0.0 and mode != SLIDING and _has_stopped(board, u):
            return AT_REST, item, side, item, side
        note_segment(log, state, float(item), side, float(mode), slip_sign)
        start_series(board, series, state, item, side, mode, slip_sign)
        s, cause, other, sign = _next_cause(board, series, state, item, side, mode, slip_sign, skip)
        advance_ride(board, series, state, item, s)
        skip = 1 if mode == ROLLING else 0
        if cause == REGRIPPED:
            note_event(log, state, KIND_CONTACT_CHANGE, surface_index(board, item))
            slip_sign = sign
            skip = 2 if mode == ROLLING else 1
        elif cause == ROLLED_OVER:
            note_event(log, state, KIND_CONTACT_CHANGE, surface_index(board, other))
            item = other
            side = side_of(board, state, item)
        elif cause != STEP_END:
            return cause, item, side, other, sign


@inner_kernel
def _has_stopped(board: Layout, u: float) -> bool:
    """Whether a ball that rolls or slips along level ground at u m/s gets nowhere any more.

    It has u / k to go, or 3 u / 2 k if it rolls; nowhere is what rounding would take from a length
    the size of the ball.
    """
    if u == 0.0 or board.drag == 0.0:
        return u == 0.0
    return board.radius + 1.5 * abs(u) / board.drag == board.radius


@inner_kernel
def side_of(board: Layout, state: npt.NDArray[np.float64], item: int) -> float:
    """Side of `item` on which the ball is: 1 or -1 for a line, 0 for a circle."""
    row = board.items[item]
    if row[DISTANCE] > 0.0:
        return 0.0
    d = (state[PX] - row[X]) * row[NX] + (state[PY] - row[Y]) * row[NY]
    return 1.0 if d > 0.0 else -1.0
