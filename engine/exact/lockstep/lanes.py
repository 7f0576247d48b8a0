"""Lanes of balls in free flight: each stage is done for all of them before the next one begins.

One lane holds one ball; a stage is a loop over the lanes. So a processor goes on with the next ball
while it waits for the last one's results, guesses few branches wrong, and computes four lanes at a
time where a loop has none. Only for boards without drag and friction. Each ball goes through the
arithmetic of `free_flight`, in its order: nothing crosses lanes.

Numbers that are read from memory to look something up by are unsigned: of a signed one the compiled
code looks at the sign each time, for -1 would be the last, and that took a seventh of the time.
"""

import numpy as np
import numpy.typing as npt

from engine.exact.board_arrays import BoardArrays
from engine.exact.grid import HEAD_BITS
from engine.exact.next_impact import BINS, NOWHERE, length_bound, origin_line_hit
from engine.jit.decorator import lean_kernel
from engine.physics import surface
from engine.physics.circle_impact import circle_hit_again, third_derivative_bound
from engine.physics.line_impact import line_hit
from engine.physics.time_of_impact import NO_HIT, SIXTH, stays_positive

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Indices = npt.NDArray[np.uint32]

LANES = 104
"""Balls side by side: enough to hide what each waits for, few enough to stay in the nearest cache,
and 13 of its lines: an odd number, or the columns' beginnings would drive each other out."""

SLOTS = 8
"""Members of a cell that are looked at for all balls together, at most; the others, one by one."""

FEW = 8
"""A slot that fewer than one ball in so many has a member in is not worth a look for all."""

FIRST_ITEM = (1 << HEAD_BITS) - 1
"""The bits of a cell's head that are its first item."""

LOW = 1 << SLOTS
"""The mark of a ball that may reach the bins in this window."""

BEYOND = 2 << SLOTS
"""The mark of a ball whose cell has more members than were looked at for all."""

PATIENCE = 10_000
"""Windows in one flight after which a ball is left to others: it has missed the board."""

# Where the lanes' values begin in the numbers `w`, shape (FLOAT_COLUMNS * LANES,): distances
# known when the loops are compiled, or they could not be vectorized. First the flight's start,
T0 = 0 * LANES  # s
X0 = 1 * LANES
Y0 = 2 * LANES
VX0 = 3 * LANES
VY0 = 4 * LANES
ORIGIN_SIDE = 5 * LANES  # of the surface that the flight starts from
START = 6 * LANES  # s of the flight at which the window starts
# then the window: where it starts, its length, and what is hit first in it.
WX = 7 * LANES
WY = 8 * LANES
WVX = 9 * LANES
WVY = 10 * LANES
HORIZON = 11 * LANES
BEST = 12 * LANES
HIT_SIDE = 13 * LANES
VV = 14 * LANES  # v.v, and what the bound of f''' adds to it in the chord test
BEND = 15 * LANES
CX = 16 * LANES  # the centre and D^2 of the candidate that is looked at
CY = 17 * LANES
CD2 = 18 * LANES
FLOAT_COLUMNS = 19

# The same of the integers `m`, shape (INT_COLUMNS * LANES,).
DROP = 0 * LANES  # number of the drop
ORIGIN = 1 * LANES  # the surface that the flight starts from, in its first window; else -1
ITEM = 2 * LANES  # what is hit first, or a code of `next_impact`
IMPACT_COUNT = 3 * LANES
ODD = 4 * LANES  # 1: left over, from its start: it touches two, or its cell has too many
CELL = 5 * LANES  # of the window, and how long its list is, up to HEAD_MANY
MORE = 6 * LANES
MARK = 7 * LANES  # bit n: the ball may hit the n-th member of its cell in this window; LOW; BEYOND
MEMBER = 8 * LANES  # the candidate that is looked at
DONE = 9 * LANES  # 1: the flight ends in this window
WINDOWS = 10 * LANES  # searched in this flight
INT_COLUMNS = 11


@lean_kernel
def begin(w: Floats, m: Ints, i: int, drop: int, x: float, y: float) -> None:
    """Put drop number `drop`, at rest at (x, y), in lane i."""
    w[T0 + i] = 0.0
    w[X0 + i] = x
    w[Y0 + i] = y
    w[VX0 + i] = 0.0
    w[VY0 + i] = 0.0
    w[START + i] = 0.0
    m[DROP + i] = drop
    m[ORIGIN + i] = -1
    m[WINDOWS + i] = 0
    m[IMPACT_COUNT + i] = 0
    m[ODD + i] = 0


@lean_kernel
def empty_lane(w: Floats, m: Ints, i: int, last: int) -> None:
    """The last lane's ball moves to lane i."""
    for column in range(FLOAT_COLUMNS):
        w[column * LANES + i] = w[column * LANES + last]
    for column in range(INT_COLUMNS):
        m[column * LANES + i] = m[column * LANES + last]


@lean_kernel
def open_windows(board: BoardArrays, w: Floats, m: Ints, n: int, rise: float) -> None:
    """Bring n balls to their windows' starts, and find how long the windows are.

    rise: at least sqrt(2 g travel), in m/s.
    """
    gravity = board.gravity
    travel = board.travel
    for i in range(n):
        vx0 = w[VX0 + i]
        vy0 = w[VY0 + i]
        ax = -0.0 * vx0  # the sign of a zero, as with drag
        start = w[START + i]
        psi = 0.5 * start * start
        vx = vx0 + ax * start
        vy = vy0 + gravity * start
        speed = length_bound(vx, vy)
        horizon = 2.0 * travel / (speed + length_bound(speed, rise))
        w[WX + i] = w[X0 + i] + vx0 * start + ax * psi
        w[WY + i] = w[Y0 + i] + vy0 * start + gravity * psi
        w[WVX + i] = vx
        w[WVY + i] = vy
        w[HORIZON + i] = horizon
        w[BEST + i] = horizon
        low3 = third_derivative_bound(vy * gravity, gravity * gravity, 0.0, 0.0, horizon)
        w[VV + i] = vx * vx + vy * vy
        w[BEND + i] = low3 * horizon * SIXTH
    for i in range(n):
        m[ITEM + i] = NOWHERE


@lean_kernel
def find_cells(board: BoardArrays, w: Floats, m: Ints, n: int) -> None:
    """Each window's cell, the first candidate that it lists, and how many it lists."""
    gravity = board.gravity
    left = board.left
    top = board.top
    cells_per_metre = board.cells_per_metre
    columns = board.columns
    rows = board.rows
    heads = board.heads
    centres = board.centres
    width = float(columns)
    height = float(rows)
    for i in range(n):
        half = 0.5 * w[HORIZON + i]
        across = (w[WX + i] + w[WVX + i] * half - left) * cells_per_metre
        down = (w[WY + i] + w[WVY + i] * half + gravity * half * half - top) * cells_per_metre
        is_inside = (across >= 0.0) & (down >= 0.0) & (across < width) & (down < height)
        column = np.int32(across if is_inside else 0.0)
        row = np.int32(down if is_inside else 0.0)
        cell = row * np.int32(columns) + column  # narrow factors: vectors have no wide product
        m[CELL + i] = cell if is_inside else columns * rows
    for i in range(n):
        head = heads[np.uint32(m[CELL + i])]
        m[MORE + i] = head >> HEAD_BITS
        _look_at(w, m, i, head & FIRST_ITEM, centres)


@lean_kernel
def _look_at(w: Floats, m: Ints, i: int, member: int, centres: Floats) -> None:
    """The candidate that is looked at for ball i is `member`."""
    m[MEMBER + i] = member
    w[CX + i] = centres[member, 0]
    w[CY + i] = centres[member, 1]
    w[CD2 + i] = centres[member, 2]


@lean_kernel
def hit_again(board: BoardArrays, w: Floats, m: Ints, i: int) -> None:
    """Note if ball i hits the surface that it has just left within its first window."""
    items = board.items
    gravity = board.gravity
    origin = m[ORIGIN + i]
    side = w[ORIGIN_SIDE + i]
    x = w[WX + i]
    y = w[WY + i]
    vx = w[WVX + i]
    vy = w[WVY + i]
    horizon = w[HORIZON + i]
    if items[origin, surface.DISTANCE] == 0.0:
        s = origin_line_hit(items, origin, side, x, y, vx, vy, 0.0, gravity, 0.0, horizon)
    else:
        qx = x - items[origin, surface.X]
        qy = y - items[origin, surface.Y]
        s = circle_hit_again(qx, qy, vx, vy, 0.0, gravity, 0.0, horizon, horizon)
    if s != NO_HIT:
        w[BEST + i] = s
        m[ITEM + i] = origin
        w[HIT_SIDE + i] = side


@lean_kernel
def is_far(w: Floats, i: int, x: float, y: float, d2: float, gravity: float) -> bool:
    """Whether the chord test of `next_impact` turns down a circle at (x, y) for ball i."""
    qx = w[WX + i] - x
    qy = w[WY + i] - y
    f = qx * qx + qy * qy - d2
    b = qx * w[WVX + i] + qy * w[WVY + i]
    c = w[VV + i] + qy * gravity
    return stays_positive(f, b, c + w[BEND + i], w[HORIZON + i])


@lean_kernel
def _mark_slot(w: Floats, m: Ints, n: int, slot: int, gravity: float) -> None:
    """Mark which balls may hit the candidate that is looked at, the slot-th of their cells."""
    bit = 1 << slot
    for i in range(n):
        d2 = w[CD2 + i]
        may_hit = (d2 == 0.0) | (not is_far(w, i, w[CX + i], w[CY + i], d2, gravity))
        may_hit &= (m[MORE + i] > slot) & (m[MEMBER + i] != m[ORIGIN + i])
        m[MARK + i] |= bit if may_hit else 0


@lean_kernel
def _slots_of(m: Ints, n: int) -> int:
    """How many members of their cells are worth a look for all balls together."""
    slots = 1  # the first are there already
    while slots < SLOTS:
        longer = 0
        for i in range(n):
            longer += int(m[MORE + i] > slots)
        if FEW * longer < n:
            break
        slots += 1
    return slots


@lean_kernel
def mark(
    board: BoardArrays, w: Floats, m: Ints, n: int, members: Indices, marked: Indices
) -> tuple[int, int]:
    """Mark what the balls may hit in their windows; list the lanes with any mark.

    members: SLOTS longer than the cells' lists. Returns how many members were looked at for all
    balls, and how many lanes are listed.
    """
    starts = board.starts
    centres = board.centres
    gravity = board.gravity
    slots = _slots_of(m, n)
    for i in range(n):
        beyond = BEYOND if m[MORE + i] > slots else 0
        m[MARK + i] = beyond | (LOW if w[WY + i] + board.travel >= board.bins_y else 0)
    for slot in range(slots):
        if slot > 0:
            for i in range(n):
                _look_at(w, m, i, members[starts[np.uint32(m[CELL + i])] + slot], centres)
        _mark_slot(w, m, n, slot, gravity)
    found = 0
    for i in range(n):
        marked[np.uint32(found)] = i
        found += int(m[MARK + i] != 0)
    return slots, found


@lean_kernel
def reach_bins(board: BoardArrays, w: Floats, m: Ints, i: int) -> None:
    """Note if ball i lands before it hits anything else known."""
    best = w[BEST + i]
    s = line_hit(board.bins_y - w[WY + i], -w[WVY + i], -board.gravity, 0.0, w[HORIZON + i], best)
    if s != NO_HIT and (s < best or m[ITEM + i] == NOWHERE):
        w[BEST + i] = s
        m[ITEM + i] = BINS


@lean_kernel
def close_windows(w: Floats, m: Ints, n: int, max_time: float, ended: Indices) -> int:
    """Send on the balls that hit nothing; list the lanes whose flights end: their number.

    START of such a lane is then the length of its flight.
    """
    for i in range(n):
        start = w[START + i] + w[BEST + i]
        w[START + i] = start
        m[WINDOWS + i] += 1
        is_late = (start > max_time - w[T0 + i]) | (m[WINDOWS + i] > PATIENCE)
        m[DONE + i] = int((m[ITEM + i] != NOWHERE) | (m[ODD + i] != 0) | is_late)
        m[ORIGIN + i] = -1
    count = 0
    for i in range(n):
        ended[np.uint32(count)] = i
        count += m[DONE + i]
    return count
