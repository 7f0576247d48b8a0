"""Polynomials in time: values, bounds, and the first zero."""

import numpy as np
import numpy.typing as npt

from plinko.engine.jit.decorator import inner_kernel
from plinko.engine.physics.time_of_impact import MAX_STEPS, NO_HIT, minorant_root

Series = npt.NDArray[np.float64]


@inner_kernel
def value(c: Series, s: float) -> float:
    """Sum over i of c[i] s^i."""
    total = c[-1]
    for i in range(len(c) - 2, -1, -1):
        total = total * s + c[i]
    return float(total)


@inner_kernel
def sum_of_magnitudes(c: Series, first: int, s: float) -> float:
    """Sum over i >= first of |c[i]| s^(i - first): a bound of that part of the series on [0, s]."""
    total = 0.0
    for i in range(len(c) - 1, first - 1, -1):
        total = total * s + abs(c[i])
    return total


@inner_kernel
def first_zero(c: Series, skip: int, horizon: float) -> float:
    """First s in [0, horizon] at which a polynomial that starts positive reaches zero, or NO_HIT.

    The first `skip` coefficients are known to be zero, and s^skip is divided out. Returns 0 if the
    quotient is not positive at s = 0. The search is that of time_of_impact.py: its minorant follows
    from f''(s + d) >= f''(s) - d sup|f'''|, where the coefficients bound |f'''| on [0, horizon].
    """
    n = len(c)
    if not c[skip] > 0.0:
        return 0.0
    if c[skip] > horizon * sum_of_magnitudes(c, skip + 1, horizon):
        return NO_HIT
    third = 0.0
    for i in range(n - 1, skip + 2, -1):
        j = i - skip
        third = third * horizon + j * (j - 1) * (j - 2) * abs(c[i])
    s = 0.0
    h = horizon
    for _ in range(MAX_STEPS):
        f = 0.0
        fd = 0.0
        half_fdd = 0.0
        for i in range(n - 1, skip - 1, -1):
            half_fdd = half_fdd * s + fd
            fd = fd * s + f
            f = f * s + c[i]
        if f <= 0.0:
            return s
        step = minorant_root(f, fd, 2.0 * half_fdd - third * h)
        if step == NO_HIT or step > h:
            if s + h >= horizon:
                return NO_HIT
            step = h  # no root within h: go to its end, and use a longer h next
            h = h + h
        else:
            h = step
        before = s
        s = s + step
        if s == before:
            return s
        if h > horizon - s:
            h = horizon - s
            if h <= 0.0:
                return NO_HIT
    return s
