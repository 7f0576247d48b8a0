"""The steps by which all searches for the first contact of a ball in free flight proceed.

The distance function of a contact is f(s) > 0 before the contact and f(s) = 0 at it. All searches
use one bound. If f''' >= l on [s, s + h] and l <= 0, then Taylor's theorem gives, for 0 <= d <= h,

    f(s + d) >= f + f' d + f'' d^2 / 2 + l d^3 / 6 >= f + f' d + m d^2 / 2        m = f'' + l h / 3

This parabola is the minorant: f has no root before the minorant's first root. A step to that root,
or less far, cannot skip a contact, and as it starts before the contact, it cannot report one behind
the ball. The steps converge from the left, and cubically because h shrinks with them.
`docs/physics.md` derives the bounds l.

Right after an impact, f(0) = 0 is known. That root is divided out (the search is for a root of
f(s) / s), not skipped by an epsilon. circle_impact.py and line_impact.py have the searches.
"""

from math import sqrt

from engine.jit.decorator import inner_kernel, lean_kernel

NO_HIT = -1.0
# A search that still moves after this many steps is within rounding of its root. The most steps
# seen are 12.
MAX_STEPS = 100

THIRD = 1.0 / 3.0
SIXTH = 1.0 / 6.0
NEGLIGIBLE = 2.0**-54
"""Relative to D^2 (or the normal speed): a step that leaves |f| below this ends the search. It is
half of the rounding error of f itself."""


@inner_kernel
def minorant_root(f: float, fd: float, m: float) -> float:
    """Smallest d > 0 with f + fd d + m d^2 / 2 = 0 for f > 0, or NO_HIT.

    The root has two forms; this takes the one without cancellation. With the other, a ball that
    moves off a surface from very near would return to it at a time that is mostly rounding error.
    """
    discriminant = fd * fd - 2.0 * m * f
    if discriminant < 0.0:
        return NO_HIT
    if fd > 0.0:
        return (fd + sqrt(discriminant)) / -m if m < 0.0 else NO_HIT
    divisor = sqrt(discriminant) - fd
    if divisor <= 0.0:
        return NO_HIT
    return 2.0 * f / divisor


@inner_kernel
def halley_step(f: float, fd: float, m: float) -> float:
    """A step that is at most the smallest d > 0 with f + fd d + m d^2 / 2 = 0; f > 0. Or NO_HIT.

    Where f falls, it is Halley's step, which needs no square root. With x = m f / fd^2 it ends
    before the root, because sqrt(1 - 2x) <= 1 - x; the minorant is f x^2 / (2 - x)^2 there.
    """
    if fd >= 0.0:
        return minorant_root(f, fd, m)
    square = fd * fd
    fm = f * m
    if square < fm + fm:
        return NO_HIT
    return 2.0 * f * fd / (fm - (square + square))


@lean_kernel
def stays_positive(f: float, b: float, c: float, h: float) -> bool:
    """Whether f + 2 b d + c d^2 > 0 on all of [0, h], without a square root.

    All cases are computed without branches, which a processor would often predict wrongly.
    """
    e = b + c * h
    dips = (c > 0.0) & (e > 0.0)  # the minimum is before the end
    at_end = f + h * (b + e) > 0.0
    at_dip = (b >= 0.0) | (b * b < c * f)
    return bool((f > 0.0) & ((dips & at_dip) | ((not dips) & at_end)))
