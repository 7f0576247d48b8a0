"""The first instant at which a ball in free flight touches a circle or a line.

The distance function of a contact is f(s) > 0 before it and f(s) = 0 at it. Every search here
rests on one bound: if f''' >= l on [s, s + h] and l <= 0, then f(s + d) >= f + f' d + m d^2 / 2
with m = f'' + l h / 3 for d <= h, so f has no root before this minorant has one. Stepping to the
minorant's root, or less far, can neither skip a contact nor report one that lies behind; it
converges from the left, and cubically because h shrinks with the steps. `docs/physics.md` derives
the bounds.

Right after an impact f(0) = 0 is known; the root there is divided out (f(s) / s is searched)
instead of being dodged with an epsilon. circle_impact.py and line_impact.py have the searches.
"""

from math import sqrt

from engine.jit.decorator import inner_kernel, lean_kernel

NO_HIT = -1.0
# A search that is still moving after this many steps sits within rounding of its root. Seen in
# practice: at most 12.
MAX_STEPS = 100

THIRD = 1.0 / 3.0
SIXTH = 1.0 / 6.0
NEGLIGIBLE = 2.0**-54
"""Part of D^2 (or of the normal speed) below which what a step may have missed is not looked at
again: half of what rounding leaves of f itself."""


@inner_kernel
def minorant_root(f: float, fd: float, m: float) -> float:
    """Smallest d > 0 with f + fd d + m d^2 / 2 = 0 for f > 0, or NO_HIT.

    Of the two forms of the root the one without cancellation: with the other, a ball that moves off
    a surface it all but touches would come back to it at a time that is mostly rounding.
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
    """At most the smallest d > 0 with f + fd d + m d^2 / 2 = 0 for f > 0; NO_HIT if there is none.

    Where f falls it is Halley's step, which needs no square root. It ends short of the root
    because sqrt(1 - 2x) <= 1 - x, for x = m f / fd^2; the minorant is f x^2 / (2 - x)^2 there.
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
    """Whether f + 2 b d + c d^2 > 0 on all of [0, h]; no square root taken.

    All cases are computed and none is branched on: a processor guesses such branches badly.
    """
    e = b + c * h
    dips = (c > 0.0) & (e > 0.0)  # the least value is not at the end
    at_end = f + h * (b + e) > 0.0
    at_dip = (b >= 0.0) | (b * b < c * f)
    return bool((f > 0.0) & ((dips & at_dip) | ((not dips) & at_end)))
