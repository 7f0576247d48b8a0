"""Follow one ball with the kernel for many, on any arrays of a board and with any limits."""

import numpy as np
import numpy.typing as npt

from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.event_log import Log
from plinko.engine.exact.initial_state import in_flight
from plinko.engine.exact.trace import trace_many
from plinko.engine.physics.contact import new_series


def trace(
    layout: BoardArrays, state: npt.NDArray[np.float64], max_events: int, max_time: float, log: Log
) -> tuple[int, int]:
    """Return outcome and bin (-1 if not landed); `state`, shape (7,), becomes the last state."""
    outcome, where, impacts = np.zeros(1, np.int8), np.zeros(1, np.int32), np.zeros(1, np.int32)
    trace_many(
        layout, state.reshape(1, -1), in_flight(1), max_events, max_time, new_series(), log,
        outcome, where, impacts,
    )  # fmt: skip
    return int(outcome[0]), int(where[0])
