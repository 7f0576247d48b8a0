"""The swept test of the stepped solver: the first surface that a ball hits on a straight line."""

from math import sqrt

from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.physics import surface
from plinko.engine.physics.time_of_impact import NO_HIT


@lean_kernel
def sweep_circle(qx: float, qy: float, vx: float, vy: float, d2: float, horizon: float) -> float:
    """First s in [0, horizon] with |q + v s|^2 <= d2, if the ball approaches; or NO_HIT."""
    f = qx * qx + qy * qy - d2
    half_fd = qx * vx + qy * vy
    if half_fd >= 0.0:
        return NO_HIT
    if f <= 0.0:
        return 0.0
    vv = vx * vx + vy * vy
    discriminant = half_fd * half_fd - vv * f
    if discriminant < 0.0:
        return NO_HIT
    s = f / (sqrt(discriminant) - half_fd)
    return s if s <= horizon else NO_HIT


@lean_kernel
def sweep_line(
    board: BoardArrays, item: int, x: float, y: float, vx: float, vy: float, horizon: float
) -> tuple[float, float]:
    """First s in [0, horizon] at which the ball hits a wall between its ends, or NO_HIT; and the
    side."""
    items = board.items
    dx = x - items[item, surface.X]
    dy = y - items[item, surface.Y]
    nx = items[item, surface.NX]
    ny = items[item, surface.NY]
    d = nx * dx + ny * dy
    side = 1.0 if d > 0.0 else -1.0
    h = side * d - board.radius
    hd = side * (nx * vx + ny * vy)
    if hd >= 0.0:
        return NO_HIT, side
    s = -h / hd if h > 0.0 else 0.0
    if s > horizon:
        return NO_HIT, side
    foot = (dx + vx * s) * items[item, surface.TX] + (dy + vy * s) * items[item, surface.TY]
    if not 0.0 <= foot <= items[item, surface.LENGTH]:
        return NO_HIT, side
    return s, side


@lean_kernel
def sweep(
    board: BoardArrays,
    cell: int,
    x: float,
    y: float,
    vx: float,
    vy: float,
    horizon: float,
    left: int,
) -> tuple[float, int, float]:
    """The first surface of a cell hit within the horizon: time, item and side.

    Without a hit the time is the horizon and item is -1. At equal times the lower surface number
    counts. `left` is the surface that the ball has just bounced off, or -1. It is not tested: a
    straight line away from a convex surface cannot hit it again, but rounding may say so.
    """
    items = board.items
    best = horizon
    item = -1
    side = 0.0
    for k in range(board.starts[cell], board.starts[cell + 1]):
        other = int(board.members[k])
        if other == left:
            continue
        other_side = 0.0
        if items[other, surface.DISTANCE] > 0.0:
            qx = x - items[other, surface.X]
            qy = y - items[other, surface.Y]
            s = sweep_circle(qx, qy, vx, vy, items[other, surface.DISTANCE2], best)
        else:
            s, other_side = sweep_line(board, other, x, y, vx, vy, best)
        if s != NO_HIT and (s < best or item < 0):
            best = s
            item = other
            side = other_side
    return best, item, side
