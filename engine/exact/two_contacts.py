"""A ball that meets a second surface while it touches a first: impulses in turn, then a decision.

    approach   The ball strikes each surface that it approaches faster than DYING_BOUNCE, the lower
               number first, until it approaches neither.
    part       If it leaves a surface faster than DYING_BOUNCE, it is off that surface, and flies or
               stays on the other.
    rest       If it leaves neither, or is too slow to rise by more than rounding, it has stopped
               in the notch, and `rest_in_notch` decides.

Each impulse at an approach speed w > DYING_BOUNCE lowers the energy by at least (1 - e^2) w^2 / 2.
Between nearly parallel surfaces, or elastic ones, the impulses do not end for long. After
MOST_IMPULSES the drop ends without a result: this is a limit of the computation.
"""

from plinko.engine.constants import KIND_CONTACT_BEGIN, KIND_CONTACT_END
from plinko.engine.exact import initial_state
from plinko.engine.exact.board_arrays import BoardArrays, friction_of, restitution_of
from plinko.engine.exact.event_log import Log, note_contact, note_impact, note_segment
from plinko.engine.exact.free_flight import DYING_BOUNCE, is_pressed_on, rebound
from plinko.engine.exact.initial_state import Resume
from plinko.engine.exact.outcome import FALSE_PATH, IMPULSE_LIMIT, PHASE_ENDS, WEDGED
from plinko.engine.jit.decorator import inner_kernel
from plinko.engine.physics import body, contact
from plinko.engine.physics.array_types import Floats
from plinko.engine.physics.surface import rounding, touch
from plinko.engine.physics.two_contacts import (
    FALLS,
    GOES_ON_A,
    JAMS,
    RESTS,
    SPINS,
    rest_in_notch,
)

MOST_IMPULSES = 1000
"""Impulses of one meeting. Without friction, between plastic surfaces whose normals are an angle
phi short of opposite, a ball is slowed from 1 m/s to DYING_BOUNCE by ln(1e8) / -ln(cos phi)
impulses: 1000 suffice for 11 degrees and more."""

STOPPED = 8.0 * DYING_BOUNCE
"""m/s. A ball at a meeting that is at most this fast has stopped."""

# What the ball does next, if the drop has no outcome.
FLIES = PHASE_ENDS  # bounces off both surfaces
LIFTS = PHASE_ENDS + 1  # leaves both, without a speed off the surface returned
STAYS = PHASE_ENDS + 2  # rolls or slides on the surface returned


@inner_kernel
def meet(
    board: BoardArrays, state: Floats, a: int, a_side: float, b: int, b_side: float, log: Log
) -> tuple[int, int, float, Resume]:
    """A ball that touches a meets b. Changes `state` in place and logs the events.

    Returns what the ball does next or the outcome, a surface and its side, and with what it
    continues there.
    """
    last = b
    sticks = False
    off_a = 0.0
    off_b = 0.0
    impulses = 0
    while True:
        off_a = _speed_off(board, state, a, a_side)
        off_b = _speed_off(board, state, b, b_side)
        if off_a >= -DYING_BOUNCE and off_b >= -DYING_BOUNCE:
            break
        if impulses == MOST_IMPULSES:
            return IMPULSE_LIMIT, b, b_side, Resume(0, 0.0, a)
        impulses += 1
        last = a if off_a < -DYING_BOUNCE and (a < b or off_b >= -DYING_BOUNCE) else b
        sticks, is_true = _strike(board, state, last, a_side if last == a else b_side, log)
        if not is_true:
            return FALSE_PATH, b, b_side, Resume(0, 0.0, a)
    if _is_slow(board, state):
        _stop(state)
        return _rest(board, state, a, a_side, b, b_side, log)
    last_side = a_side if last == a else b_side
    other = b if last == a else a
    if off_a > DYING_BOUNCE and off_b > DYING_BOUNCE:
        return FLIES, last, last_side, Resume(0, 0.0, other)
    if off_a <= DYING_BOUNCE and off_b <= DYING_BOUNCE:
        # The normals are nearly parallel: the ball passes from one surface to the other, or is
        # stuck.
        if _slides_off(board, state, a, a_side, b, b_side):
            return _stay(board, state, a, a_side, b, 0, log)
        if _slides_off(board, state, b, b_side, a, a_side):
            return _stay(board, state, b, b_side, a, 0, log)
        _stop(state)
        return _rest(board, state, a, a_side, b, b_side, log)
    if off_a <= DYING_BOUNCE:
        return _stay(board, state, a, a_side, b, 1 if sticks and last == a else 0, log)
    return _stay(board, state, b, b_side, a, 1 if sticks and last == b else 0, log)


@inner_kernel
def _normal(board: BoardArrays, state: Floats, item: int, side: float) -> tuple[float, float]:
    nx, ny, _, _ = touch(board.items, board.radius, item, side, state[body.X], state[body.Y])
    return nx, ny


@inner_kernel
def _speed_off(board: BoardArrays, state: Floats, item: int, side: float) -> float:
    """Speed off a surface, m/s; negative towards it."""
    nx, ny = _normal(board, state, item, side)
    return float(state[body.VX] * nx + state[body.VY] * ny)


@inner_kernel
def _strike(
    board: BoardArrays, state: Floats, item: int, side: float, log: Log
) -> tuple[bool, bool]:
    """Apply an impact on `item`; returns whether friction stopped the slip, and if it is true."""
    x, y, vx, vy, omega, _, _, sticks, is_true = rebound(
        board.items, item, side, state[body.X], state[body.Y], state[body.VX], state[body.VY],
        state[body.OMEGA], board.radius, restitution_of(board, item), friction_of(board, item),
    )  # fmt: skip
    state[body.X] = x
    state[body.Y] = y
    state[body.VX] = vx
    state[body.VY] = vy
    state[body.OMEGA] = omega
    note_impact(board, state, item, log)
    return sticks, is_true


@inner_kernel
def _stop(state: Floats) -> None:
    state[body.VX] = 0.0
    state[body.VY] = 0.0


@inner_kernel
def _slides_off(
    board: BoardArrays, state: Floats, item: int, side: float, other: int, other_side: float
) -> bool:
    """Whether the ball's motion along `item` does not lead into `other`."""
    nx, ny = _normal(board, state, item, side)
    other_x, other_y = _normal(board, state, other, other_side)
    u = state[body.VY] * nx - state[body.VX] * ny
    return bool(u * (other_y * nx - other_x * ny) >= 0.0)


@inner_kernel
def _is_slow(board: BoardArrays, state: Floats) -> bool:
    """Whether the ball has stopped: slower than STOPPED, or too slow to rise by more than rounding.

    A slower ball would bounce between the two surfaces for ever, driven by its position's rounding.
    """
    vv = state[body.VX] * state[body.VX] + state[body.VY] * state[body.VY]
    height = rounding(state[body.X], state[body.Y])
    return bool(vv <= max(STOPPED * STOPPED, 2.0 * board.gravity * height))


@inner_kernel
def _stay(
    board: BoardArrays, state: Floats, item: int, side: float, other: int, slip_root: int, log: Log
) -> tuple[int, int, float, Resume]:
    """The ball continues along `item`: it stays there if it is pressed on, and lifts off if not."""
    nx, ny = _normal(board, state, item, side)
    vx, vy = state[body.VX], state[body.VY]
    u = vy * nx - vx * ny
    state[body.VX] = -u * ny
    state[body.VY] = u * nx
    if is_pressed_on(board.items, item, vx, vy, nx, ny, board.gravity):
        note_contact(board, state, KIND_CONTACT_BEGIN, item, log)
        return STAYS, item, side, Resume(slip_root, 0.0, other)
    return LIFTS, item, side, Resume(0, 0.0, other)


@inner_kernel
def _rest(
    board: BoardArrays, state: Floats, a: int, a_side: float, b: int, b_side: float, log: Log
) -> tuple[int, int, float, Resume]:
    """A ball at rest in the notch: friction stops its spin, then it rests, falls or goes on.

    The result is that of `meet`.
    """
    ax, ay = _normal(board, state, a, a_side)
    bx, by = _normal(board, state, b, b_side)
    friction_a = friction_of(board, a)
    friction_b = friction_of(board, b)
    gravity = board.gravity
    rest, brake = rest_in_notch(gravity, state[body.OMEGA], ax, ay, friction_a, bx, by, friction_b)
    begun = rest == SPINS
    if begun:
        note_contact(board, state, KIND_CONTACT_BEGIN, a, log)
        note_contact(board, state, KIND_CONTACT_BEGIN, b, log)
        _spin_down(board, state, b, b_side, brake, log)
    if begun or rest == JAMS:
        state[body.OMEGA] = 0.0
        rest, _ = rest_in_notch(gravity, 0.0, ax, ay, friction_a, bx, by, friction_b)
    if rest == RESTS:
        return WEDGED, b, b_side, Resume(0, 0.0, initial_state.NONE)
    if rest == FALLS:
        return LIFTS, b, b_side, Resume(0, 0.0, a)
    stays = a if rest == GOES_ON_A else b
    side = a_side if rest == GOES_ON_A else b_side
    opened = b if rest == GOES_ON_A else a
    if begun:
        note_contact(board, state, KIND_CONTACT_END, opened, log)
    else:
        note_contact(board, state, KIND_CONTACT_BEGIN, stays, log)
    return STAYS, stays, side, Resume(0, 0.0, opened)


@inner_kernel
def _spin_down(
    board: BoardArrays, state: Floats, item: int, side: float, brake: float, log: Log
) -> None:
    """Log the ball's spinning in the notch, and move `state` to when friction has stopped it."""
    omega = state[body.OMEGA]
    rate = -2.0 * brake / board.radius if omega > 0.0 else 2.0 * brake / board.radius
    note_segment(log, state, float(item), side, float(contact.HELD), rate)
    s = -omega / rate
    state[body.T] += s
    state[body.THETA] += 0.5 * omega * s
