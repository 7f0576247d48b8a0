"""Free flight of the exact solver: from impact to impact, until a ball lands or stays on a surface.

A flight ends at the first surface that the ball hits. Then the ball flies on, or stays on the
surface. If a flight takes no time, the ball touches two surfaces, and two_contacts.py decides.
"""

from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.exact import event_log, initial_state
from plinko.engine.exact.board_arrays import BoardArrays, friction_of, restitution_of, wall_at
from plinko.engine.exact.event_log import Log, write_event, write_segment
from plinko.engine.exact.initial_state import Resume
from plinko.engine.exact.next_impact import (
    BINS,
    BOUNCED,
    FREE,
    LIFTED,
    OUT_OF_TIME,
    OUT_OF_WINDOWS,
    next_impact,
)
from plinko.engine.exact.outcome import (
    ESCAPED,
    EVENT_LIMIT,
    FALSE_PATH,
    LANDED,
    PHASE_ENDS,
    SEARCH_LIMIT,
    TIME_LIMIT,
)
from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.physics import body, surface
from plinko.engine.physics.array_types import Floats
from plinko.engine.physics.flight import basis
from plinko.engine.physics.impulse import bounce
from plinko.engine.physics.surface import rounding

DYING_BOUNCE = 1.0e-8
"""m/s. A bounce that leaves a surface at this speed or less has died: the ball's speed off the
surface is set to zero. It stays there if it is pressed on, and lifts off if not. The bounces that
are omitted move the ball by about 1e-19 m if friction holds it, and by 1e-12 m if it slips. Even a
larger value would be noticed only in digests."""

TRUE_WITHIN = 1.0e-9
"""Limit of the check of each path: how far, relative to the ball's radius, a ball may be from a
surface that it is said to touch; and by how much, relatively, an impact may raise the energy. Both
are much larger than rounding. No path is known that fails the check."""

# Why `follow_flight` returned, if not with an outcome.
ON_SURFACE = PHASE_ENDS
MET_ANOTHER = PHASE_ENDS + 1


@lean_kernel
def rebound(
    items: Floats, item: int, side: float, x: float, y: float, vx: float, vy: float, omega: float,
    radius: float, restitution: float, friction: float,
) -> tuple[float, float, float, float, float, float, float, bool, bool]:  # fmt: skip
    """The impact of a ball at (x, y) on a surface: its centre at the exact contact distance, the
    velocity and spin after the impact, the normal, whether friction stopped the slip, and whether
    the impact is true: on the surface and without a gain of energy, as TRUE_WITHIN says."""
    spin = 0.5 * radius * radius
    energy = vx * vx + vy * vy + spin * omega * omega
    dx = x - items[item, surface.X]
    dy = y - items[item, surface.Y]
    distance = items[item, surface.DISTANCE]
    if distance > 0.0:
        # The distance is D within rounding: one Newton step for 1 / sqrt makes the normal exact.
        nx = dx * items[item, surface.INVERSE]
        ny = dy * items[item, surface.INVERSE]
        square = nx * nx + ny * ny
        gap = 0.5 * distance * (square - 1.0)
        unit = 1.5 - 0.5 * square
        nx = nx * unit
        ny = ny * unit
        x = items[item, surface.X] + distance * nx
        y = items[item, surface.Y] + distance * ny
    else:
        nx = side * items[item, surface.NX]
        ny = side * items[item, surface.NY]
        gap = radius - (dx * nx + dy * ny)
        x = x + gap * nx
        y = y + gap * ny
    sticks = False
    if vx * nx + vy * ny < 0.0:
        vx, vy, omega, sticks = bounce(vx, vy, omega, nx, ny, radius, restitution, friction)
    energy_after = vx * vx + vy * vy + spin * omega * omega
    is_near = abs(gap) <= TRUE_WITHIN * radius
    is_true = is_near & (energy_after <= energy * (1.0 + TRUE_WITHIN))
    return x, y, vx, vy, omega, nx, ny, sticks, is_true


@inner_kernel
def is_near(items: Floats, item: int, side: float, x: float, y: float, radius: float) -> bool:
    """Whether a ball at (x, y) touches `item` on this side, as TRUE_WITHIN says."""
    return bool(abs(surface.gap_of(items, radius, item, side, x, y)) <= TRUE_WITHIN * radius)


@lean_kernel
def is_pressed_on(
    items: Floats, item: int, vx: float, vy: float, nx: float, ny: float, gravity: float
) -> bool:
    """Whether the normal force N on a ball that moves along a surface is positive."""
    u = vy * nx - vx * ny
    distance = items[item, surface.DISTANCE]
    bend = 1.0 / distance if distance > 0.0 else 0.0
    return -gravity * ny - bend * u * u > 0.0


@lean_kernel
def follow_flight(
    board: BoardArrays,
    state: Floats,
    item: int,
    side: float,
    how: int,
    second_surface: int,
    touching: bool,
    event_limit: int,
    max_time: float,
    log: Log,
) -> tuple[int, int, float, int, float, int, Resume]:
    """Follow flights and bounces from `state`, changed in place, until something else happens.

    The ball has left the surface `item` on `side` as `how` says, and at the same time
    `second_surface`, if not NONE. If `touching`, the ball is hitting `item` instead. Returns the
    cause or outcome; the surface and side that the ball touched last; the surface and side that it
    met, for MET_ANOTHER; how it left the first; and with what it continues.
    """
    items = board.items
    counts = log.counts
    t = state[body.T]
    x = state[body.X]
    y = state[body.Y]
    vx = state[body.VX]
    vy = state[body.VY]
    theta = state[body.THETA]
    omega = state[body.OMEGA]
    sticks = False
    met = initial_state.NONE
    met_side = 0.0
    cause = ON_SURFACE
    is_true = touching or how == FREE or is_near(items, item, side, x, y, board.radius)
    while True:
        if not is_true:
            cause = FALSE_PATH
            break
        if not touching:
            if counts[event_log.EVENTS] >= event_limit:
                cause = EVENT_LIMIT
                break
            row = counts[event_log.SEGMENTS]
            counts[event_log.SEGMENTS] = row + 1
            if row < len(log.segments):
                write_segment(log.segments, row, t, x, y, vx, vy, theta, omega, event_log.IN_FLIGHT)
            s, hit, hit_side = next_impact(
                board, x, y, vx, vy, item, side, how, second_surface, max_time - t
            )
            if hit < BINS:
                cause = ESCAPED
                if hit == OUT_OF_TIME:
                    cause = TIME_LIMIT
                elif hit == OUT_OF_WINDOWS:
                    cause = SEARCH_LIMIT
                break
            ax = -board.drag * vx
            ay = board.gravity - board.drag * vy
            _, phi, psi = basis(board.drag, s)
            before = t
            t += s
            dx = x
            dy = y
            x = x + vx * s + ax * psi
            y = y + vy * s + ay * psi
            dx = x - dx
            dy = y - dy
            vx = vx + ax * phi
            vy = vy + ay * phi
            theta = theta + omega * s
            if hit == BINS:
                cause = LANDED
                break
            # A ball that hits another surface without having moved touches both. Bounces in turn
            # could go on here for ever; two_contacts.py ends them.
            stood = t == before or abs(dx) + abs(dy) <= rounding(x, y)
            if stood and how != FREE and hit != item:
                cause = MET_ANOTHER
                met = hit
                met_side = hit_side
                break
            item = hit
            side = hit_side
        touching = False
        how = BOUNCED
        second_surface = initial_state.NONE
        x, y, vx, vy, omega, nx, ny, sticks, is_true = rebound(
            items, item, side, x, y, vx, vy, omega, board.radius,
            restitution_of(board, item), friction_of(board, item),
        )  # fmt: skip
        if not is_true:
            continue
        row = counts[event_log.EVENTS]
        counts[event_log.EVENTS] = row + 1
        counts[event_log.IMPACTS] += 1
        if row < len(log.events):
            is_peg = item < board.peg_count
            kind = KIND_PEG if is_peg else KIND_WALL
            index = item if is_peg else wall_at(board, item, x, y)
            write_event(log.events, log.marks, row, t, x, y, vx, vy, omega, kind, index)
        if vx * nx + vy * ny <= DYING_BOUNCE:
            u = vy * nx - vx * ny
            vx = -u * ny
            vy = u * nx
            if is_pressed_on(items, item, vx, vy, nx, ny, board.gravity):
                break
            how = LIFTED
    state[body.T] = t
    state[body.X] = x
    state[body.Y] = y
    state[body.VX] = vx
    state[body.VY] = vy
    state[body.THETA] = theta
    state[body.OMEGA] = omega
    resume = Resume(1 if sticks else 0, 0.0, second_surface)
    return cause, item, side, met, met_side, how, resume
