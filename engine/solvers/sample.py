"""States at any times of a drop that has been traced, from the segments of its log."""

import numpy as np
import numpy.typing as npt

from engine.kernels.contact import new_series
from engine.kernels.flight import advance_flight
from engine.kernels.jit import inner_kernel, kernel
from engine.kernels.layout import Layout
from engine.kernels.log import (
    ITEM,
    MODE,
    OMEGA,
    PX,
    PY,
    SIDE,
    SLIP_SIGN,
    STATE_SIZE,
    THETA,
    VX,
    VY,
    T,
)
from engine.solvers.riding import advance_ride, start_series

Array = npt.NDArray[np.float64]


@inner_kernel
def segment_at(segments: Array, first: int, last: int, time: float) -> int:
    """Row in [first, last) of the last segment that starts at or before `time`."""
    low = first
    high = last
    while high - low > 1:
        middle = (low + high) // 2
        if segments[middle, T] <= time:
            low = middle
        else:
            high = middle
    return low


@inner_kernel
def sample_segment(
    board: Layout, segments: Array, row: int, time: float, straight: bool, series: Array, out: Array
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
    board: Layout, segments: Array, times: Array, end: Array, straight: bool, out: Array
) -> None:
    """States at `times`, shape (n,), into `out`, shape (n, 7); from end[T] on the state `end`."""
    series = new_series()
    for i in range(times.shape[0]):
        if times[i] >= end[T]:
            for column in range(STATE_SIZE):  # row by row would cost a tenth of all compile time
                out[i, column] = end[column]
            out[i, T] = times[i]
            continue
        row = segment_at(segments, 0, segments.shape[0], times[i])
        sample_segment(board, segments, row, times[i], straight, series, out[i])


@kernel
def sample_crowd(
    board: Layout,
    segments: Array,
    first: npt.NDArray[np.int64],
    last: npt.NDArray[np.int64],
    times: Array,
    out: Array,
) -> None:
    """State of each of n balls at its own time, times[i], into `out`, shape (n, 7).

    Ball i's segments are the rows first[i] to last[i] of `segments`; first[i] is moved on to the
    segment in use, so times must not decrease from call to call.
    """
    series = new_series()
    for i in range(times.shape[0]):
        row = first[i]
        while row + 1 < last[i] and segments[row + 1, T] <= times[i]:
            row += 1
        first[i] = row
        sample_segment(board, segments, row, times[i], False, series, out[i])
        out[i, T] = times[i]
