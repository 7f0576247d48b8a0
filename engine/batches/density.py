"""The occupancy (`plinko.engine.drops.occupancy`) of many drops, which workers compute in parts."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from plinko.engine.batches.workers import Workers
from plinko.engine.board.model import Board
from plinko.engine.drops.occupancy import Occupancy, default_step, occupancy

PART: Final = 1 << 14
"""Drops in a part: about 2 s on one core, for a result of a few megabytes."""


@dataclass(frozen=True, slots=True)
class Grid:
    """A grid over a board: its corner (left, top) in m and its shape (rows, columns)."""

    left: float
    top: float
    cells_per_metre: float
    shape: tuple[int, int]


def occupancy_by(
    workers: Workers,
    board: Board,
    seeds: range,
    grid: Grid,
    progress: Callable[[int], None] | None = None,
) -> Occupancy:
    """The same counts as `plinko.occupancy`, for consecutive seeds, computed by `workers`.

    progress: called now and then with the number of drops done.
    """
    work = partial(_part, board, seeds, grid, default_step(len(seeds)))
    total = _part(board, seeds[:0], grid, default_step(len(seeds)), 0, 1)
    durations = []
    for _, found in workers.compute(work, range(0, len(seeds), PART)):
        durations.append(found.duration)
        total = replace(
            total,
            drops=total.drops + found.drops,
            counts=np.add(total.counts, found.counts),
            histogram=np.add(total.histogram, found.histogram),
            unsettled_count=total.unsettled_count + found.unsettled_count,
        )
        if progress is not None:
            progress(total.drops)
    for array in (total.counts, total.histogram):
        array.setflags(write=False)
    return replace(total, duration=math.fsum(durations))


def _part(
    board: Board, seeds: range, grid: Grid, step: float, begin: int, threads: int
) -> Occupancy:
    some = seeds[begin : begin + PART]
    return occupancy(board, some, step=step, threads=threads, **asdict(grid))
