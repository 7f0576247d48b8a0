"""The windows of all flights: where they start, how long they are, which cell lists candidates.

`next_impact` has the same steps for one ball, and explains them.
"""

import numpy as np

from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.grid import HEAD_BITS
from plinko.engine.exact.lanes import lane
from plinko.engine.exact.lanes.lane import Space
from plinko.engine.exact.next_impact import NOWHERE, length_bound
from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.physics.array_types import Floats, Ints
from plinko.engine.physics.flight import SERIES_LIMIT, phi2
from plinko.engine.physics.time_of_impact import NEGLIGIBLE

PATIENCE = 10_000
"""Windows in one flight, at most. A ball that needs more has missed the board, and goes to the
solver for one ball."""

DOUBLINGS = 3
"""Doublings of a basis. Flights longer than LONGEST go to the solver for one ball."""

LONGEST = SERIES_LIMIT * 2**DOUBLINGS
"""Largest k s of a flight, 2: |a| falls to e^-2 of its start, so not below an eighth."""

FIRST_ITEM = (1 << HEAD_BITS) - 1
"""The bits of a cell's head that have its first item."""

# The columns of `bases`, relative to its first one: the times, then the results.
TIME = 0 * lane.LANES
DECAY = 1 * lane.LANES
PHI = 2 * lane.LANES
PSI = 3 * lane.LANES


@lean_kernel
def bases(b: Floats, at: int, n: int, k: float) -> None:
    """`basis` of n times up to LONGEST / k; its columns begin at `at` in b."""
    for i in range(n):
        h = b[at + TIME + i]
        z = k * h
        halved = 0.0
        limit = SERIES_LIMIT
        for _ in range(DOUBLINGS):
            is_long = z > limit
            h = 0.5 * h if is_long else h
            halved = halved + 1.0 if is_long else halved
            limit = limit + limit
        psi = h * h * phi2(k * h)
        phi = h - k * psi
        decay = 1.0 - k * phi
        for doubled in range(DOUBLINGS):
            goes_on = halved > doubled
            psi = psi + phi * h + decay * psi if goes_on else psi
            phi = phi + decay * phi if goes_on else phi
            decay = decay * decay if goes_on else decay
            h = h + h if goes_on else h
        b[at + DECAY + i] = decay
        b[at + PHI + i] = phi
        b[at + PSI + i] = psi


@lean_kernel
def dot(x: float, y: float, ax: float, ay: float, drags: bool) -> float:
    """(x, y).(ax, ay); without drag ax is 0."""
    return x * ax + y * ay if drags else y * ay


@lean_kernel
def begin_flight(board: BoardArrays, w: Floats, m: Ints, i: int) -> None:
    """Begin a flight of ball i from the state in its lane.

    A ball that may reach its terminal velocity, within rounding, goes to the solver for one ball.
    Within LONGEST |a| falls at most to an eighth, hence the factor 8 on the limit.
    """
    k = board.drag
    straight = NEGLIGIBLE * board.radius * k * k
    ax = -k * w[lane.VX0 + i]
    ay = board.gravity - k * w[lane.VY0 + i]
    w[lane.AX0 + i] = ax
    w[lane.AY0 + i] = ay
    w[lane.RISE + i] = board.travel / board.fall + 0.5 * board.fall * length_bound(ax, ay)
    w[lane.START + i] = 0.0
    m[lane.ODD + i] = int(k > 0.0 and length_bound(ax, ay) <= 8.0 * straight)
    m[lane.ORIGIN + i] = m[lane.SURFACE + i]
    m[lane.WINDOWS + i] = 0


@lean_kernel
def open_windows(board: BoardArrays, w: Floats, m: Ints, n: int, drags: bool) -> None:
    """Move n balls to the starts of their windows, and compute the windows' lengths."""
    k, gravity = board.drag, board.gravity
    travel = board.travel
    longest = SERIES_LIMIT / k if k > 0.0 else np.inf
    if drags:
        bases(w, lane.START, n, k)
    for i in range(n):
        start = w[lane.START + i]
        phi = w[lane.START + PHI + i] if drags else start
        psi = w[lane.START + PSI + i] if drags else 0.5 * start * start
        vx0, vy0 = w[lane.VX0 + i], w[lane.VY0 + i]
        ax0, ay0 = w[lane.AX0 + i], w[lane.AY0 + i]
        vx = vx0 + ax0 * phi
        vy = vy0 + ay0 * phi
        ax = ax0 * w[lane.START + DECAY + i] if drags else ax0
        ay = ay0 * w[lane.START + DECAY + i] if drags else gravity
        speed = length_bound(vx, vy)
        horizon = 2.0 * travel / (speed + length_bound(speed, w[lane.RISE + i]))
        if drags:
            horizon = longest if k * horizon > SERIES_LIMIT else horizon
        w[lane.WX + i] = w[lane.X0 + i] + vx0 * start + ax0 * psi
        w[lane.WY + i] = w[lane.Y0 + i] + vy0 * start + ay0 * psi
        w[lane.WVX + i] = vx
        w[lane.WVY + i] = vy
        w[lane.WAX + i] = ax
        w[lane.WAY + i] = ay
        w[lane.HORIZON + i] = horizon
        w[lane.BEST + i] = horizon
        w[lane.VV + i] = vx * vx + vy * vy
        w[lane.VA + i] = dot(vx, vy, ax, ay, drags)
        w[lane.AA + i] = dot(ax, ay, ax, ay, drags)
    for i in range(n):
        m[lane.ITEM + i] = NOWHERE


@lean_kernel
def find_cells(board: BoardArrays, w: Floats, m: Ints, n: int, drags: bool) -> None:
    """Find each window's cell, its first candidate, and its number of candidates."""
    k, left = board.drag, board.left
    top = board.top
    cells_per_metre = board.cells_per_metre
    columns, rows = board.columns, board.rows
    heads, centres = board.heads, board.centres
    width, height = float(columns), float(rows)
    for i in range(n):
        horizon = w[lane.HORIZON + i]
        half = 0.5 * horizon
        psi = half * half * (1.0 - k * horizon * (1.0 / 3.0)) if drags else half * half
        x = w[lane.WX + i] + w[lane.WVX + i] * half
        x = x + w[lane.WAX + i] * psi if drags else x
        y = w[lane.WY + i] + w[lane.WVY + i] * half + w[lane.WAY + i] * psi
        across = (x - left) * cells_per_metre
        down = (y - top) * cells_per_metre
        is_inside = (across >= 0.0) & (down >= 0.0) & (across < width) & (down < height)
        column = np.int32(across if is_inside else 0.0)
        row = np.int32(down if is_inside else 0.0)
        cell = row * np.int32(columns) + column  # 32 bits: vectors have no product of 64 bits
        m[lane.CELL + i] = cell if is_inside else columns * rows
    for i in range(n):
        head = heads[np.uint32(m[lane.CELL + i])]
        m[lane.MORE + i] = head >> HEAD_BITS
        look_at(w, m, i, head & FIRST_ITEM, centres)


@lean_kernel
def look_at(w: Floats, m: Ints, i: int, member: int, centres: Floats) -> None:
    """Make `member` the current candidate of ball i."""
    m[lane.MEMBER + i] = member
    w[lane.CX + i] = centres[member, 0]
    w[lane.CY + i] = centres[member, 1]
    w[lane.CD2 + i] = centres[member, 2]


@lean_kernel
def close_windows(board: BoardArrays, space: Space, n: int, max_time: float) -> int:
    """Move the balls without a hit to their next windows, and list the lanes whose flights end.

    Returns the number of these lanes; START of such a lane is then the duration of its flight. A
    ball whose flight is too long for the lanes goes to the solver for one ball.
    """
    w, m, ended = space.w, space.m, space.ended
    k = board.drag
    for i in range(n):
        start = w[lane.START + i] + w[lane.BEST + i]
        w[lane.START + i] = start
        m[lane.WINDOWS + i] += 1
        is_late = (start > max_time - w[lane.T0 + i]) | (m[lane.WINDOWS + i] > PATIENCE)
        is_late &= m[lane.ITEM + i] == NOWHERE
        m[lane.ODD + i] |= int(is_late | (k * start > LONGEST))
        m[lane.ORIGIN + i] = -1
    count = 0
    for i in range(n):
        ended[np.uint32(count)] = i
        count += int((m[lane.ITEM + i] != NOWHERE) | (m[lane.ODD + i] != 0))
    return count
