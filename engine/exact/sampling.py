"""Computes the state at any time of a traced drop from the segments of its log."""

from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.sustained_contact import advance_contact, start_series
from plinko.engine.jit.decorator import inner_kernel, kernel
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats, Ints
from plinko.engine.physics.flight import advance_flight
from plinko.engine.physics.series import Series


@inner_kernel
def sample_segment(
    board: BoardArrays,
    segments: Floats,
    row: int,
    time: float,
    straight: bool,
    series: Series,
    out: Floats,
) -> None:
    """Write the state at `time` on a segment into `out`, shape (7,).

    `straight`: whether the segments are the straight pieces of the stepped solver.
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
    segments: Floats,
    rows: Ints,
    last: Ints,
    times: Floats,
    straight: bool,
    series: Series,
    out: Floats,
) -> None:
    """Write the state of each of n balls at its time, times[i], into `out`, shape (n, 7).

    Ball i has the rows from rows[i] up to last[i] (excluded) of `segments`. rows[i] is set to the
    segment in use, so a ball's time must not decrease from call to call. `series` is work space.
    """
    for i in range(len(times)):
        row = rows[i]
        while row + 1 < last[i] and segments[row + 1, body.T] <= times[i]:
            row += 1
        rows[i] = row
        sample_segment(board, segments, row, times[i], straight, series, out[i])
        out[i, body.T] = times[i]
