"""The exact solver: closed-form flight, the next impact found to the last bits, impulse, repeat."""

import numpy as np
import numpy.typing as npt

from engine.constants import KIND_CONTACT_BEGIN, KIND_CONTACT_END
from engine.kernels.contact import new_series
from engine.kernels.jit import kernel
from engine.kernels.layout import Layout
from engine.kernels.log import IMPACTS, PX, PY, STATE_SIZE, VX, VY, Log, T, note_event
from engine.kernels.series import Series
from engine.kernels.surface import is_wedged, touch
from engine.solvers import flying, riding
from engine.solvers.landing import land
from engine.solvers.outcome import (
    BALANCED,
    ESCAPED,
    EVENT_LIMIT,
    LANDED,
    TIME_LIMIT,
    WEDGED,
)

State = npt.NDArray[np.float64]


@kernel
def _comes_to_rest(
    board: Layout, state: State, ridden: int, ridden_side: float, hit: int, hit_side: float
) -> bool:
    """Whether a ball that rode one surface into another has no speed left and cannot go on."""
    ax, ay, _, _ = touch(board, ridden, ridden_side, state[PX], state[PY])
    bx, by, _, _ = touch(board, hit, hit_side, state[PX], state[PY])
    slow = state[VX] * bx + state[VY] * by >= -flying.DYING_BOUNCE
    return slow and is_wedged(board, ax, ay, bx, by)


@kernel
def trace(
    board: Layout, state: State, max_events: int, max_time: float, log: Log, series: Series
) -> tuple[int, int]:
    """Follow a ball from `state` (T, PX, … OMEGA; changed in place) until its drop ends.

    Returns the outcome and the bin, -1 if it did not land.
    """
    item = -1
    side = 0.0
    how = flying.FREE
    touching = False
    while True:
        end, item, side, grips = flying.fly(
            board.items, board.left, board.top, board.cells_per_metre, board.columns, board.rows,
            board.starts, board.members, board.centres, board.travel, board.fall,
            board.gravity, board.drag, board.radius, board.bins_y,
            board.peg_count, board.peg_restitution, board.peg_friction,
            board.wall_restitution, board.wall_friction,
            state, item, side, how, touching, max_events, max_time,
            log.events, log.marks, log.segments, log.counts,
        )  # fmt: skip
        if end == flying.AT_BINS:
            return LANDED, land(board, state, log)
        if end == flying.OUT_OF_EVENTS:
            return EVENT_LIMIT, -1
        if end == flying.OUT_OF_TIME:
            return TIME_LIMIT, -1
        if end == flying.OUT_OF_BOARD:
            return ESCAPED, -1
        note_event(log, state, KIND_CONTACT_BEGIN, riding.surface_index(board, item))
        cause, item, side, hit, hit_side = riding.ride(
            board, series, state, item, side, grips, max_time, max_events, log
        )
        touching = cause == riding.HIT
        if touching:
            if _comes_to_rest(board, state, item, side, hit, hit_side):
                return WEDGED, -1
            item = hit
            side = hit_side
            continue
        if cause == riding.LANDED:
            return LANDED, land(board, state, log)
        if cause == riding.AT_REST:
            return BALANCED, -1
        if cause == riding.OUT_OF_TIME:
            return TIME_LIMIT, -1
        if cause == riding.OUT_OF_EVENTS:
            return EVENT_LIMIT, -1
        if cause == riding.OUT_OF_BOARD:
            return ESCAPED, -1
        how = flying.ROLLED_OFF if cause == riding.LEFT else flying.BOUNCED
        note_event(log, state, KIND_CONTACT_END, riding.surface_index(board, item))


@kernel
def trace_many(
    board: Layout,
    xs: npt.NDArray[np.float64],
    y: float,
    max_events: int,
    max_time: float,
    log: Log,
    bins: npt.NDArray[np.int32],
    durations: npt.NDArray[np.float64],
    x_ends: npt.NDArray[np.float64],
    impacts: npt.NDArray[np.int32],
    outcomes: npt.NDArray[np.int8],
) -> None:
    """Drop a ball at rest from each (xs[i], y) and write down its outcome; all arrays shape (n,).

    `log` has room for nothing: it only counts.
    """
    series = new_series()
    state = np.zeros(STATE_SIZE)
    for i in range(xs.shape[0]):
        state[:] = 0.0
        state[PX] = xs[i]
        state[PY] = y
        log.counts[:] = 0
        outcome, where = trace(board, state, max_events, max_time, log, series)
        bins[i] = where
        outcomes[i] = outcome
        durations[i] = state[T]
        x_ends[i] = state[PX]
        impacts[i] = log.counts[IMPACTS]
