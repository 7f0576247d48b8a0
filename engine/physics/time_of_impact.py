"""The search for the first contact of a ball in free flight: its steps, and why it is right.

The distance function of a contact is f(s) > 0 before the contact and f(s) = 0 at it. All searches
use one bound. If f''' >= l on [s, s + h] and l <= 0, then Taylor's theorem gives, for 0 <= d <= h,

    f(s + d) >= f + f' d + f'' d^2 / 2 + l d^3 / 6 >= f + f' d + m d^2 / 2        m = f'' + l h / 3

This parabola is the minorant. Right after an impact, f(0) = 0 is known. That root is divided out,
not skipped by an epsilon: the search is for a root of g(s) = f(s) / s, whose minorant has the
constant m = min(f''') / 3, for any h. From here on, f stands for either function.

    no root is passed    f has no root before the minorant's first root, and a step ends at that
                         root or before it. So the search stays left of the first root, and cannot
                         report one behind the ball.

    the search ends      While f >= c > 0, the minorant's root is at least
                         2 c / (|f'| + sqrt(f'^2 + 2 |m| c)) away, which does not shrink to zero. A
                         step is at least two thirds of it, with one exception: Halley's step where
                         f' is almost zero and m negative (`halley_step`). For g the root itself is
                         the step there. For f, h becomes as short as the step, so that m tends to
                         f'': if f'' > 0 the next minorant has no root within h, and h doubles; if
                         not, f falls faster and faster. So the search leaves the window, or f falls
                         below every c. At a simple root the steps converge quadratically, and
                         cubically where h shrinks with them.

    what it returns      A time s at which f is zero within rounding: f(s) <= 0 was computed, left
                         of the root; or the bounds of f prove |f| <= `enough`, half of its
                         rounding; or the way to the minorant's root is lost in the rounding of s.
                         Only a search that takes MAX_STEPS steps returns a time before the root. No
                         such search is known, and the check of each impact (`rebound` in
                         engine/exact/free_flight.py) would find it.

`docs/physics.md` derives the bounds l. circle_impact.py and line_impact.py have the searches.
"""

from math import sqrt

from plinko.engine.jit.decorator import inner_kernel, lean_kernel

NO_HIT = -1.0

MAX_STEPS = 1000
"""Steps of a search, at most. The most on presets are 17. Steps towards a minimum that nearly
touches zero shrink, so that more are needed there."""

LEAST_X = -4.0
"""x of `halley_step` for which its step is two thirds of the minorant's root, as at x = 1/2."""

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

    Where f falls, it is Halley's step, which needs no square root. With x = m f / fd^2, the
    minorant at d = u f / |fd| is f (1 - u + x u^2 / 2). Its root is u = 2 / (1 + sqrt(1 - 2x)), and
    Halley's step is u = 2 / (2 - x), which is less, because sqrt(1 - 2x) <= 1 - x. The minorant is
    f x^2 / (2 - x)^2 = |m x| d^2 / 4 there. Below x = LEAST_X the step is less than two thirds of
    the root, and for x to minus infinity nothing of it.
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
