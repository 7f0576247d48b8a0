"""The memory of the lanes: each lane has one ball, and an array has one value of all lanes in turn.

A stage is a loop over the lanes. So a processor computes the next ball while it waits for the
results of the one before, mispredicts few branches, and computes four or eight lanes at a time in
loops without branches. Each ball goes through the arithmetic of the solver for one ball, in the
same order, and no value depends on another lane.

The stages are compiled twice, with and without drag and friction. The argument `drags` is a
constant for the compiler, so the code without drag has neither the branches nor the arithmetic.

Indices that are read from memory are unsigned. For signed ones the compiled code tests the sign
each time, as Python's index -1 means the last item, and that took a seventh of the time.
"""

from typing import NamedTuple

import numpy as np

from plinko.engine.exact import initial_state
from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.event_log import Log, new_log
from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats, Indices, Ints
from plinko.engine.physics.circle_impact import Motion
from plinko.engine.physics.contact import new_series
from plinko.engine.physics.series import Series

LANES = 104
"""Balls side by side: enough to hide the latency of each, few enough for the first-level cache. A
column of 104 numbers is 13 cache lines. An odd number keeps columns in different sets of the
cache."""

SLOTS = 8
"""Members of a cell that are tested for all balls together, at most; the others are tested one by
one."""

WIDTH = 8
"""Lists are padded to a multiple of this, so that all searches fit into whole vectors."""

SEARCHES = 2 * LANES
"""Searches in a list; a list that is half full is searched before it is filled again."""

# Where the columns of the floats `w` begin, shape (FLOAT_COLUMNS * LANES,). They are constants,
# because loops over columns at variable distances are not vectorized. First the state at the
# flight's start, in the order of `body`, …
T0 = body.T * LANES
X0 = body.X * LANES
Y0 = body.Y * LANES
VX0 = body.VX * LANES
VY0 = body.VY * LANES
OMEGA = body.OMEGA * LANES
AX0 = 7 * LANES
AY0 = 8 * LANES
RISE = 9 * LANES  # m/s, as in `next_impact`
ORIGIN_SIDE = 10 * LANES  # the side of the surface from which the flight starts
START = 11 * LANES  # s into the flight at which the window starts, and its `flight.bases`
# … then the window: the state at its start, its length, and the first hit in it.
WX = 15 * LANES
WY = 16 * LANES
WVX = 17 * LANES
WVY = 18 * LANES
WAX = 19 * LANES
WAY = 20 * LANES
HORIZON = 21 * LANES
BEST = 22 * LANES
HIT_SIDE = 23 * LANES
VV = 24 * LANES  # v.v, v.a and a.a, for the bound of f'''
VA = 25 * LANES
AA = 26 * LANES
CX = 27 * LANES  # the centre and D^2 of the current candidate
CY = 28 * LANES
CD2 = 29 * LANES
FLOAT_COLUMNS = 30

# The columns of the integers `m`, shape (INT_COLUMNS * LANES,).
DROP = 0 * LANES  # number of the drop
SURFACE = 1 * LANES  # the surface from which the flight starts, or -1
ORIGIN = 2 * LANES  # the same in the flight's first window, then -1
ITEM = 3 * LANES  # the surface hit first, or a code of `next_impact`
IMPACTS = 4 * LANES
EVENTS = 5 * LANES  # impacts, and other events that the solver for one ball has counted
ODD = 6 * LANES  # 1: the solver for one ball must follow this flight
CELL = 7 * LANES  # the window's cell
MORE = 8 * LANES  # number of its members, up to HEAD_MANY
MARK = 9 * LANES  # bit n: the ball may hit the n-th member of its cell; LOW and BEYOND of search.py
MEMBER = 10 * LANES  # the current candidate
WINDOWS = 11 * LANES  # windows of this flight
INT_COLUMNS = 12

SEARCH_COLUMNS = 16  # see search.py
IMPACT_COLUMNS = 28  # see impact.py


class Space(NamedTuple):
    """Work space of the lanes, of their searches and impacts, and of the solver for one ball."""

    w: Floats  # (FLOAT_COLUMNS * LANES,)
    m: Ints  # (INT_COLUMNS * LANES,)
    r: Floats  # (SEARCH_COLUMNS * SEARCHES,)
    few: Floats  # the same, for searches that take many steps
    back: Indices  # (SEARCHES,): the places of these in `r`
    e: Floats  # (IMPACT_COLUMNS * LANES,)
    whose: Indices  # (SEARCHES,): the lane of each search
    which: Indices  # (SEARCHES,): the surface of each search
    marked: Indices  # (LANES + 1,): lanes with a mark
    ended: Indices  # (LANES + 1,): lanes whose flights end in this window
    members: Indices  # the board's, padded with SLOTS zeros
    state: Floats  # (body.SIZE,)
    place: Ints  # (initial_state.COLUMNS,)
    series: Series
    log: Log


def new_space(board: BoardArrays) -> Space:
    return Space(
        w=np.zeros(FLOAT_COLUMNS * LANES),
        m=np.zeros(INT_COLUMNS * LANES, np.int64),
        r=np.zeros(SEARCH_COLUMNS * SEARCHES),
        few=np.zeros(SEARCH_COLUMNS * SEARCHES),
        back=np.zeros(SEARCHES, np.uint32),
        e=np.zeros(IMPACT_COLUMNS * LANES),
        whose=np.zeros(SEARCHES, np.uint32),
        which=np.zeros(SEARCHES, np.uint32),
        marked=np.zeros(LANES + 1, np.uint32),
        ended=np.zeros(LANES + 1, np.uint32),
        members=np.append(board.members, np.zeros(SLOTS, np.uint32)),
        state=np.zeros(body.SIZE),
        place=np.zeros(initial_state.COLUMNS, np.int64),
        series=new_series(),
        log=new_log(0, 0),
    )


@lean_kernel
def motion_of(w: Floats, i: int, k: float) -> Motion:
    """The motion of ball i from its window's start on."""
    return Motion(
        w[WX + i], w[WY + i], w[WVX + i], w[WVY + i], w[WAX + i], w[WAY + i], k
    )  # fmt: skip


@lean_kernel
def move_lane(w: Floats, m: Ints, i: int, last: int) -> None:
    """Move the ball in lane `last` to lane i."""
    for column in range(FLOAT_COLUMNS):
        w[column * LANES + i] = w[column * LANES + last]
    for column in range(INT_COLUMNS):
        m[column * LANES + i] = m[column * LANES + last]
