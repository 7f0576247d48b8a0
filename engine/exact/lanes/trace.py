"""Traces many drops side by side: the outcomes of `trace_many`, to the last bit, in less time.

Lanes run as native code only. In WebAssembly they were no faster than one ball after the other: 0.8
times as fast on triangle-16, 1.03 times on classic and galton.

The lanes compute what balls mostly do: fly, bounce and land. For everything else (rolling, two
surfaces at once, terminal velocity, a limit) a ball goes to the solver for one ball, `follow`. As
soon as it has bounced off a surface and flies again, it continues in its lane.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

from plinko.engine.exact import event_log, initial_state
from plinko.engine.exact.board_arrays import BoardArrays, bin_of
from plinko.engine.exact.lanes import impact, lane
from plinko.engine.exact.lanes.flight import begin_flight, close_windows, find_cells, open_windows
from plinko.engine.exact.lanes.impact import arrive, rebound_all
from plinko.engine.exact.lanes.lane import Space, move_lane, new_space
from plinko.engine.exact.lanes.search import mark, reach_bins, search_again, search_marked
from plinko.engine.exact.next_impact import BINS, BOUNCED, FREE
from plinko.engine.exact.outcome import EVENT_LIMIT, LANDED, RUNNING, Results
from plinko.engine.exact.trace import follow, trace_many
from plinko.engine.jit.decorator import inner_kernel, kernel, lean_kernel
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats, Ints
from plinko.engine.physics.contact import new_series


class Drops(NamedTuple):
    """Balls at rest at each (xs[i], y), in m, and the limits of their drops."""

    xs: Floats
    y: float
    max_events: int
    max_time: float


Code = Callable[[BoardArrays, Drops, Space, Results], None]
"""A kernel of this file, as a rule native code of it."""


def trace_drops(
    board: BoardArrays, drops: Drops, results: Results, code: Mapping[str, Code]
) -> None:
    """`trace_many` of these drops, without a log or end states.

    code: native code of the lanes, by the kernels' names. Without it, one ball is followed after
    the other: WebAssembly computes lanes no faster.
    """
    if code:
        kernel = trace_plain_lanes if is_plain(board) else trace_lanes
        code[f"{kernel.__module__}.{kernel.__name__}"](board, drops, new_space(board), results)
        return
    states = initial_state.at_rest(drops.xs, drops.y)
    trace_many(
        board, states, initial_state.in_flight(len(states)), drops.max_events, drops.max_time,
        new_series(), event_log.new_log(0, 0), results.outcomes, results.bins, results.impacts,
    )  # fmt: skip
    results.durations[:] = states[:, body.T]
    results.x_ends[:] = states[:, body.X]


def is_plain(board: BoardArrays) -> bool:
    """Whether a board has no drag and no friction, as `trace_plain_lanes` requires."""
    return board.drag == 0.0 and board.peg_friction == 0.0 and board.wall_friction == 0.0


@kernel
def trace_lanes(board: BoardArrays, drops: Drops, space: Space, results: Results) -> None:
    """`trace_drops` on any board."""
    _trace(board, drops, space, results, True)


@kernel
def trace_plain_lanes(board: BoardArrays, drops: Drops, space: Space, results: Results) -> None:
    """`trace_drops` on a board without drag and friction: the same source, compiled separately."""
    _trace(board, drops, space, results, False)


KERNELS: Final[Mapping[str, Code]] = MappingProxyType(
    {f"{each.__module__}.{each.__name__}": each for each in (trace_lanes, trace_plain_lanes)}
)
"""The entries of native code, by name."""


@lean_kernel
def _trace(board: BoardArrays, drops: Drops, space: Space, results: Results, drags: bool) -> None:
    w, m, e = space.w, space.m, space.e
    begun = 0
    active = 0
    fresh = 0
    while begun < len(drops.xs) and active < lane.LANES:
        _begin_drop(board, w, m, active, begun, drops)
        begun += 1
        active += 1
    while active > 0:
        _search_windows(board, space, active, fresh, drags)
        fresh = close_windows(board, space, active, drops.max_time)
        arrive(board, space, fresh, drags)
        rebound_all(e, fresh, board.radius, drags)
        # From the last lane to the first: when a drop ends, the last active lane takes its place,
        # and must have been handled before.
        for c in range(fresh - 1, -1, -1):
            i = int(space.ended[c])
            item = m[lane.ITEM + i]
            is_odd = _ends_oddly(m, e, i, c)
            if is_odd or (item != BINS and e[impact.DIES + c] != 0.0):
                outcome = _follow_alone(board, space, i, c, not is_odd, drops)
            elif item == BINS:
                w[lane.T0 + i] = e[impact.T + c]
                w[lane.X0 + i] = e[impact.X + c]
                outcome = LANDED
            else:
                _bounce(w, m, e, i, c)
                outcome = RUNNING if m[lane.EVENTS + i] < drops.max_events else EVENT_LIMIT
            if outcome == RUNNING:
                begin_flight(board, w, m, i)
                continue
            _write(board, w, m, i, outcome, results)
            if begun < len(drops.xs):
                _begin_drop(board, w, m, i, begun, drops)
                begun += 1
            else:
                active -= 1
                move_lane(w, m, i, active)


@lean_kernel
def _begin_drop(board: BoardArrays, w: Floats, m: Ints, i: int, drop: int, drops: Drops) -> None:
    for column in range(body.SIZE):
        w[column * lane.LANES + i] = 0.0
    w[lane.X0 + i] = drops.xs[drop]
    w[lane.Y0 + i] = drops.y
    w[lane.ORIGIN_SIDE + i] = 0.0
    m[lane.DROP + i] = drop
    m[lane.SURFACE + i] = initial_state.NONE
    m[lane.IMPACTS + i] = 0
    m[lane.EVENTS + i] = 0
    begin_flight(board, w, m, i)


@lean_kernel
def _search_windows(board: BoardArrays, space: Space, active: int, fresh: int, drags: bool) -> None:
    """Find what balls hit first in their windows; the lanes ended[:fresh] begin a flight."""
    w, m = space.w, space.m
    open_windows(board, w, m, active, drags)
    find_cells(board, w, m, active, drags)
    search_again(board, space, fresh, active, drags)
    slots, count = mark(board, space, active, drags)
    search_marked(board, space, count, slots, drags)
    reach_bins(board, w, m, space.marked, count)


@lean_kernel
def _ends_oddly(m: Ints, e: Floats, i: int, c: int) -> bool:
    """Whether the flight of ball i, the c-th that ends, needs the solver for one ball."""
    origin, item = m[lane.SURFACE + i], m[lane.ITEM + i]
    touches_both = e[impact.STOOD + c] != 0.0 and origin >= 0 and item >= 0 and origin != item
    return bool(m[lane.ODD + i] != 0 or touches_both)


@lean_kernel
def _bounce(w: Floats, m: Ints, e: Floats, i: int, c: int) -> None:
    """Set ball i to its state after the impact."""
    for column in range(body.SIZE):
        w[column * lane.LANES + i] = e[impact.AFTER + column * lane.LANES + c]
    w[lane.ORIGIN_SIDE + i] = w[lane.HIT_SIDE + i]
    m[lane.SURFACE + i] = m[lane.ITEM + i]
    m[lane.IMPACTS + i] += 1
    m[lane.EVENTS + i] += 1


@inner_kernel
def _follow_alone(
    board: BoardArrays, space: Space, i: int, c: int, from_impact: bool, drops: Drops
) -> int:
    """Follow ball i by the solver for one ball until it has bounced and flies.

    It is the c-th whose flight ends, and is followed from the impact there, or from the flight's
    start. Returns the drop's outcome, RUNNING if it goes on in its lane. `follow` is called for one
    event at a time, so that it returns as soon as the ball flies.
    """
    w, m, e = space.w, space.m, space.e
    state, place, counts = space.state, space.place, space.log.counts
    for column in range(body.SIZE):
        end = e[impact.END + column * lane.LANES + c]
        state[column] = end if from_impact else w[column * lane.LANES + i]
    place[initial_state.HIT] = m[lane.ITEM + i] if from_impact else initial_state.NONE
    place[initial_state.HIT_SIDE] = int(w[lane.HIT_SIDE + i]) if from_impact else 0
    place[initial_state.SURFACE] = m[lane.SURFACE + i]
    place[initial_state.SIDE] = int(w[lane.ORIGIN_SIDE + i])
    place[initial_state.PHASE] = FREE if m[lane.SURFACE + i] < 0 else BOUNCED
    place[initial_state.SLIP_ROOT] = 0
    place[initial_state.SLIP_SIGN] = 0
    place[initial_state.SECOND_SURFACE] = initial_state.NONE
    counts[event_log.EVENTS] = m[lane.EVENTS + i]
    counts[event_log.IMPACTS] = m[lane.IMPACTS + i]
    outcome = EVENT_LIMIT
    flies_on = False
    while outcome == EVENT_LIMIT and counts[event_log.EVENTS] < drops.max_events and not flies_on:
        limit = counts[event_log.EVENTS] + 1
        outcome = follow(board, state, place, limit, drops.max_time, space.series, space.log)
        is_free = place[initial_state.SECOND_SURFACE] == initial_state.NONE
        flies_on = place[initial_state.PHASE] == BOUNCED and is_free
    if outcome == EVENT_LIMIT and counts[event_log.EVENTS] < drops.max_events:
        outcome = RUNNING
    for column in range(body.SIZE):
        w[column * lane.LANES + i] = state[column]
    w[lane.ORIGIN_SIDE + i] = float(place[initial_state.SIDE])
    m[lane.SURFACE + i] = place[initial_state.SURFACE]
    m[lane.IMPACTS + i] = counts[event_log.IMPACTS]
    m[lane.EVENTS + i] = counts[event_log.EVENTS]
    return outcome


@lean_kernel
def _write(board: BoardArrays, w: Floats, m: Ints, i: int, outcome: int, results: Results) -> None:
    """Write the results of the drop in lane i."""
    drop = m[lane.DROP + i]
    results.bins[drop] = bin_of(board, w[lane.X0 + i]) if outcome == LANDED else -1
    results.outcomes[drop] = outcome
    results.durations[drop] = w[lane.T0 + i]
    results.x_ends[drop] = w[lane.X0 + i]
    results.impacts[drop] = m[lane.IMPACTS + i]
