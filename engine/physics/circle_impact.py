"""Finds when a ball in free flight hits a circle.

Let q(s) be the ball's centre as seen from the circle's centre, v and a its velocity and
acceleration, and D the contact distance. The distance function is f(s) = |q(s)|^2 - D^2, in m^2:

    f' = 2 q.v        f'' = 2 (|v|^2 + q.a)        f''' = 6 v.a - 2 k q.a

Every search here steps by the minorant of time_of_impact.py, which needs a lower bound of f'''.
"""

from math import sqrt
from typing import NamedTuple

from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.physics.flight import phi2, short_basis
from plinko.engine.physics.time_of_impact import (
    LEAST_X,
    MAX_STEPS,
    NEGLIGIBLE,
    NO_HIT,
    THIRD,
    halley_step,
    minorant_root,
    stays_positive,
)


class Motion(NamedTuple):
    """The state at the start of a free flight or of a search window; SI units."""

    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float
    k: float  # drag


@lean_kernel
def third_derivative_bound(va: float, aa: float, qa: float, k: float, horizon: float) -> float:
    """Lower bound, at most 0, of f''' on [0, horizon].

    va = v.a, aa = a.a, qa = q.a at s = 0. From a(s) = a e^(-ks) and the closed form of flight,

        v(s).a(s) = e^(-ks) (va + aa phi(s))           >= min(va, 0)
        q(s).a(s) = e^(-ks) (qa + va s + aa psi(s))    <= max(qa + max(va, 0) h + aa h^2 / 2, 0)

    for s up to the horizon h, since e^(-ks) <= 1, phi >= 0 and 0 <= psi <= s^2 / 2.
    """
    bound = 0.0
    if va < 0.0:
        bound = 6.0 * va
    if k > 0.0:
        rise = qa + 0.5 * aa * horizon * horizon
        if va > 0.0:
            rise += va * horizon
        if rise > 0.0:
            bound -= 2.0 * k * rise
    return bound


@lean_kernel
def third_derivative_size(va: float, aa: float, qa: float, k: float, horizon: float) -> float:
    """Upper bound of |f'''| on [0, horizon]; arguments as in `third_derivative_bound`."""
    size = 6.0 * (abs(va) + aa * horizon)
    if k > 0.0:
        size += 2.0 * k * (abs(qa) + (abs(va) + 0.5 * aa * horizon) * horizon)
    return size


@lean_kernel
def circle_search(
    motion: Motion,
    d2: float,
    horizon: float,
    best: float,
    s: float,
    f: float,
    fd: float,
    fdd: float,
    low3: float,
) -> float:
    """First s' in [s, min(horizon, best)] at which the ball enters the circle, or NO_HIT.

    `motion` is that at time 0, as seen from the circle's centre; d2 is D^2, and k times horizon at
    most SERIES_LIMIT. At s, f > 0, f' = fd and f'' = fdd; low3 is a lower bound of f''' on
    [0, horizon]. `best` only ends the search early. The root does not depend on it, so the order in
    which surfaces are searched does not matter.
    """
    return _first_root(motion, d2, False, horizon, best, s, f, fd, fdd, low3)


@lean_kernel
def _first_root(
    motion: Motion,
    scale: float,
    is_divided: bool,
    horizon: float,
    best: float,
    s: float,
    f: float,
    fd: float,
    fdd: float,
    low3: float,
) -> float:
    """The search of time_of_impact.py from s on: for the first root of f, or of g if `is_divided`.

    (f, fd, fdd) are f, f' and f'' at s, or g, g' and a lower bound of g''; low3 is a lower bound of
    f''', or 0 for g. `scale` is D^2, or g(0).

    The minorant holds on [s, s + h]. If it has no root there, the search moves to s + h. For f, h
    is doubled then, and after a step to a root it becomes the length of the step: as h shrinks, m
    tends to f''. For g, h is always the rest of the window.
    """
    qx, qy, vx, vy, ax, ay, k = motion
    qa = qx * ax + qy * ay
    size3 = third_derivative_size(vx * ax + vy * ay, ax * ax + ay * ay, qa, k, horizon)
    g0 = f
    enough = NEGLIGIBLE * scale
    h = horizon - s
    for _ in range(MAX_STEPS):
        m = fdd + low3 * h * THIRD
        step = halley_step(f, fd, m)
        if fd < 0.0 and (s + step == s or (is_divided and f * m < LEAST_X * (fd * fd))):
            step = minorant_root(f, fd, m)
        before = s
        if step == NO_HIT or step > h:
            if s + h >= horizon:
                return NO_HIT
            step = h  # no root within h: go to its end, and use a longer h next
            h = h + h
        elif _comes_near(f, fd, m, step, h, low3, size3, enough, is_divided):
            s = s + step
            return s if s <= best else NO_HIT
        elif not is_divided:
            h = step
        s = s + step
        if s > best:
            return NO_HIT
        if s == before:
            return s
        if is_divided:
            f, fd = _divided(motion, g0, qa, s)
            if f <= 0.0:
                return s
        else:
            f, fd, fdd = _distance(motion, scale, s)
            if f <= 0.0:
                return s
        if is_divided or h > horizon - s:
            h = horizon - s
            if h <= 0.0:
                return NO_HIT
    return s


@inner_kernel
def _distance(motion: Motion, d2: float, s: float) -> tuple[float, float, float]:
    """f, f' and f'' at s."""
    qx, qy, vx, vy, ax, ay, k = motion
    decay, phi, psi = short_basis(k, s)
    px = qx + vx * s + ax * psi
    py = qy + vy * s + ay * psi
    ux = vx + ax * phi
    uy = vy + ay * phi
    return (
        px * px + py * py - d2,
        2.0 * (px * ux + py * uy),
        2.0 * (ux * ux + uy * uy + decay * (px * ax + py * ay)),
    )


@lean_kernel
def _divided(motion: Motion, g0: float, qa: float, s: float) -> tuple[float, float]:
    """g and g' at s > 0.

    With w = v + a psi(s) / s, q(s) = q + s w, so g = 2 q.w + s |w|^2. Here c1 = psi(s) / s,
    c = c1 / s and c1' = 1 - k c1 - c.
    """
    _, _, vx, vy, ax, ay, k = motion
    c = 0.5
    if k > 0.0:
        c = phi2(k * s)
    c1 = s * c
    c1d = 1.0 - k * c1 - c
    wx = vx + ax * c1
    wy = vy + ay * c1
    ww = wx * wx + wy * wy
    g = g0 + 2.0 * qa * c1 + s * ww
    return g, 2.0 * qa * c1d + ww + 2.0 * s * c1d * (wx * ax + wy * ay)


@lean_kernel
def _comes_near(
    f: float,
    fd: float,
    m: float,
    step: float,
    h: float,
    low3: float,
    size3: float,
    enough: float,
    is_divided: bool,
) -> bool:
    """Whether |f|, or |g|, is at most `enough` at the end of a step.

    It has two parts: what the minorant leaves, which is 0 at its root and |m x| step^2 / 4 after
    Halley's step, with x = m f / fd^2; and the difference between the function and the minorant.

    f: the first is at most f x^2 / 2 for x <= 1/2, and the second is at most
    (size3 step - low3 h) step^2 / 6; each must be at most half of `enough`.
    g: the first is at most |m| step^2 for x >= -4, and the second (|m| + size3 / 3) step^2 / 2. As
    |m| is at most size3 / 3, their sum is at most 2 size3 / 3 step^2.
    """
    if is_divided:
        return 2.0 * (size3 * THIRD) * step * step <= enough
    square = fd * fd
    fm = f * m
    if (size3 * step - low3 * h) * step * step > 3.0 * enough:
        return False
    return f * fm * fm <= enough * square * square


@inner_kernel
def circle_hit_again(
    qx: float,
    qy: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    k: float,
    horizon: float,
    best: float,
) -> float:
    """First s in (0, min(horizon, best)] at which a ball hits again a circle it touches at s = 0.

    f has a root at 0, so the search is for a root of g(s) = f(s) / s. g is the mean of f' over
    [0, s], so g'' >= min(f''') / 3. Returns 0 if the ball does not leave the circle, that is if
    g(0) <= 0 and g'(0) <= 0.
    """
    g0 = 2.0 * (qx * vx + qy * vy)
    return _search_again(Motion(qx, qy, vx, vy, ax, ay, k), g0, horizon, best)


@inner_kernel
def _search_again(motion: Motion, g0: float, horizon: float, best: float) -> float:
    """`circle_hit_again` for a known g(0), which is 0 if the ball has no speed off the circle."""
    qx, qy, vx, vy, ax, ay, k = motion
    qa = qx * ax + qy * ay
    m = THIRD * third_derivative_bound(vx * ax + vy * ay, ax * ax + ay * ay, qa, k, horizon)
    g = max(g0, 0.0)
    gd = vx * vx + vy * vy + qa
    if g == 0.0 and gd <= 0.0:
        return 0.0
    if g > 0.0 and stays_positive(g, 0.5 * gd, 0.5 * m, min(horizon, best)):
        return NO_HIT
    return _first_root(motion, g, True, horizon, best, 0.0, g, gd, m, 0.0)


@inner_kernel
def circle_hit_after_lifting(
    qx: float,
    qy: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    k: float,
    d2: float,
    horizon: float,
    best: float,
) -> float:
    """First s in (0, min(horizon, best)] at which a ball hits again a circle that it lifts off.

    The ball moves along the circle and is not pressed on: f = f' = 0 <= f''. If f'' is zero within
    rounding, the third derivative decides, as for a ball that has rolled off.
    """
    if vx * vx + vy * vy + qx * ax + qy * ay > 0.0:
        return _search_again(Motion(qx, qy, vx, vy, ax, ay, k), 0.0, horizon, best)
    return circle_hit_after_leaving(qx, qy, vx, vy, ax, ay, k, d2, horizon, best)


@inner_kernel
def circle_hit_after_leaving(
    qx: float,
    qy: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    k: float,
    d2: float,
    horizon: float,
    best: float,
) -> float:
    """First s in (0, min(horizon, best)] at which a ball hits again a circle that it rolled off.

    Where the normal force becomes zero, f = f' = f'' = 0, so q.a = -|v|^2 and f(s) = s^3 h(s) with

        h(0) = f'''(0) / 6 = v.a + k |v|^2 / 3        h(s) >= h(0) + s min(f'''') / 24

    The second line bounds a time before which there is no root; the search starts there. For the
    bound, f'''' = 6 a.a - 8 k v.a + 2 k^2 q.a >= -8 k |v||a| - 2 k^2 |q||a|. h(0) is proportional
    to the rate at which the force becomes zero. If it is zero within rounding too, f begins as
    a.a s^4 / 4, and the ball does not hit the circle within this window.
    """
    va = vx * ax + vy * ay
    vv = vx * vx + vy * vy
    h0 = va + k * vv / 3.0
    if h0 <= 0.0:
        return NO_HIT
    if k == 0.0:
        return NO_HIT  # f'''' = 6 a.a >= 0 at all times
    aa = ax * ax + ay * ay
    a = sqrt(aa)
    speed = sqrt(vv) + a * horizon
    low4 = -8.0 * k * speed * a - 2.0 * k * k * a * (sqrt(d2) + speed * horizon)
    s = -24.0 * h0 / low4
    if s >= horizon or s > best:
        return NO_HIT
    motion = Motion(qx, qy, vx, vy, ax, ay, k)
    f, fd, fdd = _distance(motion, d2, s)
    if f <= 0.0:
        return s
    low3 = third_derivative_bound(va, aa, qx * ax + qy * ay, k, horizon)
    return circle_search(motion, d2, horizon, best, s, f, fd, fdd, low3)
