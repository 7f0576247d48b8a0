"""Roots to all digits: Newton's method in a bracket, and the first downward zero of a series."""

from collections.abc import Callable, Sequence

from tools.oracle.scene import Real

_MAX_STEPS = 2000
_MAX_DEPTH = 400


class OracleError(RuntimeError):
    """The oracle cannot guarantee an answer."""


def bracketed(
    function: Callable[[Real], tuple[Real, Real]], low: Real, high: Real, eps: Real
) -> Real:
    """The root in [low, high] of a function with opposite signs there, Newton with bisection.

    `function` returns value and derivative. Stops when a Newton step inside the bracket is below
    sqrt(eps) of the root: the step is applied, and the next would be of the order of eps.
    """
    f_low = function(low)[0]
    f_high = function(high)[0]
    if f_low == 0:
        return low
    if f_high == 0:
        return high
    if (f_low > 0) == (f_high > 0):
        raise OracleError("a bracket whose ends have the same sign")
    falling = f_low > 0
    small = eps**0.6
    x = (low + high) / 2
    for _ in range(_MAX_STEPS):
        value, slope = function(x)
        if value == 0:
            return x
        if (value > 0) == falling:
            low = x
        else:
            high = x
        following = x - value / slope if slope != 0 else low
        if not low < following < high:
            # Newton left the bracket: bisect, unless the bracket is down to rounding.
            following = (low + high) / 2
            if abs(high - low) <= eps * abs(high):
                return following
        elif abs(following - x) <= small * abs(following):
            return following
        x = following
    raise OracleError("no convergence in a bracket")


def horner(series: Sequence[Real], x: Real) -> tuple[Real, Real]:
    """Value and derivative of the power series (lowest power first) at x."""
    value = derivative = series[-1] * 0
    for coefficient in reversed(series):
        derivative = derivative * x + value
        value = value * x + coefficient
    return value, derivative


def deflated(series: Sequence[Real], tiny: Real) -> list[Real]:
    """The series divided by its power of x: a root at the start is not an event."""
    start = 0
    while start < len(series) and abs(series[start]) < tiny:
        start += 1
    return list(series[start:])


def first_fall(series: Sequence[Real], eps: Real) -> Real | None:
    """Smallest x in (0, 1] where the series goes from positive to not positive, or None.

    Bisection with proof: on an interval with middle m and half width r the series stays within
    |p'(m)| r + B r^2 / 2 of p(m) and its slope within B r of p'(m), B >= |p''|. An interval is
    dropped when it cannot hold a zero, and a root is taken only where the slope is negative.
    """
    if len(series) < 2:
        return None
    bend = sum((abs(c) * (j * (j - 1)) for j, c in enumerate(series)), start=series[0] * 0)

    def search(low: Real, high: Real, depth: int) -> Real | None:
        middle, half = (low + high) / 2, (high - low) / 2
        value, slope = horner(series, middle)
        if abs(value) > abs(slope) * half + bend * half * half / 2:
            return None
        if abs(slope) > bend * half:
            if slope > 0 or horner(series, low)[0] <= 0 or horner(series, high)[0] > 0:
                return None
            return bracketed(lambda x: horner(series, x), low, high, eps)
        if depth > _MAX_DEPTH:
            raise OracleError("a contact event: bisection cannot decide whether it happens")
        found = search(low, middle, depth + 1)
        return found if found is not None else search(middle, high, depth + 1)

    return search(series[0] * 0, series[0] * 0 + 1, 0)
