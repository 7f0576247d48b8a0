"""Finds in double precision which surfaces a flight may touch, and not before when.

This is a screen: it only excludes surfaces, and ball arithmetic decides about the others. Each
surface is enlarged by a margin, a hundred thousand times the rounding of float64 here, and by the
errors of the ball's own enclosure. A ball that does not touch the enlarged surface does not touch
the true one.

The search steps by minorants of the distance as in engine/physics/time_of_impact.py, but by other
code, which takes the state at the start of each window as given.
"""

from math import sqrt

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, kernel
from plinko.engine.physics.array_types import Floats, Ints
from plinko.engine.physics.flight import SERIES_LIMIT, basis, short_basis

MARGIN = 1e-9
"""Relative to the square of the board's size: added to the square of a contact distance."""

NEVER = np.inf

_MOST_STEPS = 40
_MOST_WINDOWS = 100_000
_SHORT = 1.0 - 1e-9
"""Factor on each step, so that rounding does not carry it past the parabola's root."""


@inner_kernel
def _root(f: float, fd: float, m: float) -> float:
    """First d > 0 with f + fd d + m d^2 / 2 = 0, or NEVER; f > 0."""
    square = fd * fd - 2.0 * m * f
    if square < 0.0:
        return np.inf
    if fd > 0.0:
        return (fd + sqrt(square)) / -m if m < 0.0 else np.inf
    down = sqrt(square) - fd
    return 2.0 * f / down if down > 0.0 else np.inf


@inner_kernel
def _circle_reach(
    qx: float, qy: float, vx: float, vy: float, ax: float, ay: float, k: float, h: float,
    square: float, near: float,
) -> float:  # fmt: skip
    """A time until which |q(s)|^2 > square, NEVER if that holds for all of h.

    The search ends as soon as |q|^2 - square is at most `near`.
    """
    va = vx * ax + vy * ay
    aa = ax * ax + ay * ay
    low3 = 6.0 * min(va, 0.0)  # a lower bound of f''' = 6 v.a - 2 k q.a
    if k > 0.0:
        rise = qx * ax + qy * ay + 0.5 * aa * h * h + max(va, 0.0) * h
        low3 -= 2.0 * k * max(rise, 0.0)
    s = 0.0
    px, py, ux, uy, decay = qx, qy, vx, vy, 1.0
    for _ in range(_MOST_STEPS):
        f = px * px + py * py - square
        if f <= near:
            break
        fd = 2.0 * (px * ux + py * uy)
        fdd = 2.0 * (ux * ux + uy * uy + decay * (px * ax + py * ay))
        step = _root(f, fd, fdd + low3 * (h - s) / 3.0) * _SHORT
        if step > h - s:
            return np.inf
        s += step
        decay, phi, psi = short_basis(k, s)
        px, py = qx + vx * s + ax * psi, qy + vy * s + ay * psi
        ux, uy = vx + ax * phi, vy + ay * phi
    return s


@inner_kernel
def _line_reach(
    gap: float, rate: float, pull: float, k: float, h: float, near: float
) -> float:  # fmt: skip
    """A time until which gap + rate s + pull psi(s) > 0, NEVER if that holds for all of h."""
    s = 0.0
    value, slope, bend = gap, rate, pull
    for _ in range(_MOST_STEPS):
        if value <= near:
            break
        step = _root(value, slope, min(bend, 0.0)) * _SHORT
        if step > h - s:
            return np.inf
        s += step
        bend, phi, psi = short_basis(k, s)
        value, slope, bend = gap + rate * s + pull * psi, rate + pull * phi, pull * bend
    return s


@inner_kernel
def _face_reach(
    lines: Floats, i: int, x: float, y: float, vx: float, vy: float, ax: float, ay: float,
    k: float, h: float, margin: float,
) -> float:  # fmt: skip
    """A time until which a ball does not enter a face of a wall; NEVER if it does not within h."""
    dx, dy = x - lines[i, 0], y - lines[i, 1]
    nx, ny, reach = lines[i, 2], lines[i, 3], lines[i, 4]
    gap = dx * nx + dy * ny - reach
    rate, pull = vx * nx + vy * ny, ax * nx + ay * ny
    s = 0.0
    if gap > margin:
        s = _line_reach(gap - margin, rate, pull, k, h, 0.01 * margin)
        if s == np.inf:
            return s
    elif gap + max(rate, 0.0) * h + max(pull, 0.0) * 0.5 * h * h < -margin:
        return np.inf  # behind the line, and does not come out on this side within the window
    # The ball's foot stays between those of the path's ends, up to the bulge of the path.
    _, _, psi = short_basis(k, h)
    first = dx * -ny + dy * nx
    last = first + (vx * -ny + vy * nx) * h + (ax * -ny + ay * nx) * psi
    bulge = margin + h * h / 8.0 * sqrt(ax * ax + ay * ay)
    low, high = min(first, last) - bulge, max(first, last) + bulge
    return np.inf if max(low, lines[i, 6]) > min(high, lines[i, 5]) else s


@inner_kernel
def _circles_reached(
    circles: Floats, flight: tuple[float, float, float, float, float, float, float], h: float,
    way: float, more: float, start: float, skipped: int, numbers: Ints, times: Floats,
) -> int:  # fmt: skip
    """Write the circles that a ball may touch in a window, each with a time before which it does
    not; returns their number. The ball moves at most `way` m in the window."""
    x, y, vx, vy, ax, ay, k = flight
    count = 0
    for i in range(len(circles)):
        if i == skipped:
            continue
        qx, qy, reach = x - circles[i, 0], y - circles[i, 1], circles[i, 2]
        far = reach + way + more / reach
        if abs(qx) > far or abs(qy) > far:
            continue
        s = _circle_reach(qx, qy, vx, vy, ax, ay, k, h, reach * reach + more, 0.01 * more)
        if s < np.inf:
            numbers[count], times[count] = i, start + s
            count += 1
    return count


@kernel
def first_reaches(
    state: Floats, k: float, errors: Floats, start: float, left: int, circles: Floats,
    lines: Floats, board: Floats, numbers: Ints, times: Floats,
) -> tuple[int, float]:  # fmt: skip
    """Find the first window of a flight, from `start` on, in which the ball may touch surfaces.

    `state` is x, y, v_x, v_y, a_x, a_y at the flight's beginning, in m and s; `errors` are bounds
    of the errors of position, velocity and acceleration; k is the drag. `left` is a circle or face
    that the window at 0 leaves out, or -1. `circles` has rows x, y, reach. `lines` has rows x, y,
    n_x, n_y, reach, to, from, where the face goes from `from` to `to` along (-n_y, n_x). `board`
    has the smallest reach, the size, the box outside of which a ball has left the board (x_min,
    x_max, y_min), and the bins' y. Surfaces are numbered circles first, then lines, then the bins.

    Writes numbers and times into the last two arguments. The ball does not touch a surface before
    its time, and no other surface before the window's end. Returns the number of surfaces, and that
    end: NEVER if the ball leaves the board.
    """
    smallest, size = board[0], board[1]
    for _ in range(_MOST_WINDOWS):
        decay, phi, psi = basis(k, start)
        x = state[0] + state[2] * start + state[4] * psi
        y = state[1] + state[3] * start + state[5] * psi
        vx, vy = state[2] + state[4] * phi, state[3] + state[5] * phi
        ax, ay = state[4] * decay, state[5] * decay
        speed, pull = sqrt(vx * vx + vy * vy), sqrt(ax * ax + ay * ay)
        h = min(1.0, 8.0 * smallest / speed if speed > 0.0 else 1.0)
        if pull > 0.0:
            h = min(h, sqrt(2.0 * smallest / pull))
        if k * h > SERIES_LIMIT:
            h = SERIES_LIMIT / k
        end = start + h
        wide = errors[0] + end * (errors[1] + 0.5 * end * errors[2])
        margin = MARGIN * size + 2.0 * wide
        more = MARGIN * size * size + 4.0 * size * wide + 4.0 * wide * wide
        reach_of_all = speed * h + 0.5 * pull * h * h + margin
        flight = x, y, vx, vy, ax, ay, k
        skipped = left if start == 0.0 else -1
        count = _circles_reached(
            circles, flight, h, reach_of_all, more, start, skipped, numbers, times
        )
        for i in range(len(lines)):
            if len(circles) + i == skipped:
                continue
            s = _face_reach(lines, i, x, y, vx, vy, ax, ay, k, h, margin)
            if s < np.inf:
                numbers[count], times[count] = len(circles) + i, start + s
                count += 1
        s = 0.0
        if board[5] - y > margin:
            s = _line_reach(board[5] - y - margin, -vy, -ay, k, h, 0.01 * margin)
        if s < np.inf:
            numbers[count], times[count] = len(circles) + len(lines), start + s
            count += 1
        if count > 0 or start == 0.0:
            return count, end
        start = end
        if not (board[2] < x < board[3] and board[4] < y):
            return 0, np.inf
    return -1, start


def rebound_reach(first: float, slope: float, bend: float, h: float) -> float:
    """A time until which first + slope s + bend s^2 / 2 > 0, NEVER if that holds for all of h.

    The caller has lowered all three coefficients by bounds of their errors.
    """
    reach = float(_root(first, slope, bend)) * _SHORT
    return NEVER if reach > h else reach
