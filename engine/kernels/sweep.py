"""The first surface met on a straight line: the swept test of the stepped solver."""

from math import sqrt

from engine.kernels.impact_time import NO_HIT
from engine.kernels.jit import kernel
from engine.kernels.layout import DISTANCE, DISTANCE2, LENGTH, NX, NY, TX, TY, Layout, X, Y


@kernel
def sweep_circle(qx: float, qy: float, vx: float, vy: float, d2: float, horizon: float) -> float:
    """First s in [0, horizon] with |q + v s|^2 <= d2 while closing in, or NO_HIT."""
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


@kernel
def sweep_line(
    board: Layout, item: int, x: float, y: float, vx: float, vy: float, horizon: float
) -> tuple[float, float]:
    """First s in [0, horizon] at which a ball closes in on the inside of a wall, and the side."""
    line = board.items[item]
    dx = x - line[X]
    dy = y - line[Y]
    d = line[NX] * dx + line[NY] * dy
    side = 1.0 if d > 0.0 else -1.0
    h = side * d - board.radius
    hd = side * (line[NX] * vx + line[NY] * vy)
    if hd >= 0.0:
        return NO_HIT, side
    s = -h / hd if h > 0.0 else 0.0
    if s > horizon:
        return NO_HIT, side
    foot = (dx + vx * s) * line[TX] + (dy + vy * s) * line[TY]
    if not 0.0 <= foot <= line[LENGTH]:
        return NO_HIT, side
    return s, side


@kernel
def sweep(
    board: Layout, cell: int, x: float, y: float, vx: float, vy: float, horizon: float, left: int
) -> tuple[float, int, float]:
    """First surface of a cell met within the horizon: time (the horizon if none), item, side.

    `left` is the surface (or -1) that the ball just bounced off: a straight line away from a convex
    surface cannot meet it again, whatever rounding says of the way the ball is going.

    At equal times the lower surface number counts; item is -1 if nothing is met.
    """
    best = horizon
    item = -1
    side = 0.0
    for k in range(board.starts[cell], board.starts[cell + 1]):
        other = board.members[k]
        if other == left:
            continue
        surface = board.items[other]
        other_side = 0.0
        if surface[DISTANCE] > 0.0:
            s = sweep_circle(x - surface[X], y - surface[Y], vx, vy, surface[DISTANCE2], best)
        else:
            s, other_side = sweep_line(board, other, x, y, vx, vy, best)
        if s != NO_HIT and (s < best or item < 0):
            best = s
            item = other
            side = other_side
    return best, item, side
