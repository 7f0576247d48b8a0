"""Where balls spend their time: drops are followed and counted in cells, at equal time steps."""

from math import ceil

import numpy as np
import numpy.typing as npt

from engine.kernels.contact import new_series
from engine.kernels.flight import basis
from engine.kernels.jit import inner_kernel, kernel
from engine.kernels.layout import Layout
from engine.kernels.log import ITEM, PX, PY, SEGMENTS, STATE_SIZE, VX, VY, Log, T
from engine.kernels.series import Series
from engine.solvers.exact import trace_many
from engine.solvers.sample import sample_segment

Array = npt.NDArray[np.float64]
Counts = npt.NDArray[np.uint32]


@inner_kernel
def _count(counts: Counts, left: float, top: float, cells: float, x: float, y: float) -> None:
    """Count a place in m; outside of the grid it is left out, and a NaN is outside."""
    column = (x - left) * cells
    row = (y - top) * cells
    if 0.0 <= column < counts.shape[1] and 0.0 <= row < counts.shape[0]:
        counts[int(row), int(column)] += np.uint32(1)


@inner_kernel
def _occupy_segment(
    board: Layout,
    segments: Array,
    row: int,
    time: float,
    until: float,
    step: float,
    left: float,
    top: float,
    cells: float,
    counts: Counts,
    series: Series,
    state: Array,
) -> float:
    """Count a segment at `time`, `time` + step … before `until`; the first time not counted."""
    if time >= until:
        return time
    if segments[row, ITEM] >= 0.0:
        while time < until:
            sample_segment(board, segments, row, time, False, series, state)
            _count(counts, left, top, cells, state[PX], state[PY])
            time += step
        return time
    # In flight each step is the same linear map: exact, and a tenth of the work of a sample.
    sample_segment(board, segments, row, time, False, series, state)
    x = state[PX]
    y = state[PY]
    vx = state[VX]
    vy = state[VY]
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
def occupy_many(
    board: Layout,
    xs: Array,
    y: float,
    phases: Array,
    max_events: int,
    max_time: float,
    step: float,
    left: float,
    top: float,
    cells: float,
    log: Log,
    counts: Counts,
    bins: npt.NDArray[np.int32],
    durations: Array,
) -> int:
    """Drop a ball at rest from each (xs[i], y) and count where it is every `step` s.

    A drop is looked at phases[i] steps after its start, and then every step until it ends. counts
    has shape (rows, columns), `cells` a metre, its corner at (left, top). bins and durations, shape
    (n,), are filled as by `trace_many`. Returns how many drops were done: fewer than n when the
    next one, whose length log.counts tells, does not fit into the log.
    """
    series = new_series()
    states = np.zeros((1, STATE_SIZE))
    state = states[0]
    sample = np.zeros(STATE_SIZE)
    outcomes = np.zeros(1, np.int8)
    impacts = np.zeros(1, np.int32)
    for i in range(len(xs)):
        state[:] = 0.0
        state[PX] = xs[i]
        state[PY] = y
        trace_many(board, states, max_events, max_time, log, outcomes, bins[i : i + 1], impacts)
        used = log.counts[SEGMENTS]
        if used > log.segments.shape[0]:
            return i
        durations[i] = state[T]
        for row in range(used):
            until = log.segments[row + 1, T] if row + 1 < used else state[T]
            # From the number of the step, not from a running sum: no error adds up.
            number = ceil(log.segments[row, T] / step - phases[i])
            time = (max(number, 0.0) + phases[i]) * step
            _occupy_segment(
                board, log.segments, row, time, until, step, left, top, cells, counts,
                series, sample,
            )  # fmt: skip
    return len(xs)
