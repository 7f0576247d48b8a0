"""Bounds how far to the sides a ball can fly before it reaches the bins, from its energy.

A ball that left its last contact at a height h below the start had a speed of at most sqrt(2 g h)
there. At a depth d below the start, above or below that contact, it is at most 2 sqrt(h d) to the
side: the envelope of all throws with this speed is a parabola. Linear drag only shortens a throw,
because a path with drag lies below the parabola without it. The bound therefore depends neither on
gravity nor on restitution and friction.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.checks.obstacles import Floats, Obstacles

SAMPLES: Final = 1025
"""Depths at which the bound is exact; between them it is a chord of a convex curve, hence safe."""


def side_limits(obs: Obstacles, starts: Floats, top: float, bottom: float) -> tuple[float, float]:
    """Smallest and largest x in m at which a ball's centre can cross the height `bottom`.

    starts: x of the starts in m, all at height `top`, shape (n,). The bound ignores that obstacles
    shield each other, and assumes each contact at the worst point of the disc or wall.
    """
    x, y, half, low = _bodies(obs)
    # As a function of u = sqrt(depth), the bound from each contact, x + 2 sqrt(h) u, is a line.
    u = np.sqrt(np.linspace(0.0, bottom - top, SAMPLES))
    right = np.full(SAMPLES, float(np.max(starts)))
    left = np.full(SAMPLES, float(np.min(starts)))
    lowest = np.clip(y + low, top, bottom)
    u_lowest = np.sqrt(lowest - top)
    untouched: npt.NDArray[np.bool_] = y + low > top
    untouched &= y - low < bottom
    while True:
        touched = untouched & (x - half <= np.interp(u_lowest, u, right))
        touched &= x + half >= np.interp(u_lowest, u, left)
        if not touched.any():
            return float(left[-1]), float(right[-1])
        untouched &= ~touched
        for i in np.flatnonzero(touched):
            throw = 2.0 * u_lowest[i] * u
            right = np.maximum(right, x[i] + half[i] + throw)
            left = np.minimum(left, x[i] - half[i] - throw)


def _bodies(obs: Obstacles) -> tuple[Floats, Floats, Floats, Floats]:
    """Bounding boxes of discs and walls' strips: centre x and y, half width and half height, m."""
    return (
        np.concatenate((obs.x, 0.5 * (obs.x1 + obs.x2))),
        np.concatenate((obs.y, 0.5 * (obs.y1 + obs.y2))),
        np.concatenate((obs.reach, 0.5 * np.abs(obs.x2 - obs.x1) + obs.radius)),
        np.concatenate((obs.reach, 0.5 * np.abs(obs.y2 - obs.y1) + obs.radius)),
    )
