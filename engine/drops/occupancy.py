"""Occupancy: where the balls of many drops spend their time, on a grid over the board."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import MAX_TIME
from plinko.engine.drops.batch import Seeds, seed_array
from plinko.engine.drops.threads import share, thread_count
from plinko.engine.errors import ParameterError
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.event_log import Log, new_log
from plinko.engine.exact.initial_state import at_rest, in_flight
from plinko.engine.exact.occupancy import occupy
from plinko.engine.exact.outcome import MAX_EVENTS
from plinko.engine.exact.trace import trace_many
from plinko.engine.parameters import number
from plinko.engine.physics import body
from plinko.engine.physics.contact import new_series
from plinko.engine.seeding import start_xs

MOST_CELLS: Final = 1 << 24
SHORTEST_STEP, LONGEST_STEP = 1e-3, 1.6e-2
"""Limits of the time between two samples of a ball, s. Each drop is sampled in its own phase, so a
longer step makes a picture of many drops noisier, but not coarser."""

CHUNK: Final = 128
"""Drops that a thread takes at a time: about 8 ms of work, so that an interrupt is quick."""

_FINE: Final = 10_000  # largest number of drops with the shortest step
_SEGMENTS: Final = 128 * CHUNK  # size of a log, enough for nearly all chunks


@dataclass(frozen=True, eq=False, repr=False)
class Occupancy:
    """The number of samples in each cell of a grid.

    counts: shape (rows, columns), from the corner (left, top) in m to the right and down; each
    sample stands for `step` s. histogram: balls in each bin. unsettled_count: balls that did not
    land. Arrays are read-only.
    """

    board: Board
    drops: int
    step: float
    left: float
    top: float
    cells_per_metre: float
    counts: npt.NDArray[np.int64]
    histogram: npt.NDArray[np.int64]
    unsettled_count: int
    duration: float
    """Sum of the durations of all drops, s."""

    def __repr__(self) -> str:
        rows, columns = self.counts.shape
        return (
            f"<Occupancy of {rows} x {columns} cells by {self.drops:,} drops on "
            f"{self.board.name!r}, {self.unsettled_count} unsettled>"
        )

    @property
    def seconds(self) -> npt.NDArray[np.float64]:
        """Mean time in s that the centre of a ball spends in each cell."""
        seconds = np.multiply(self.counts, self.step / max(self.drops, 1), dtype=np.float64)
        seconds.setflags(write=False)
        return seconds


def occupancy(
    board: Board | str,
    seeds: Seeds,
    *,
    left: float,
    top: float,
    cells_per_metre: float,
    shape: tuple[int, int],
    step: float | None = None,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Occupancy:
    """Compute a drop for each of `seeds` with the exact solver, and count where its centre is.

    board, seeds, threads, progress: as for `drop_many`. left, top: the grid's corner in m. shape:
    its rows and columns. step: time between two samples in s (default: longer for more drops).

    The memory for the grid does not grow with the number of drops. Raises BoardError, SeedError or
    ParameterError naming the bad value.
    """
    board = Board.named(board)
    starts = seed_array(seeds)
    rows, columns = shape
    if rows < 1 or columns < 1 or rows * columns > MOST_CELLS:
        raise ParameterError(
            f"shape is {shape}: it must have 1 to {MOST_CELLS} cells", field="shape"
        )
    chosen = default_step(len(starts)) if step is None else number(step, "step", 1e-6, 1.0)
    cells = number(cells_per_metre, "cells_per_metre", 1e-3, 1e6)
    corner = (number(left, "left", -1e6, 1e6), number(top, "top", -1e6, 1e6))
    work = _Work(board, starts, chosen, corner, cells)
    grids = [np.zeros((rows, columns), np.uint32) for _ in range(thread_count(threads))]
    firsts = range(0, len(starts), CHUNK)
    share(firsts, lambda first, worker: work.run(first, grids[worker]), len(grids), progress)
    landed = work.bins[work.bins >= 0]
    counts: npt.NDArray[np.int64] = np.sum(grids, axis=0, dtype=np.int64)
    histogram = np.bincount(landed, minlength=board.bins.count).astype(np.int64)
    for array in (counts, histogram):
        array.setflags(write=False)
    return Occupancy(
        board=board,
        drops=len(starts),
        step=chosen,
        left=corner[0],
        top=corner[1],
        cells_per_metre=cells,
        counts=counts,
        histogram=histogram,
        unsettled_count=int(len(starts) - len(landed)),
        duration=float(work.durations.sum()),
    )


class _Work:
    """The drops of one call, computed chunk by chunk."""

    def __init__(
        self,
        board: Board,
        seeds: npt.NDArray[np.uint64],
        step: float,
        corner: tuple[float, float],
        cells: float,
    ) -> None:
        self._board = board
        self._starts = start_xs(seeds, board.drop.x, board.drop.jitter)
        # Weyl's sequence distributes the phases of consecutive seeds evenly over a step.
        weyl = seeds * np.uint64(0x9E3779B97F4A7C15)
        self._phases = (weyl >> np.uint64(11)).astype(np.float64) * 2.0**-53
        self._step = step
        self._corner = corner
        self._cells = cells
        self.bins = np.empty(len(seeds), np.int32)
        self.durations = np.empty(len(seeds))

    def run(self, first: int, counts: npt.NDArray[np.uint32]) -> int:
        """Add the samples of the chunk that begins at drop `first` to `counts`; return its size."""
        last = min(first + CHUNK, len(self._starts))
        self._follow(first, last, new_log(0, _SEGMENTS, last - first), counts)
        return last - first

    def _follow(self, first: int, last: int, log: Log, counts: npt.NDArray[np.uint32]) -> None:
        """Compute drops and count their samples, in two parts if they do not fit into the log."""
        arrays = arrays_of(self._board)
        series = new_series()
        states = at_rest(self._starts[first:last], self._board.drop.y)
        outcomes, impacts = np.empty(last - first, np.int8), np.empty(last - first, np.int32)
        trace_many(
            arrays, states, in_flight(len(states)), MAX_EVENTS, MAX_TIME, series, log, outcomes,
            self.bins[first:last], impacts,
        )  # fmt: skip
        needed = int(log.counts[event_log.SEGMENTS])
        if needed <= len(log.segments):
            self.durations[first:last] = states[:, body.T]
            occupy(
                arrays, log, states, self._phases[first:last], self._step, *self._corner,
                self._cells, series, np.empty(body.SIZE), counts,
            )  # fmt: skip
        elif last - first == 1:
            self._follow(first, last, new_log(0, needed, 1), counts)
        else:
            middle = (first + last) // 2
            for part in ((first, middle), (middle, last)):
                self._follow(*part, new_log(0, _SEGMENTS, part[1] - part[0]), counts)


def default_step(drops: int) -> float:
    """Time between two samples of a ball, s, for this number of drops."""
    return min(max(SHORTEST_STEP * drops / _FINE, SHORTEST_STEP), LONGEST_STEP)
