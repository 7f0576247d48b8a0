"""Finds when a ball in free flight hits a straight line, from its distance to the line.

The distance is h(s) = h + hd s + hdd psi(s), in m, with psi of flight.py, hd in m/s and hdd in
m/s^2. Its second derivative hdd e^(-ks) keeps its sign.
"""

from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.physics.flight import SERIES_LIMIT, phi2, short_basis
from plinko.engine.physics.time_of_impact import MAX_STEPS, NO_HIT, minorant_root, stays_positive


@inner_kernel
def line_hit(
    h: float, hd: float, hdd: float, k: float, horizon: float, best: float, near: float
) -> float:
    """First s in [0, min(horizon, best)] at which h(s) turns negative, or NO_HIT.

    h'' keeps its sign during a flight, so h turns negative at most once. With h <= 0 at the start,
    the result is 0 if the ball moves further in, and otherwise the hit after it has come out. A
    ball that touches the line may be inside it by a rounding error, at most `near`, and turn back
    before it is out. Then the root at 0 is divided out. It may also come from further inside, and
    turn back so near to the line that rounding hides whether it has been out. That counts as out.
    """
    if h > 0.0:
        return _line_search(h, hd, hdd, k, horizon, best)
    if hd < 0.0:
        return 0.0
    if hdd >= 0.0:
        return NO_HIT
    exit_time = _line_exit(h, hd, hdd, k, min(horizon, best))
    if exit_time == NO_HIT:
        if h >= -near:
            return line_hit_again(hd, hdd, k, horizon, best)
        exit_time = _line_exit(h + near, hd, hdd, k, min(horizon, best))
        if exit_time == NO_HIT:
            return NO_HIT
    decay, phi, _ = short_basis(k, exit_time)
    rest = min(horizon, best) - exit_time
    again = line_hit_again(hd + hdd * phi, hdd * decay, k, rest, rest)
    return NO_HIT if again == NO_HIT else exit_time + again


@lean_kernel
def _line_search(h: float, hd: float, hdd: float, k: float, horizon: float, best: float) -> float:
    """`line_hit` for h > 0."""
    m = hdd
    if hdd > 0.0:
        m = hdd * (1.0 - k * horizon)  # h'' = hdd e^(-ks) >= hdd (1 - ks)
    s = 0.0
    a = h
    b = hd
    for _ in range(MAX_STEPS):
        if stays_positive(a, 0.5 * b, 0.5 * m, horizon - s):
            return NO_HIT
        step = minorant_root(a, b, m)
        before = s
        s = s + step
        if step == NO_HIT or s > horizon or s > best:
            return NO_HIT
        if s == before:
            return s
        _, phi, psi = short_basis(k, s)
        a = h + hd * s + hdd * psi
        if a <= 0.0:
            return s
        b = hd + hdd * phi
    return s


@lean_kernel
def _line_exit(h: float, hd: float, hdd: float, k: float, limit: float) -> float:
    """First s <= limit with h(s) >= 0 for h < 0, hd > 0, hdd < 0, or NO_HIT.

    h is concave, so it lies below its tangents, and Newton steps from the left never pass the root.
    """
    s = 0.0
    a = h
    b = hd
    for _ in range(MAX_STEPS):
        if b <= 0.0:
            return NO_HIT
        before = s
        s = s - a / b
        if s > limit:
            return NO_HIT
        _, phi, psi = short_basis(k, s)
        a = h + hd * s + hdd * psi
        if a >= 0.0 or s == before:
            return s
        b = hd + hdd * phi
    return NO_HIT


@inner_kernel
def line_hit_again(hd: float, hdd: float, k: float, horizon: float, best: float) -> float:
    """First s in (0, min(horizon, best)] at which a ball hits again a line it touches at s = 0.

    Dividing out the root at 0 leaves hd + hdd psi(s) / s = 0. psi(s) / s is concave and at most
    s / 2, so Newton steps from -2 hd / hdd on stay left of the root.
    """
    if hd <= 0.0:
        return 0.0 if hdd < 0.0 or hd < 0.0 else NO_HIT
    if hdd >= 0.0:
        return NO_HIT
    target = -hd / hdd
    s = 2.0 * target
    if k == 0.0:
        return s if s <= horizon and s <= best else NO_HIT
    for _ in range(MAX_STEPS):
        if s > horizon or s > best or k * s > SERIES_LIMIT:
            return NO_HIT
        c = phi2(k * s)
        gap = target - s * c
        if gap <= 0.0:
            return s
        before = s
        s = s + gap / (1.0 - k * s * c - c)
        if s == before:
            return s
    return s
