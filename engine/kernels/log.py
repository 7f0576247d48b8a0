"""What a trace writes down: events for the record and segments for states at any time."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from engine.kernels.jit import kernel

# The state of a ball while it is traced.
T = 0
PX = 1
PY = 2
VX = 3
VY = 4
THETA = 5
OMEGA = 6
STATE_SIZE = 7

# A segment's row: the state at its start, then what moves the ball from there.
ITEM = 7  # the surface it rides, or -1 in flight
SIDE = 8
MODE = 9
SLIP_SIGN = 10
SEGMENT_SIZE = 11
IN_FLIGHT = -1.0

EVENT_SIZE = 6  # t, x, y, vx, vy, omega

EVENTS = 0
SEGMENTS = 1
IMPACTS = 2


class Log(NamedTuple):
    """Room for n events and m segments; what does not fit is counted and left out."""

    events: npt.NDArray[np.float64]  # (n, 6)
    marks: npt.NDArray[np.int32]  # (n, 2): kind, index
    segments: npt.NDArray[np.float64]  # (m, 11)
    counts: npt.NDArray[np.int64]  # (3,): events, segments, impacts so far


def new_log(events: int, segments: int) -> Log:
    """An empty log with room for so many rows of each; Log(0, 0) only counts."""
    return Log(
        np.empty((events, EVENT_SIZE)),
        np.empty((events, 2), np.int32),
        np.empty((segments, SEGMENT_SIZE)),
        np.zeros(3, np.int64),
    )


@kernel
def note_event(log: Log, state: npt.NDArray[np.float64], kind: int, index: int) -> None:
    """Append the state as an event."""
    row = log.counts[EVENTS]
    log.counts[EVENTS] = row + 1
    if row < log.events.shape[0]:
        event = log.events[row]
        event[0] = state[T]
        event[1] = state[PX]
        event[2] = state[PY]
        event[3] = state[VX]
        event[4] = state[VY]
        event[5] = state[OMEGA]
        log.marks[row, 0] = kind
        log.marks[row, 1] = index


@kernel
def note_segment(
    log: Log,
    state: npt.NDArray[np.float64],
    item: float,
    side: float,
    mode: float,
    slip_sign: float,
) -> None:
    """Append a stretch of closed-form motion that starts at the state."""
    row = log.counts[SEGMENTS]
    log.counts[SEGMENTS] = row + 1
    if row < log.segments.shape[0]:
        segment = log.segments[row]
        for i in range(STATE_SIZE):
            segment[i] = state[i]
        segment[ITEM] = item
        segment[SIDE] = side
        segment[MODE] = mode
        segment[SLIP_SIGN] = slip_sign
