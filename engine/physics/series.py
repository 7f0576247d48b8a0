"""Polynomials in time: their values, and the first instant at which one turns negative."""

import numpy as np
import numpy.typing as npt

from engine.jit.decorator import inner_kernel
from engine.physics.time_of_impact import MAX_STEPS, NO_HIT, minorant_root

Series = npt.NDArray[np.float64]


@inner_kernel
def value(c: Series, s: float) -> float:
    """Sum of c[i] s^i."""
    total = c[-1]
    for i in range(len(c) - 2, -1, -1):
        total = total * s + c[i]
    return float(total)


@inner_kernel
def sum_of_magnitudes(c: Series, first: int, s: float) -> float:
    """Sum over i >= first of |c[i]| s^(i - first): a bound of that part on [0, s]."""
    total = 0.0
    for i in range(len(c) - 1, first - 1, -1):
        total = total * s + abs(c[i])
    return total


@inner_kernel
def first_zero(c: Series, skip: int, horizon: float) -> float:
    """First s in [0, horizon] at which a polynomial that starts positive reaches zero, or NO_HIT.

    The first `skip` coefficients are known to be zero: that many roots at s = 0 are divided out.
    0 if what is left starts at or below zero. The minorant rests on
    f''(s + d) >= f''(s) - d sup|f'''| with the bound of |f'''| taken from the coefficients.
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
            step = h  # no root within the trusted part: go to its end and trust more
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
