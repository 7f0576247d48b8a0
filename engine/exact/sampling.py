"""States at any times of a drop that has been traced, from the segments of its log."""

import numpy as np
import numpy.typing as npt

from engine.exact.event_log import ITEM, MODE, SIDE, SLIP_SIGN
from engine.exact.sustained_contact import advance_ride, start_series
from engine.jit.decorator import inner_kernel, kernel
from engine.physics.ball import OMEGA, PX, PY, STATE_SIZE, THETA, VX, VY, T
from engine.physics.flight import advance_flight
from engine.physics.layout import Layout
from engine.physics.series import Series

Array = npt.NDArray[np.float64]


@inner_kernel
def sample_segment(
    board: Layout,
    segments: Array,
    row: int,
    time: float,
    straight: bool,
    series: Series,
    out: Array,
) -> None:
    """State at `time` of the motion that starts with a segment, into `out`, shape (7,).

    `straight` says that the segments are the stepped solver's straight pieces.
    """
    segment = segments[row]
    for i in range(STATE_SIZE):
        out[i] = segment[i]
    s = time - segment[T]
    if s <= 0.0:
        return
    if straight:
        out[PX] += out[VX] * s
        out[PY] += out[VY] * s
        out[THETA] += out[OMEGA] * s
    elif segment[ITEM] < 0.0:
        advance_flight(out, board.gravity, board.drag, s)
    else:
        item = int(segment[ITEM])
        start_series(
            board, series, out, item, segment[SIDE], int(segment[MODE]), segment[SLIP_SIGN]
        )
        advance_ride(board, series, out, item, s)
    out[T] = time


@kernel
def sample(
    board: Layout,
    segments: Array,
    rows: npt.NDArray[np.int64],
    last: npt.NDArray[np.int64],
    times: Array,
    straight: bool,
    series: Series,
    out: Array,
) -> None:
    """State of each of n balls at its own time, times[i], into `out`, shape (n, 7).

    Ball i's segments are the rows rows[i] to last[i] of `segments`. rows[i] is moved on to the
    segment in use: from call to call a ball's time must not decrease. `series` is work space.
    """
    for i in range(len(times)):
        row = rows[i]
        while row + 1 < last[i] and segments[row + 1, T] <= times[i]:
            row += 1
        rows[i] = row
        sample_segment(board, segments, row, times[i], straight, series, out[i])
        out[i, T] = times[i]
