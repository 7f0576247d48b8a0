"""What both solvers note of an impact and of a landing."""

import numpy as np
import numpy.typing as npt

from engine.constants import KIND_LANDING, KIND_PEG, KIND_WALL
from engine.exact.event_log import IMPACTS, Log, note_event
from engine.jit.decorator import lean_kernel
from engine.physics.ball import PX
from engine.physics.layout import Layout, bin_of


@lean_kernel
def note_impact(board: Layout, state: npt.NDArray[np.float64], item: int, log: Log) -> None:
    """Note the state right after an impact on `item`."""
    log.counts[IMPACTS] += 1
    if item < board.peg_count:
        note_event(log, state, KIND_PEG, item)
    else:
        note_event(log, state, KIND_WALL, (item - board.peg_count) // 3)


@lean_kernel
def land(board: Layout, state: npt.NDArray[np.float64], log: Log) -> int:
    """Note the landing, and return its bin."""
    where = bin_of(board, state[PX])
    note_event(log, state, KIND_LANDING, where)
    return where
