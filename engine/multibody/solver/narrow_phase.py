"""When a moving disc meets another, a peg or a wall, and how near it is; straight motion."""

from math import sqrt

import numpy as np

from engine.jit.decorator import lean_kernel
from engine.multibody.solver.layout import LENGTH, TX, TY, X1, Y1, Floats

SLACK = 0.005
"""Overlap, in radii of the smaller disc, up to which a slow approach is left to the contact solver.
Twice of it must stay below the one per cent that piles may show; at zero, every ball at rest would
be an impact in each substep."""

CREEP = 1.0e-3
"""An approach that covers less than this part of the allowed overlap is none: rounding."""


@lean_kernel
def nearest(items: Floats, item: int, x: float, y: float) -> tuple[float, float]:
    """Vector in m from the nearest point of an item's axis to (x, y)."""
    dx = x - items[item, X1]
    dy = y - items[item, Y1]
    length = items[item, LENGTH]
    if length > 0.0:
        along = dx * items[item, TX] + dy * items[item, TY]
        if along > 0.0:
            along = min(along, length)
            dx -= along * items[item, TX]
            dy -= along * items[item, TY]
    return dx, dy


@lean_kernel
def meets(
    px: float,
    py: float,
    vx: float,
    vy: float,
    reach: float,
    slack: float,
    threshold: float,
    rest: float,
) -> float:
    """Seconds until a point at p with velocity v comes as near the origin as `reach`, or inf.

    Looked for in [0, rest]. Approaches slower than `threshold` (m/s along the normal) may come
    nearer by `slack`, in m; those that are as near already meet at once.
    """
    pv = px * vx + py * vy
    if pv >= 0.0:
        return np.inf
    pp = px * px + py * py
    f = pp - reach * reach
    if f + 2.0 * pv * rest > 0.0:
        return np.inf
    vv = vx * vx + vy * vy
    if f > 0.0:
        discriminant = pv * pv - vv * f
        if discriminant <= 0.0:
            return np.inf
        root = sqrt(discriminant)
        if root >= threshold * reach:
            s = f / (root - pv)
            return s if s <= rest else np.inf
    elif pp == 0.0 or -pv >= threshold * sqrt(pp):
        return 0.0
    nearer = reach - slack
    f = pp - nearer * nearer
    if f <= 0.0:
        return 0.0 if pp > 0.0 and -pv * rest > CREEP * slack * sqrt(pp) else np.inf
    if f + 2.0 * pv * rest > 0.0:
        return np.inf
    discriminant = pv * pv - vv * f
    if discriminant <= 0.0:
        return np.inf
    s = f / (sqrt(discriminant) - pv)
    return s if s <= rest else np.inf


@lean_kernel
def _meets_side(
    dx: float, dy: float, vx: float, vy: float, tx: float, ty: float, length: float,
    reach: float, slack: float, threshold: float, rest: float,
) -> float:  # fmt: skip
    """`meets` for the inside of a wall; (dx, dy) is seen from its first end."""
    d = tx * dy - ty * dx
    approach = -(tx * vy - ty * vx)
    if d < 0.0 or (d == 0.0 and approach < 0.0):
        d = -d
        approach = -approach
    if approach <= 0.0:
        return np.inf
    gap = d - reach
    if approach < threshold:
        gap += slack
        if gap <= 0.0 and approach * rest <= CREEP * slack:
            return np.inf
    s = gap / approach if gap > 0.0 else 0.0
    if s > rest:
        return np.inf
    foot = (dx + vx * s) * tx + (dy + vy * s) * ty
    return s if 0.0 <= foot <= length else np.inf


@lean_kernel
def meets_wall(
    dx: float, dy: float, vx: float, vy: float, tx: float, ty: float, length: float,
    reach: float, slack: float, threshold: float, rest: float,
) -> float:  # fmt: skip
    """`meets` for a wall of that direction and length, its ends included; (dx, dy) is where the
    disc is, seen from the wall's first end."""
    best = _meets_side(dx, dy, vx, vy, tx, ty, length, reach, slack, threshold, rest)
    s = meets(dx, dy, vx, vy, reach, slack, threshold, rest)
    if s < best and (dx + vx * s) * tx + (dy + vy * s) * ty < 0.0:
        best = s
    dx -= length * tx
    dy -= length * ty
    s = meets(dx, dy, vx, vy, reach, slack, threshold, rest)
    if s < best and (dx + vx * s) * tx + (dy + vy * s) * ty > 0.0:
        best = s
    return best
