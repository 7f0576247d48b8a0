"""Free flight of the exact solver: from impact to impact, until a ball lands or stays on one."""

import numpy as np
import numpy.typing as npt

from engine.constants import KIND_PEG, KIND_WALL
from engine.exact import event_log
from engine.exact.board_arrays import BoardArrays, friction_of, restitution_of
from engine.exact.event_log import Log, write_event, write_segment
from engine.exact.next_impact import BINS, BOUNCED, NOWHERE, next_impact
from engine.jit.decorator import lean_kernel
from engine.physics import body, surface
from engine.physics.flight import basis
from engine.physics.impulse import bounce

Array = npt.NDArray[np.float64]

DYING_BOUNCE = 1.0e-8
"""m/s. A bounce that leaves a surface slower than this, and is pressed back, has died: the ball
stays on the surface. What is cut off of the infinite sequence moves the ball by about 1e-19 m where
friction holds it and 1e-12 m where it slips; a larger value would be seen in the digest only."""

# Why `follow_flight` returned.
AT_BINS = 0
ON_SURFACE = 1
OUT_OF_EVENTS = 2
OUT_OF_TIME = 3
OUT_OF_BOARD = 4


@lean_kernel
def rebound(
    items: Array, item: int, side: float, x: float, y: float, vx: float, vy: float, omega: float,
    radius: float, restitution: float, friction: float,
) -> tuple[float, float, float, float, float, float, float, bool]:  # fmt: skip
    """A ball at (x, y) hits a surface: its centre put on it, velocity and spin after, the normal,
    and whether friction stopped the slip."""
    dx = x - items[item, surface.X]
    dy = y - items[item, surface.Y]
    distance = items[item, surface.DISTANCE]
    if distance > 0.0:
        # The ball is at D within rounding: one step of Newton's for 1 / sqrt makes it exact.
        nx = dx * items[item, surface.INVERSE]
        ny = dy * items[item, surface.INVERSE]
        unit = 1.5 - 0.5 * (nx * nx + ny * ny)
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
    return x, y, vx, vy, omega, nx, ny, sticks


@lean_kernel
def stays_on(
    items: Array, item: int, vx: float, vy: float, nx: float, ny: float, gravity: float
) -> bool:
    """Whether a bounce off a surface has died, and gravity presses the ball back onto it."""
    stays = False
    if vx * nx + vy * ny <= DYING_BOUNCE:
        u = vy * nx - vx * ny
        distance = items[item, surface.DISTANCE]
        bend = 1.0 / distance if distance > 0.0 else 0.0
        stays = -gravity * ny - bend * u * u > 0.0
    return stays


@lean_kernel
def follow_flight(
    board: BoardArrays,
    state: Array,
    item: int,
    side: float,
    how: int,
    touching: bool,
    event_limit: int,
    max_time: float,
    log: Log,
) -> tuple[int, int, float, bool]:
    """Flights and bounces from `state`, changed in place, until something else than a bounce.

    `item` and `side` name the surface that was left, and `how`; or, if `touching`, the one that is
    being hit. Returns the cause, the surface and side the ball is on, and whether friction stopped
    its slip there.
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
    cause = ON_SURFACE
    while True:
        if not touching:
            if counts[event_log.EVENTS] >= event_limit:
                cause = OUT_OF_EVENTS
                break
            row = counts[event_log.SEGMENTS]
            counts[event_log.SEGMENTS] = row + 1
            if row < len(log.segments):
                write_segment(log.segments, row, t, x, y, vx, vy, theta, omega, event_log.IN_FLIGHT)
            s, item, side = next_impact(board, x, y, vx, vy, item, side, how, max_time - t)
            if item == NOWHERE:
                cause = OUT_OF_TIME if t + s > max_time else OUT_OF_BOARD
                break
            ax = -board.drag * vx
            ay = board.gravity - board.drag * vy
            _, phi, psi = basis(board.drag, s)
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
        x, y, vx, vy, omega, nx, ny, sticks = rebound(
            items, item, side, x, y, vx, vy, omega, board.radius,
            restitution_of(board, item), friction_of(board, item),
        )  # fmt: skip
        row = counts[event_log.EVENTS]
        counts[event_log.EVENTS] = row + 1
        counts[event_log.IMPACTS] += 1
        if row < len(log.events):
            is_peg = item < board.peg_count
            kind = KIND_PEG if is_peg else KIND_WALL
            index = item if is_peg else (item - board.peg_count) // 3
            write_event(log.events, log.marks, row, t, x, y, vx, vy, omega, kind, index)
        if stays_on(items, item, vx, vy, nx, ny, board.gravity):
            u = vy * nx - vx * ny
            vx = -u * ny
            vy = u * nx
            break
    state[body.T] = t
    state[body.X] = x
    state[body.Y] = y
    state[body.VX] = vx
    state[body.VY] = vy
    state[body.THETA] = theta
    state[body.OMEGA] = omega
    return cause, item, side, sticks
