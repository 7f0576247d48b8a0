"""Many drops side by side on a board without drag and friction: the same bits, in less time."""

from typing import NamedTuple

import numpy as np

from engine.exact import initial_state
from engine.exact.board_arrays import BoardArrays, bin_of, restitution_of
from engine.exact.free_flight import DYING_BOUNCE, PLACE_ROUNDING, rebound
from engine.exact.lockstep import lanes
from engine.exact.lockstep.lanes import (
    Floats,
    Ints,
    begin,
    close_windows,
    empty_lane,
    find_cells,
    hit_again,
    mark,
    open_windows,
    reach_bins,
)
from engine.exact.lockstep.search import Space, new_space, search_marked
from engine.exact.next_impact import BINS, FREE, length_bound
from engine.exact.outcome import LANDED, Results
from engine.jit.decorator import kernel, lean_kernel
from engine.physics import body


@lean_kernel
def _arrive(w: Floats, i: int, gravity: float) -> bool:
    """Move ball i to the end of its flight. False if it has not moved, within rounding."""
    s = w[lanes.START + i]
    t = w[lanes.T0 + i]
    x = w[lanes.X0 + i]
    y = w[lanes.Y0 + i]
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
    moved = abs(w[lanes.X0 + i] - x) + abs(w[lanes.Y0 + i] - y)
    place = abs(w[lanes.X0 + i]) + abs(w[lanes.Y0 + i])
    return bool(w[lanes.T0 + i] > t and moved > PLACE_ROUNDING * place)


@lean_kernel
def _bounces(board: BoardArrays, w: Floats, m: Ints, i: int) -> bool:
    """Impact of ball i on what it has hit. False, and nothing done, if the bounce has died."""
    items = board.items
    item = m[lanes.ITEM + i]
    side = w[lanes.HIT_SIDE + i]
    x, y, vx, vy, _, nx, ny, _ = rebound(
        items, item, side, w[lanes.X0 + i], w[lanes.Y0 + i], w[lanes.VX0 + i], w[lanes.VY0 + i],
        0.0, board.radius, restitution_of(board, item), 0.0,
    )  # fmt: skip
    if vx * nx + vy * ny <= DYING_BOUNCE:
        return False
    w[lanes.X0 + i] = x
    w[lanes.Y0 + i] = y
    w[lanes.VX0 + i] = vx
    w[lanes.VY0 + i] = vy
    w[lanes.ORIGIN_SIDE + i] = side
    m[lanes.ORIGIN + i] = item
    m[lanes.IMPACT_COUNT + i] += 1
    m[lanes.WINDOWS + i] = 0
    return True


class LeftOver(NamedTuple):
    """Drops to which more happens than bounces: n of them, each for `trace_many` to go on with."""

    drops: Ints  # (n,): their numbers
    states: Floats  # (n, STATE_SIZE)
    initial: Ints  # (n, initial_state.COLUMNS)

    def first(self, count: int) -> "LeftOver":
        """The first so many of them."""
        return LeftOver(self.drops[:count], self.states[:count], self.initial[:count])


@lean_kernel
def _leave(
    w: Floats, m: Ints, i: int, x: float, y: float, stays: bool, row: int, left_over: LeftOver
) -> None:
    """Ball i is left over: at the impact after which it stays, or at its start (x, y)."""
    numbers, states, initial = left_over
    numbers[row] = m[lanes.DROP + i]
    for column in range(body.SIZE):
        states[row, column] = 0.0
    states[row, body.X] = x
    states[row, body.Y] = y
    initial[row, initial_state.HIT] = initial_state.NONE
    initial[row, initial_state.HIT_SIDE] = 0
    initial[row, initial_state.IMPACTS_BEFORE] = 0
    initial[row, initial_state.SURFACE] = initial_state.NONE
    initial[row, initial_state.SIDE] = 0
    initial[row, initial_state.PHASE] = FREE
    initial[row, initial_state.BESIDE] = initial_state.NONE
    if stays:
        states[row, body.T] = w[lanes.T0 + i]
        states[row, body.X] = w[lanes.X0 + i]
        states[row, body.Y] = w[lanes.Y0 + i]
        states[row, body.VX] = w[lanes.VX0 + i]
        states[row, body.VY] = w[lanes.VY0 + i]
        initial[row, initial_state.HIT] = m[lanes.ITEM + i]
        initial[row, initial_state.HIT_SIDE] = int(w[lanes.HIT_SIDE + i])
        initial[row, initial_state.IMPACTS_BEFORE] = m[lanes.IMPACT_COUNT + i]


def has_only_bounces(board: BoardArrays) -> bool:
    """Whether `trace_bounces` can take the board's drops: neither drag nor friction is on it."""
    return board.drag == 0.0 and board.peg_friction == 0.0 and board.wall_friction == 0.0


@lean_kernel
def _search_windows(board: BoardArrays, space: Space, active: int, fresh: int, rise: float) -> None:
    """Find what balls hit first in their windows; `fresh` of the lanes `ended` begin a flight."""
    w, m, _, _, _, marked, ended, members = space
    open_windows(board, w, m, active, rise)
    find_cells(board, w, m, active)
    for c in range(fresh):
        i = int(ended[c])
        if m[lanes.ORIGIN + i] >= 0 and i < active:
            hit_again(board, w, m, i)
    slots, count = mark(board, w, m, active, members, marked)
    search_marked(board, space, count, slots)
    for c in range(count):
        i = int(marked[c])
        if m[lanes.MARK + i] & lanes.LOW:
            reach_bins(board, w, m, i)


@lean_kernel
def _write_landing(board: BoardArrays, w: Floats, m: Ints, i: int, results: Results) -> None:
    """Ball i has reached the bins."""
    drop = m[lanes.DROP + i]
    results.bins[drop] = bin_of(board, w[lanes.X0 + i])
    results.outcomes[drop] = LANDED
    results.durations[drop] = w[lanes.T0 + i]
    results.x_ends[drop] = w[lanes.X0 + i]
    results.impacts[drop] = m[lanes.IMPACT_COUNT + i]


@kernel
def _trace_lanes(
    board: BoardArrays,
    xs: Floats,
    y: float,
    max_events: int,
    max_time: float,
    space: Space,
    results: Results,
    left_over: LeftOver,
) -> int:
    """`trace_bounces`, which puts the drops left over into `left_over`; how many they are."""
    w, m, _, _, _, _, ended, _ = space
    rise = board.travel / board.fall + 0.5 * board.fall * length_bound(0.0, board.gravity)
    begun = 0
    active = 0
    left = 0
    fresh = 0
    while begun < len(xs) and active < lanes.LANES:
        begin(w, m, active, begun, xs[begun], y)
        begun += 1
        active += 1
    while active > 0:
        _search_windows(board, space, active, fresh, rise)
        fresh = close_windows(w, m, active, max_time, ended)
        for c in range(fresh - 1, -1, -1):
            i = int(ended[c])
            item = m[lanes.ITEM + i]
            flies = _arrive(w, i, board.gravity)
            stays = False
            if item >= 0 and m[lanes.ODD + i] == 0 and flies:
                stays = not _bounces(board, w, m, i)
                if not stays and m[lanes.IMPACT_COUNT + i] < max_events:
                    continue
            if item == BINS and m[lanes.ODD + i] == 0:
                _write_landing(board, w, m, i, results)
            else:
                _leave(w, m, i, xs[m[lanes.DROP + i]], y, stays, left, left_over)
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
        np.empty((count, initial_state.COLUMNS), np.int64),
    )  # fmt: skip
    # Searches that have ended are computed on with the others: without the JIT, numpy would tell.
    with np.errstate(all="ignore"):
        left = _trace_lanes(
            board, xs, y, max_events, max_time, new_space(board), results, left_over
        )
    return left_over.first(left)
