"""What both solvers note of an impact and of a landing."""

import numpy as np
import numpy.typing as npt

from engine.constants import KIND_LANDING, KIND_PEG, KIND_WALL
from engine.exact import event_log
from engine.exact.board_arrays import BoardArrays, bin_of
from engine.exact.event_log import Log, note_event
from engine.jit.decorator import lean_kernel
from engine.physics import body


@lean_kernel
def note_impact(board: BoardArrays, state: npt.NDArray[np.float64], item: int, log: Log) -> None:
    """Note the state right after an impact on `item`."""
    log.counts[event_log.IMPACTS] += 1
    if item < board.peg_count:
        note_event(log, state, KIND_PEG, item)
    else:
        note_event(log, state, KIND_WALL, (item - board.peg_count) // 3)


@lean_kernel
def land(board: BoardArrays, state: npt.NDArray[np.float64], log: Log) -> int:
    """Note the landing, and return its bin."""
    where = bin_of(board, state[body.X])
    note_event(log, state, KIND_LANDING, where)
    return where
