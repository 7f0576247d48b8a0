"""Many drops side by side on a board without drag and friction: the same bits, in less time."""

from typing import NamedTuple

import numpy as np

from engine.exact import initial_state
from engine.exact.board_arrays import BoardArrays, bin_of
from engine.exact.free_flight import rebound, stays_on
from engine.exact.lockstep import lanes, search
from engine.exact.lockstep.lanes import (
    Floats,
    Indices,
    Ints,
    begin,
    close_windows,
    empty_lane,
    find_cells,
    mark,
    meet_again,
    meet_bins,
    open_windows,
)
from engine.exact.lockstep.search import search_marked
from engine.exact.next_impact import BINS, length_bound
from engine.exact.outcome import LANDED, Results
from engine.jit.decorator import kernel, lean_kernel
from engine.physics import body


@lean_kernel
def _arrive(w: Floats, i: int, gravity: float) -> None:
    """Move ball i to the end of its flight."""
    s = w[lanes.START + i]
    psi = 0.5 * s * s
    vx = w[lanes.VX0 + i]
    vy = w[lanes.VY0 + i]
    ax = -0.0 * vx
    w[lanes.T0 + i] += s
    w[lanes.X0 + i] = w[lanes.X0 + i] + vx * s + ax * psi
    w[lanes.Y0 + i] = w[lanes.Y0 + i] + vy * s + gravity * psi
    w[lanes.VX0 + i] = vx + ax * s
    w[lanes.VY0 + i] = vy + gravity * s
    w[lanes.START + i] = 0.0


@lean_kernel
def _bounces(
    w: Floats, m: Ints, i: int, items: Floats, radius: float, gravity: float, restitution: float
) -> bool:
    """Impact of ball i on what it has met. False, and nothing done, if it would then stay on it."""
    item = m[lanes.ITEM + i]
    side = w[lanes.HIT_SIDE + i]
    x, y, vx, vy, _, nx, ny, _ = rebound(
        items, item, side, w[lanes.X0 + i], w[lanes.Y0 + i], w[lanes.VX0 + i], w[lanes.VY0 + i],
        0.0, radius, restitution, 0.0,
    )  # fmt: skip
    if stays_on(items, item, vx, vy, nx, ny, gravity):
        return False
    w[lanes.X0 + i] = x
    w[lanes.Y0 + i] = y
    w[lanes.VX0 + i] = vx
    w[lanes.VY0 + i] = vy
    w[lanes.HELD_SIDE + i] = side
    m[lanes.HELD + i] = item
    m[lanes.IMPACT_COUNT + i] += 1
    m[lanes.WINDOWS + i] = 0
    return True


class LeftOver(NamedTuple):
    """Drops to which more happens than bounces: n of them, each for `trace_many` to go on with."""

    drops: Ints  # (n,): their numbers
    states: Floats  # (n, STATE_SIZE)
    entries: Ints  # (n, ENTRY_SIZE)

    def first(self, count: int) -> "LeftOver":
        """The first so many of them."""
        return LeftOver(self.drops[:count], self.states[:count], self.entries[:count])


@lean_kernel
def _leave(
    w: Floats, m: Ints, i: int, x: float, y: float, stays: bool, row: int, numbers: Ints,
    states: Floats, entries: Ints,
) -> None:  # fmt: skip
    """Ball i is left over: at the impact after which it stays, or at its start (x, y)."""
    numbers[row] = m[lanes.DROP + i]
    for column in range(body.SIZE):
        states[row, column] = 0.0
    states[row, body.X] = x
    states[row, body.Y] = y
    entries[row, initial_state.MET] = initial_state.NONE
    entries[row, initial_state.MET_SIDE] = 0
    entries[row, initial_state.IMPACTS_BEFORE] = 0
    if stays:
        states[row, body.T] = w[lanes.T0 + i]
        states[row, body.X] = w[lanes.X0 + i]
        states[row, body.Y] = w[lanes.Y0 + i]
        states[row, body.VX] = w[lanes.VX0 + i]
        states[row, body.VY] = w[lanes.VY0 + i]
        entries[row, initial_state.MET] = m[lanes.ITEM + i]
        entries[row, initial_state.MET_SIDE] = int(w[lanes.HIT_SIDE + i])
        entries[row, initial_state.IMPACTS_BEFORE] = m[lanes.IMPACT_COUNT + i]


class _Space(NamedTuple):
    """Work space of `_trace_row`."""

    w: Floats  # (FLOAT_COLUMNS * LANES,)
    m: Ints  # (INT_COLUMNS * LANES,)
    r: Floats  # (SEARCH_COLUMNS * ROOM,)
    whose: Indices  # (ROOM,): the lane of each search
    which: Indices  # (ROOM,): the surface that it looks for
    marked: Indices  # (LANES + 1,)
    ended: Indices
    members: Indices  # the layout's, and SLOTS more


def has_only_bounces(board: BoardArrays) -> bool:
    """Whether `trace_bounces` can take the board's drops: neither drag nor friction is on it."""
    return board.drag == 0.0 and board.peg_friction == 0.0 and board.wall_friction == 0.0


def _new_space(board: BoardArrays) -> _Space:
    """Work space for drops on `board`."""
    return _Space(
        w=np.zeros(lanes.FLOAT_COLUMNS * lanes.LANES),
        m=np.zeros(lanes.INT_COLUMNS * lanes.LANES, np.int64),
        r=np.zeros(search.SEARCH_COLUMNS * search.ROOM),
        whose=np.zeros(search.ROOM, np.uint32),
        which=np.zeros(search.ROOM, np.uint32),
        marked=np.zeros(lanes.LANES + 1, np.uint32),
        ended=np.zeros(lanes.LANES + 1, np.uint32),
        members=np.append(board.members, np.zeros(lanes.SLOTS, np.uint32)),
    )


@kernel
def _trace_row(
    board: BoardArrays,
    xs: Floats,
    y: float,
    max_events: int,
    max_time: float,
    space: _Space,
    results: Results,
    left_over: LeftOver,
) -> int:
    """`trace_bounces`, which puts the drops left over into `left_over`; how many they are."""
    w, m, r, whose, which, marked, ended, members = space
    bins, durations, x_ends, impacts, outcomes = results
    numbers, states, entries = left_over
    # Taken apart once: in a loop, the reference counting of a board's arrays would cost most.
    items = board.items
    starts = board.starts
    heads = board.heads
    centres = board.centres
    gravity = board.gravity
    travel = board.travel
    radius = board.radius
    peg_count = board.peg_count
    rise = travel / board.fall + 0.5 * board.fall * length_bound(0.0, gravity)
    begun = 0
    active = 0
    left = 0
    fresh = 0
    while begun < len(xs) and active < lanes.LANES:
        begin(w, m, active, begun, xs[begun], y)
        begun += 1
        active += 1
    while active > 0:
        open_windows(w, m, active, gravity, travel, rise)
        find_cells(
            w, m, active, gravity, board.left, board.top, board.cells_per_metre, board.columns,
            board.rows, heads, centres,
        )  # fmt: skip
        for c in range(fresh):
            i = int(ended[c])
            if m[lanes.HELD + i] >= 0 and i < active:
                meet_again(w, m, i, items, gravity)
        slots, count = mark(
            w, m, active, starts, members, centres, gravity, travel, board.bins_y, marked
        )
        search_marked(
            w, m, r, marked, count, starts, members, centres, items, radius, gravity, slots,
            whose, which,
        )  # fmt: skip
        for c in range(count):
            i = int(marked[c])
            if m[lanes.MARK + i] & lanes.LOW:
                meet_bins(w, m, i, gravity, board.bins_y)
        fresh = close_windows(w, m, active, max_time, ended)
        for c in range(fresh - 1, -1, -1):
            i = int(ended[c])
            item = m[lanes.ITEM + i]
            _arrive(w, i, gravity)
            stays = False
            if item >= 0 and m[lanes.ODD + i] == 0:
                is_peg = item < peg_count
                restitution = board.peg_restitution if is_peg else board.wall_restitution
                stays = not _bounces(w, m, i, items, radius, gravity, restitution)
                if not stays and m[lanes.IMPACT_COUNT + i] < max_events:
                    continue
            drop = m[lanes.DROP + i]
            if item == BINS and m[lanes.ODD + i] == 0:
                bins[drop] = bin_of(board, w[lanes.X0 + i])
                outcomes[drop] = LANDED
                durations[drop] = w[lanes.T0 + i]
                x_ends[drop] = w[lanes.X0 + i]
                impacts[drop] = m[lanes.IMPACT_COUNT + i]
            else:
                _leave(w, m, i, xs[drop], y, stays, left, numbers, states, entries)
                left += 1
            if begun < len(xs):
                begin(w, m, i, begun, xs[begun], y)
                begun += 1
            else:
                active -= 1
                empty_lane(w, m, i, active)
    return left


def trace_bounces(
    board: BoardArrays,
    xs: Floats,
    y: float,
    max_events: int,
    max_time: float,
    results: Results,
) -> LeftOver:
    """`trace_many` of the drops to which nothing happens but bounces, and of no others.

    board: without drag and friction. Returns the drops that are left over: their balls roll, and
    are at the impact before that, or come to a limit, and are at their start.
    """
    count = len(xs)
    left_over = LeftOver(
        np.empty(count, np.int64), np.empty((count, body.SIZE)),
        np.empty((count, initial_state.ENTRY_SIZE), np.int64),
    )  # fmt: skip
    # Searches that have ended are computed on with the others: without the JIT, numpy would tell.
    with np.errstate(all="ignore"):
        left = _trace_row(board, xs, y, max_events, max_time, _new_space(board), results, left_over)
    return left_over.first(left)
