"""Counts where balls spend their time: the cells that drops are in at equal time steps."""

from math import ceil

import numpy as np

from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.event_log import Log
from plinko.engine.exact.sampling import sample_segment
from plinko.engine.jit.decorator import inner_kernel, kernel
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats, Indices
from plinko.engine.physics.flight import basis
from plinko.engine.physics.series import Series

Counts = Indices


@inner_kernel
def _count(counts: Counts, left: float, top: float, cells: float, x: float, y: float) -> None:
    """Count a position in m, if it is in the grid; NaN is not."""
    column = (x - left) * cells
    row = (y - top) * cells
    if 0.0 <= column < counts.shape[1] and 0.0 <= row < len(counts):
        counts[int(row), int(column)] += np.uint32(1)


@inner_kernel
def _occupy_segment(
    board: BoardArrays,
    segments: Floats,
    row: int,
    time: float,
    until: float,
    step: float,
    left: float,
    top: float,
    cells: float,
    counts: Counts,
    series: Series,
    state: Floats,
) -> float:
    """Count a segment at `time`, `time` + step … before `until`; returns the next time."""
    if time >= until:
        return time
    if segments[row, event_log.ITEM] >= 0.0:
        while time < until:
            sample_segment(board, segments, row, time, False, series, state)
            _count(counts, left, top, cells, state[body.X], state[body.Y])
            time += step
        return time
    # In flight all steps are the same linear map: exact, and a tenth of the work of a sample.
    sample_segment(board, segments, row, time, False, series, state)
    x = state[body.X]
    y = state[body.Y]
    vx = state[body.VX]
    vy = state[body.VY]
    _, phi, psi = basis(board.drag, step)
    while time < until:
        _count(counts, left, top, cells, x, y)
        ax = -board.drag * vx
        ay = board.gravity - board.drag * vy
        x += vx * step + ax * psi
        y += vy * step + ay * psi
        vx += ax * phi
        vy += ay * phi
        time += step
    return time


@kernel
def occupy(
    board: BoardArrays,
    log: Log,
    states: Floats,
    phases: Floats,
    step: float,
    left: float,
    top: float,
    cells: float,
    series: Series,
    sample: Floats,
    counts: Counts,
) -> None:
    """Count where balls are every `step` s.

    The log has all segments of n drops; states, shape (n, 7), their ends. Drop i is counted
    phases[i] steps after its start, and then at every step until its end. counts has shape (rows,
    columns), with `cells` per metre and its corner at (left, top). series and sample, shape (7,),
    are work space.
    """
    first = 0
    for i in range(len(states)):
        last = log.ends[i, event_log.SEGMENTS]
        for row in range(first, last):
            until = log.segments[row + 1, body.T] if row + 1 < last else states[i, body.T]
            # From the step's number, not as a running sum, whose rounding errors would add up.
            number = ceil(log.segments[row, body.T] / step - phases[i])
            time = (max(number, 0.0) + phases[i]) * step
            _occupy_segment(
                board, log.segments, row, time, until, step, left, top, cells, counts,
                series, sample,
            )  # fmt: skip
        first = last
