"""States at any times of a drop that has been traced, from the segments of its log."""

import numpy as np
import numpy.typing as npt

from engine.exact import event_log
from engine.exact.board_arrays import BoardArrays
from engine.exact.sustained_contact import advance_contact, start_series
from engine.jit.decorator import inner_kernel, kernel
from engine.physics import body
from engine.physics.flight import advance_flight
from engine.physics.series import Series

Array = npt.NDArray[np.float64]


@inner_kernel
def sample_segment(
    board: BoardArrays,
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
    for i in range(body.SIZE):
        out[i] = segment[i]
    s = time - segment[body.T]
    if s <= 0.0:
        return
    if straight:
        out[body.X] += out[body.VX] * s
        out[body.Y] += out[body.VY] * s
        out[body.THETA] += out[body.OMEGA] * s
    elif segment[event_log.ITEM] < 0.0:
        advance_flight(out, board.gravity, board.drag, s)
    else:
        item = int(segment[event_log.ITEM])
        start_series(
            board,
            series,
            out,
            item,
            segment[event_log.SIDE],
            int(segment[event_log.MODE]),
            segment[event_log.SLIP_SIGN],
        )
        advance_contact(board, series, out, item, s)
    out[body.T] = time


@kernel
def sample(
    board: BoardArrays,
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
        while row + 1 < last[i] and segments[row + 1, body.T] <= times[i]:
            row += 1
        rows[i] = row
        sample_segment(board, segments, row, times[i], straight, series, out[i])
        out[i, body.T] = times[i]
