"""Narrow phase: distance and time of impact of a disc in straight motion and another shape.

The time of impact of two discs is the root of a quadratic equation (Ericson, Real-Time Collision
Detection, 2005, 5.5.5). A wall is a segment, and its ends are discs of radius zero.
"""

from math import sqrt

import numpy as np

from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.multibody.solver.layout import body, shape
from plinko.engine.multibody.solver.layout.array_types import Floats

SLACK = 0.005
"""Overlap, in radii of the smaller disc, up to which a slow approach is left to the contact solver.
Twice this must stay below the 1 % that piles may show. At zero, every ball at rest would have an
impact in each substep."""

SPECULATIVE_GAP = 0.005
"""Gap, in radii of the smaller disc, up to which two discs are in contact, so that a ball with a
tiny gap keeps its impulse. A larger value would slow down balls that pass each other. At zero,
contacts would flicker and piles would never come to rest."""

CREEP = 1.0e-3
"""Approaches that cover less than this fraction of the allowed overlap are ignored as rounding."""


@lean_kernel
def from_closest_point(items: Floats, item: int, x: float, y: float) -> tuple[float, float]:
    """Vector in m to (x, y) from the closest point of an item's axis."""
    dx = x - items[item, shape.X1]
    dy = y - items[item, shape.Y1]
    length = items[item, shape.LENGTH]
    if length > 0.0:
        along = dx * items[item, shape.TX] + dy * items[item, shape.TY]
        if along > 0.0:
            along = min(along, length)
            dx -= along * items[item, shape.TX]
            dy -= along * items[item, shape.TY]
    return dx, dy


@lean_kernel
def separation(pos: Floats, items: Floats, a: int, b: int) -> tuple[float, float, float, float]:
    """Return the vector in m from b (a ball, or -1 - item) to ball a, their contact distance, and
    the radius of the smaller ball, which is the unit of tolerances."""
    if b >= 0:
        dx = pos[a, body.X] - pos[b, body.X]
        dy = pos[a, body.Y] - pos[b, body.Y]
        ra = pos[a, body.RADIUS]
        rb = pos[b, body.RADIUS]
        return dx, dy, ra + rb, min(ra, rb)
    item = -1 - b
    dx, dy = from_closest_point(items, item, pos[a, body.X], pos[a, body.Y])
    return dx, dy, pos[a, body.RADIUS] + items[item, shape.RADIUS], pos[a, body.RADIUS]


@lean_kernel
def fallback_normal(a: int, b: int) -> tuple[float, float]:
    """A unit normal for two discs with the same centre, computed from their ids."""
    mixed = (a * 40503 + b * 30011 + 7919) % 65521
    u = mixed % 255 / 255.0  # tan of a quarter of the angle from -pi/2 to pi/2
    u = 2.0 * u - 1.0
    d = 1.0 + u * u
    x = 2.0 * u / d
    y = (1.0 - u * u) / d
    return (x, y) if (mixed // 255) % 2 == 0 else (x, -y)


@lean_kernel
def time_of_impact(
    px: float,
    py: float,
    vx: float,
    vy: float,
    distance: float,
    slack: float,
    threshold: float,
    remaining: float,
) -> float:
    """Seconds until a point at p with velocity v is `distance` from the origin, or inf.

    Only times in [0, remaining] count. An approach slower than `threshold` (m/s along the normal)
    may come nearer by `slack` in m. If the point is already that near, the time is 0.
    """
    pv = px * vx + py * vy
    if pv >= 0.0:
        return np.inf
    pp = px * px + py * py
    f = pp - distance * distance
    if f + 2.0 * pv * remaining > 0.0:
        return np.inf
    vv = vx * vx + vy * vy
    if f > 0.0:
        discriminant = pv * pv - vv * f
        if discriminant <= 0.0:
            return np.inf
        root = sqrt(discriminant)
        if root >= threshold * distance:
            s = f / (root - pv)
            return s if s <= remaining else np.inf
    elif pp == 0.0 or -pv >= threshold * sqrt(pp):
        return 0.0
    nearer = distance - slack
    f = pp - nearer * nearer
    if f <= 0.0:
        return 0.0 if pp > 0.0 and -pv * remaining > CREEP * slack * sqrt(pp) else np.inf
    if f + 2.0 * pv * remaining > 0.0:
        return np.inf
    discriminant = pv * pv - vv * f
    if discriminant <= 0.0:
        return np.inf
    s = f / (sqrt(discriminant) - pv)
    return s if s <= remaining else np.inf


@lean_kernel
def _time_of_impact_side(
    dx: float, dy: float, vx: float, vy: float, tx: float, ty: float, length: float,
    distance: float, slack: float, threshold: float, remaining: float,
) -> float:  # fmt: skip
    """`time_of_impact` for a wall without its ends; (dx, dy): place relative to its first end."""
    d = tx * dy - ty * dx
    approach = -(tx * vy - ty * vx)
    if d < 0.0 or (d == 0.0 and approach < 0.0):
        d = -d
        approach = -approach
    if approach <= 0.0:
        return np.inf
    gap = d - distance
    if approach < threshold:
        gap += slack
        if gap <= 0.0 and approach * remaining <= CREEP * slack:
            return np.inf
    s = gap / approach if gap > 0.0 else 0.0
    if s > remaining:
        return np.inf
    foot = (dx + vx * s) * tx + (dy + vy * s) * ty
    return s if 0.0 <= foot <= length else np.inf


@lean_kernel
def time_of_impact_wall(
    dx: float, dy: float, vx: float, vy: float, tx: float, ty: float, length: float,
    distance: float, slack: float, threshold: float, remaining: float,
) -> float:  # fmt: skip
    """`time_of_impact` for a wall including its ends; (dx, dy): place relative to its first end.

    (tx, ty): unit vector along the wall.
    """
    best = _time_of_impact_side(
        dx, dy, vx, vy, tx, ty, length, distance, slack, threshold, remaining
    )
    s = time_of_impact(dx, dy, vx, vy, distance, slack, threshold, remaining)
    if s < best and (dx + vx * s) * tx + (dy + vy * s) * ty < 0.0:
        best = s
    dx -= length * tx
    dy -= length * ty
    s = time_of_impact(dx, dy, vx, vy, distance, slack, threshold, remaining)
    if s < best and (dx + vx * s) * tx + (dy + vy * s) * ty > 0.0:
        best = s
    return best
