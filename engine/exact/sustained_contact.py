"""Follows a contact phase: a ball rolls or slides on a peg or wall until that ends."""

from plinko.engine.constants import KIND_CONTACT_CHANGE
from plinko.engine.exact import event_log, initial_state
from plinko.engine.exact.board_arrays import BoardArrays, cell_of, law_on
from plinko.engine.exact.contact_end import (
    landing_time,
    leaving_time,
    line_end_time,
    onto_line_time,
    position,
    rolling_end_time,
    slip_end_time,
    touch_time,
)
from plinko.engine.exact.event_log import Log, note_contact, note_segment
from plinko.engine.exact.free_flight import is_near
from plinko.engine.exact.initial_state import Resume
from plinko.engine.exact.outcome import (
    BALANCED,
    ESCAPED,
    EVENT_LIMIT,
    FALSE_PATH,
    LANDED,
    PHASE_ENDS,
    TIME_LIMIT,
)
from plinko.engine.jit.decorator import inner_kernel
from plinko.engine.physics import body, contact, surface
from plinko.engine.physics.array_types import Floats
from plinko.engine.physics.contact import choose_mode, expand, hold, normal_force, step_length
from plinko.engine.physics.flight import HALF_WAY
from plinko.engine.physics.series import Series, value
from plinko.engine.physics.surface import ends_in, is_flush, side_of, touch
from plinko.engine.physics.time_of_impact import NO_HIT

# Why a contact ended, if not with an outcome.
LEFT = PHASE_ENDS  # the normal force became zero
OFF = PHASE_ENDS + 1  # there was no normal force from the start
HIT = PHASE_ENDS + 2  # the ball touched another surface
# Causes for which the contact goes on.
STEP_END = PHASE_ENDS + 3
MODE_CHANGED = PHASE_ENDS + 4
ROLLED_OVER = PHASE_ENDS + 5


@inner_kernel
def start_series(
    board: BoardArrays,
    series: Series,
    state: Floats,
    item: int,
    side: float,
    mode: int,
    slip_sign: float,
) -> None:
    """Compute the series of the motion on `item` from `state` on.

    The bits depend only on the arguments, so a segment of the log gives the same motion again. For
    a ball that is HELD, `slip_sign` is the rate of its spin, in rad/s^2.
    """
    nx, ny, _, _ = touch(board.items, board.radius, item, side, state[body.X], state[body.Y])
    series[contact.NORMAL_X, 0] = nx
    series[contact.NORMAL_Y, 0] = ny
    series[contact.SPEED, 0] = state[body.VY] * nx - state[body.VX] * ny
    series[contact.SPIN, 0] = state[body.OMEGA]
    series[contact.ANGLE, 0] = state[body.THETA]
    series[contact.PATH, 0] = 0.0
    if mode == contact.HELD:
        hold(series, slip_sign)
        return
    if mode == contact.ROLLING:
        series[contact.SPIN, 0] = series[contact.SPEED, 0] / board.radius
    expand(series, mode, slip_sign, law_on(board, item))


@inner_kernel
def advance_contact(board: BoardArrays, series: Series, state: Floats, item: int, s: float) -> None:
    """Move the state along its series by s seconds."""
    x, y = position(board, series, item, state[body.X], state[body.Y], s)
    u = value(series[contact.SPEED], s)
    state[body.T] += s
    state[body.X] = x
    state[body.Y] = y
    state[body.VX] = -u * value(series[contact.NORMAL_Y], s)
    state[body.VY] = u * value(series[contact.NORMAL_X], s)
    state[body.THETA] = value(series[contact.ANGLE], s)
    state[body.OMEGA] = value(series[contact.SPIN], s)


@inner_kernel
def _first_touch_of_others(
    board: BoardArrays,
    series: Series,
    state: Floats,
    item: int,
    side: float,
    second_surface: int,
    middle_x: float,
    middle_y: float,
    cell: int,
    horizon: float,
) -> tuple[float, int, float]:
    """The first other surface in the cell that is touched: time, item and side.

    -1 for the item if there is no touch; the time is then the horizon, or before it if the ball
    comes out from behind a line.
    """
    best = horizon
    hit = -1
    hit_side = 0.0
    for k in range(board.starts[cell], board.starts[cell + 1]):
        other = int(board.members[k])
        if other == item or _continues(board, item, side, other, state[body.X], state[body.Y]):
            continue
        s, other_side = touch_time(
            board,
            series,
            item,
            state[body.X],
            state[body.Y],
            other,
            other == second_surface,
            best,
        )
        is_line = board.items[other, surface.DISTANCE] == 0.0
        if is_line and other_side == 0.0:
            if s != NO_HIT and s < best and _is_in_reach(board, other, middle_x, middle_y):
                best = s  # the stretch ends where the ball comes out
                hit = -1
        elif s != NO_HIT and (s < best or hit < 0):
            best = s
            hit = other
            hit_side = other_side
    return best, hit, hit_side


@inner_kernel
def _is_in_reach(board: BoardArrays, line: int, x: float, y: float) -> bool:
    """Whether a ball in a stretch whose chord has its middle at (x, y) may touch this line.

    Cells list more lines than these. Without this test, bits would depend on the grid.
    """
    row = board.items[line]
    dx = x - row[surface.X]
    dy = y - row[surface.Y]
    along = min(max(dx * row[surface.TX] + dy * row[surface.TY], 0.0), row[surface.LENGTH])
    dx -= along * row[surface.TX]
    dy -= along * row[surface.TY]
    reach = board.radius + HALF_WAY * board.travel
    return bool(dx * dx + dy * dy <= reach * reach)


@inner_kernel
def _continues(board: BoardArrays, item: int, side: float, other: int, x: float, y: float) -> bool:
    """Whether the surface `item`, on this side, continues as `other` without an angle.

    The ball, at (x, y), passes from one to the other without an impact: a line's ends, a line that
    ends in the circle `item`, and a circle that only just rises to the line, such as an end within
    the wall.
    """
    if board.items[item, surface.DISTANCE] > 0.0:
        return ends_in(board.items, other, item) and is_flush(
            board.items, board.radius, other, side_of(board.items, other, x, y), item
        )
    if board.items[other, surface.DISTANCE] == 0.0:
        return False
    return is_flush(board.items, board.radius, item, side, other)


@inner_kernel
def _surface_change(
    board: BoardArrays,
    series: Series,
    state: Floats,
    item: int,
    cell: int,
    horizon: float,
) -> tuple[float, int]:
    """When the ball passes from a line to its end or back, or NO_HIT; and onto which item."""
    row = board.items[item]
    if row[surface.DISTANCE] == 0.0:
        s, end = line_end_time(board, series, item, state[body.X], state[body.Y], horizon)
        return s, int(row[surface.FIRST_END + end])
    return onto_line_time(board, series, item, cell, horizon)


@inner_kernel
def _next_cause(
    board: BoardArrays,
    series: Series,
    state: Floats,
    item: int,
    side: float,
    mode: int,
    slip_sign: float,
    slip_root: int,
    second_surface: int,
    fresh: bool,
) -> tuple[float, int, int, float]:
    """The first cause that ends this stretch: its time, the cause, and a surface with a side.

    For MODE_CHANGED the last value is the sign of the slip that begins, 0 if slipping ends.

    At equal times the order of the tests decides: touch, landing, leaving, passing to another part
    of the wall, change of mode. Each later search ends at the time found before, so a later cause
    must come strictly earlier. `fresh` means that the mode has changed at this same time. It does
    not change again before time has passed, because rounding at the friction limit could change it
    for ever.
    """
    h = step_length(series, board.radius, board.travel)
    # In a step the ball moves at most `travel`, so the cell at the middle of its chord lists all
    # surfaces that it can touch.
    x, y = position(board, series, item, state[body.X], state[body.Y], h)
    middle_x = 0.5 * (state[body.X] + x)
    middle_y = 0.5 * (state[body.Y] + y)
    cell = cell_of(board, middle_x, middle_y)
    s, hit, hit_side = _first_touch_of_others(
        board, series, state, item, side, second_surface, middle_x, middle_y, cell, h
    )
    cause = HIT if hit >= 0 else STEP_END
    other = hit if hit >= 0 else item
    sign = hit_side if hit >= 0 else side
    when = landing_time(board, series, item, state[body.Y], s)
    if when != NO_HIT and (when < s or cause == STEP_END):
        s, cause, other, sign = when, LANDED, item, side
    when = leaving_time(series, s)
    if when != NO_HIT and (when < s or cause == STEP_END):
        s, cause, other, sign = when, LEFT, item, side
    when, onto = _surface_change(board, series, state, item, cell, s)
    if when != NO_HIT and (when < s or cause == STEP_END):
        s, cause, other, sign = when, ROLLED_OVER, onto, 0.0
    new_sign = 0.0
    when = NO_HIT
    if mode == contact.SLIDING:
        when = slip_end_time(series, slip_sign, slip_root, board.radius, s)
    elif mode == contact.ROLLING:
        when, new_sign = rolling_end_time(series, law_on(board, item), s)
    if fresh and when == 0.0:
        when = NO_HIT
    if when != NO_HIT and (when < s or cause == STEP_END):
        s, cause, other, sign = when, MODE_CHANGED, item, new_sign
    return s, cause, other, sign


@inner_kernel
def follow_contact(
    board: BoardArrays,
    series: Series,
    state: Floats,
    item: int,
    side: float,
    resume: Resume,
    max_time: float,
    event_limit: int,
    log: Log,
) -> tuple[int, int, float, int, float, Resume]:
    """Move a ball that lies on `item` until its contact phase ends.

    Returns the cause or outcome, the surface and side that the ball was on last, the surface and
    side that it hit, if it hit one, and with what it continues.
    """
    slip_root, slip_sign, second_surface = resume
    other = item
    sign = side
    cause = STEP_END
    fresh = False
    while True:
        # Not if `fresh`: that is not among the columns of `initial`, so the bits of a drop that is
        # continued here would differ.
        if log.counts[event_log.EVENTS] >= event_limit and not fresh:
            cause = EVENT_LIMIT
            break
        if not state[body.T] <= max_time:
            cause = TIME_LIMIT
            break
        if cell_of(board, state[body.X], state[body.Y]) < 0:
            cause = ESCAPED
            break
        if not is_near(board.items, item, side, state[body.X], state[body.Y], board.radius):
            cause = FALSE_PATH
            break
        nx, ny, state[body.X], state[body.Y] = touch(
            board.items, board.radius, item, side, state[body.X], state[body.Y]
        )
        u = state[body.VY] * nx - state[body.VX] * ny
        law = law_on(board, item)
        if normal_force(law, ny, u) <= 0.0:
            cause = OFF
            break
        mode = contact.SLIDING
        if slip_root != 2:
            mode, slip_sign = choose_mode(law, nx, ny, u, state[body.OMEGA], slip_root == 1)
        if nx == 0.0 and mode != contact.SLIDING and _has_stopped(law, u):
            cause = BALANCED
            break
        note_segment(log, state, float(item), side, float(mode), slip_sign)
        start_series(board, series, state, item, side, mode, slip_sign)
        s, cause, other, sign = _next_cause(
            board, series, state, item, side, mode, slip_sign, slip_root, second_surface, fresh
        )
        advance_contact(board, series, state, item, s)
        slip_root = 1 if mode == contact.ROLLING else 0
        if s > 0.0:
            second_surface = initial_state.NONE
        fresh = cause == MODE_CHANGED and s == 0.0
        if cause == MODE_CHANGED:
            note_contact(board, state, KIND_CONTACT_CHANGE, item, log)
            slip_sign = sign
            slip_root = 2 if mode == contact.ROLLING else 1
        elif cause == ROLLED_OVER:
            note_contact(board, state, KIND_CONTACT_CHANGE, other, log)
            item = other
            side = side_of(board.items, item, state[body.X], state[body.Y])
        elif cause != STEP_END:
            break
    return cause, item, side, other, sign, Resume(slip_root, slip_sign, second_surface)


@inner_kernel
def _has_stopped(law: contact.Law, u: float) -> bool:
    """Whether a ball that moves along a level surface at u m/s has stopped, within rounding.

    Drag lets it go on by u / k, or by 3 u / 2 k if it rolls. It has stopped if adding that to the
    ball's radius does not change the radius.
    """
    if u == 0.0 or law.drag == 0.0:
        return u == 0.0
    return law.radius + 1.5 * abs(u) / law.drag == law.radius
