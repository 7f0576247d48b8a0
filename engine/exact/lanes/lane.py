"""What is kept of the balls side by side, each in a lane of its own.

A stage is a loop over the lanes. So a processor goes on with the next ball while it waits for the
last one's results, guesses few branches wrong, and computes four or eight lanes at a time where a
loop has none. Each ball goes through the arithmetic of the solver for one ball, in its order:
nothing crosses lanes.

The stages are compiled twice, with and without drag and friction, by the argument `drags`: a
constant where they are called, so that the code without has neither a branch nor the arithmetic.

Numbers that are read from memory to look something up by are unsigned: of a signed one the compiled
code looks at the sign each time, for -1 would be the last, and that took a seventh of the time.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from engine.exact import initial_state
from engine.exact.board_arrays import BoardArrays
from engine.exact.event_log import Log, new_log
from engine.jit.decorator import lean_kernel
from engine.physics import body
from engine.physics.circle_impact import Motion
from engine.physics.contact import new_series
from engine.physics.series import Series

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Indices = npt.NDArray[np.uint32]

LANES = 104
"""Balls side by side: enough to hide what each waits for, few enough to stay in the nearest cache,
and 13 of its lines: an odd number, or the columns' beginnings would drive each other out."""

SLOTS = 8
"""Members of a cell that are looked at for all balls together, at most; the others, one by one."""

WIDTH = 8
"""A list is filled up to a multiple of this, so that no search is left over from the vectors."""

SEARCHES = 2 * LANES
"""In a list; one that is half full is searched before it goes on."""

# Where the lanes' values begin in the numbers `w`, shape (FLOAT_COLUMNS * LANES,): distances
# known when the loops are compiled, or they could not be vectorized. First the state at the
# flight's start, as `body` has it, …
T0 = body.T * LANES
X0 = body.X * LANES
Y0 = body.Y * LANES
VX0 = body.VX * LANES
VY0 = body.VY * LANES
OMEGA = body.OMEGA * LANES
AX0 = 7 * LANES
AY0 = 8 * LANES
RISE = 9 * LANES  # m/s, of `next_impact`
ORIGIN_SIDE = 10 * LANES  # of the surface that the flight starts from
START = 11 * LANES  # s of the flight at which the window starts, and its `flight.bases`
# … then the window: where it starts, its length, and what is hit first in it.
WX = 15 * LANES
WY = 16 * LANES
WVX = 17 * LANES
WVY = 18 * LANES
WAX = 19 * LANES
WAY = 20 * LANES
HORIZON = 21 * LANES
BEST = 22 * LANES
HIT_SIDE = 23 * LANES
VV = 24 * LANES  # v.v, v.a and a.a, of which the bound of f''' is made
VA = 25 * LANES
AA = 26 * LANES
CX = 27 * LANES  # the centre and D^2 of the candidate that is looked at
CY = 28 * LANES
CD2 = 29 * LANES
FLOAT_COLUMNS = 30

# The same of the integers `m`, shape (INT_COLUMNS * LANES,).
DROP = 0 * LANES  # number of the drop
SURFACE = 1 * LANES  # the surface that the flight starts from, -1 for none
ORIGIN = 2 * LANES  # the same in the flight's first window, then -1
ITEM = 3 * LANES  # what is hit first, or a code of `next_impact`
IMPACTS = 4 * LANES
EVENTS = 5 * LANES  # these, and what the solver for one ball has noted
ODD = 6 * LANES  # 1: this flight is for the solver for one ball
CELL = 7 * LANES  # of the window, and how long its list is, up to HEAD_MANY
MORE = 8 * LANES
MARK = 9 * LANES  # bit n: the ball may hit the n-th member of its cell in this window; LOW; BEYOND
MEMBER = 10 * LANES  # the candidate that is looked at
WINDOWS = 11 * LANES  # searched in this flight
INT_COLUMNS = 12

SEARCH_COLUMNS = 16  # those of search.py
IMPACT_COLUMNS = 28  # those of impact.py


class Space(NamedTuple):
    """Work space: of the lanes, of their searches and impacts, and of one ball alone."""

    w: Floats  # (FLOAT_COLUMNS * LANES,)
    m: Ints  # (INT_COLUMNS * LANES,)
    r: Floats  # (SEARCH_COLUMNS * SEARCHES,)
    few: Floats  # the same, of those that take long
    back: Indices  # (SEARCHES,): which of `r` these are
    e: Floats  # (IMPACT_COLUMNS * LANES,)
    whose: Indices  # (SEARCHES,): the lane of each search
    which: Indices  # (SEARCHES,): the surface that it looks for
    marked: Indices  # (LANES + 1,): lanes with a mark
    ended: Indices  # (LANES + 1,): lanes whose flights end in this window
    members: Indices  # the board's, and SLOTS more
    state: Floats  # (body.SIZE,)
    place: Ints  # (initial_state.COLUMNS,)
    series: Series
    log: Log


def new_space(board: BoardArrays) -> Space:
    """Work space for drops on `board`."""
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
    """How ball i moves from its window's start on."""
    return Motion(
        w[WX + i], w[WY + i], w[WVX + i], w[WVY + i], w[WAX + i], w[WAY + i], k
    )  # fmt: skip


@lean_kernel
def move_lane(w: Floats, m: Ints, i: int, last: int) -> None:
    """The last lane's ball moves to lane i."""
    for column in range(FLOAT_COLUMNS):
        w[column * LANES + i] = w[column * LANES + last]
    for column in range(INT_COLUMNS):
        m[column * LANES + i] = m[column * LANES + last]
