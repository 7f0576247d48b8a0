"""The log of a trace: events for the record, and segments from which any state is computed."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from plinko.engine.constants import KIND_LANDING, KIND_PEG, KIND_WALL
from plinko.engine.exact.board_arrays import BoardArrays, bin_of, surface_index, wall_at
from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats, Ints

# A segment's row: the state at its start, then the law of its motion.
ITEM = 7  # the surface that the ball rolls or slides on, or IN_FLIGHT
SIDE = 8
MODE = 9
SLIP_SIGN = 10
SEGMENT_SIZE = 11
IN_FLIGHT = -1.0

EVENT_SIZE = 6  # t, x, y, vx, vy, omega

# Columns of `counts` and `ends`.
EVENTS = 0
SEGMENTS = 1
IMPACTS = 2
COUNTS = 3


class Log(NamedTuple):
    """Room for n events and m segments; those that do not fit are counted but not written.

    One log has the events of many balls in turn. `ends` has the counts after each of the first b.
    """

    events: Floats  # (n, 6)
    marks: npt.NDArray[np.int32]  # (n, 2): kind, index
    segments: Floats  # (m, 11)
    counts: Ints  # (3,): numbers of events, segments and impacts
    ends: Ints  # (b, 3): the counts at the end of each ball


def new_log(events: int, segments: int, balls: int = 0) -> Log:
    """An empty log with room for these numbers of rows; new_log(0, 0) only counts."""
    return Log(
        np.empty((events, EVENT_SIZE)),
        np.empty((events, 2), np.int32),
        np.empty((segments, SEGMENT_SIZE)),
        np.zeros(COUNTS, np.int64),
        np.zeros((balls, COUNTS), np.int64),
    )


@inner_kernel
def end_ball(log: Log, ball: int) -> None:
    """Record the counts at the end of ball number `ball`."""
    if ball < len(log.ends):
        for column in range(COUNTS):
            log.ends[ball, column] = log.counts[column]


@lean_kernel
def write_event(
    events: Floats,
    marks: npt.NDArray[np.int32],
    row: int,
    t: float,
    x: float,
    y: float,
    vx: float,
    vy: float,
    omega: float,
    kind: int,
    index: int,
) -> None:
    events[row, 0] = t
    events[row, 1] = x
    events[row, 2] = y
    events[row, 3] = vx
    events[row, 4] = vy
    events[row, 5] = omega
    marks[row, 0] = kind
    marks[row, 1] = index


@lean_kernel
def note_event(log: Log, state: Floats, kind: int, index: int) -> None:
    row = log.counts[EVENTS]
    log.counts[EVENTS] = row + 1
    if row < len(log.events):
        write_event(
            log.events, log.marks, row,
            state[body.T], state[body.X], state[body.Y],
            state[body.VX], state[body.VY], state[body.OMEGA], kind, index,
        )  # fmt: skip


@lean_kernel
def write_segment(
    segments: Floats,
    row: int,
    t: float,
    x: float,
    y: float,
    vx: float,
    vy: float,
    theta: float,
    omega: float,
    item: float,
) -> None:
    """Fill one row of a log's segments; SIDE, MODE and SLIP_SIGN, which flight lacks, become 0."""
    segments[row, body.T] = t
    segments[row, body.X] = x
    segments[row, body.Y] = y
    segments[row, body.VX] = vx
    segments[row, body.VY] = vy
    segments[row, body.THETA] = theta
    segments[row, body.OMEGA] = omega
    segments[row, ITEM] = item
    segments[row, SIDE] = 0.0
    segments[row, MODE] = 0.0
    segments[row, SLIP_SIGN] = 0.0


@lean_kernel
def note_segment(
    log: Log,
    state: Floats,
    item: float,
    side: float,
    mode: float,
    slip_sign: float,
) -> None:
    """Append a segment that starts at the state."""
    row = log.counts[SEGMENTS]
    log.counts[SEGMENTS] = row + 1
    if row < len(log.segments):
        write_segment(
            log.segments, row,
            state[body.T], state[body.X], state[body.Y], state[body.VX], state[body.VY],
            state[body.THETA], state[body.OMEGA], item,
        )  # fmt: skip
        log.segments[row, SIDE] = side
        log.segments[row, MODE] = mode
        log.segments[row, SLIP_SIGN] = slip_sign


@lean_kernel
def note_impact(board: BoardArrays, state: Floats, item: int, log: Log) -> None:
    """Append the state right after an impact on `item`."""
    log.counts[IMPACTS] += 1
    if item < board.peg_count:
        note_event(log, state, KIND_PEG, item)
    else:
        note_event(log, state, KIND_WALL, wall_at(board, item, state[body.X], state[body.Y]))


@inner_kernel
def note_contact(board: BoardArrays, state: Floats, kind: int, item: int, log: Log) -> None:
    """Append that a contact with `item` begins, changes or ends."""
    note_event(log, state, kind, surface_index(board, item, state[body.X], state[body.Y]))


@lean_kernel
def land(board: BoardArrays, state: Floats, log: Log) -> int:
    """Append the landing; returns its bin."""
    where = bin_of(board, state[body.X])
    note_event(log, state, KIND_LANDING, where)
    return where
