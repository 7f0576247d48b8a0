"""Moves a ball by fixed substeps of semi-implicit Euler; swept tests keep it from tunnelling.

Each substep first gives the ball its new velocity, then moves it along a straight line at that
velocity, and bounces it off surfaces on the way. The path is therefore a chain of straight
segments, with an error of the order of the substep.
"""

from math import sqrt

import numpy as np
import numpy.typing as npt

from plinko.engine.constants import MAX_TIME
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import BoardArrays, cell_of, friction_of, restitution_of
from plinko.engine.exact.event_log import Log, end_ball, land, note_impact, note_segment
from plinko.engine.exact.outcome import (
    BALANCED,
    ESCAPED,
    EVENT_LIMIT,
    LANDED,
    RUNNING,
    TIME_LIMIT,
)
from plinko.engine.jit.decorator import kernel, lean_kernel
from plinko.engine.physics import body, surface
from plinko.engine.physics.array_types import Floats, Ints
from plinko.engine.physics.flight import basis
from plinko.engine.physics.impulse import bounce
from plinko.engine.physics.surface import touch
from plinko.engine.stepped.sweep import sweep

MAX_HITS = 16
"""Impacts in one substep, at most. A ball that reaches this is caught between surfaces, and stands
still for the rest of the substep, so that it cannot be pushed through."""


RESTING = 1.0e-9
"""Relative to the speed that gravity adds in a substep: a slower ball rests. A ball on a
frictionless slope of 1e-9 rad gains this speed in a substep; a ball in a notch jitters at 1e-11."""

ENDLESS = 1 << 62
"""A number of substeps that no drop reaches."""


@lean_kernel
def push_out(board: BoardArrays, state: Floats, correction: float) -> None:
    """Move a ball out of surfaces that it overlaps, by the fraction `correction` of the depth."""
    cell = cell_of(board, state[body.X], state[body.Y])
    if cell < 0:
        return
    items = board.items
    for k in range(board.starts[cell], board.starts[cell + 1]):
        item = int(board.members[k])
        dx = state[body.X] - items[item, surface.X]
        dy = state[body.Y] - items[item, surface.Y]
        reach = items[item, surface.DISTANCE]
        if reach > 0.0:
            dd = dx * dx + dy * dy
            if dd >= reach * reach or dd == 0.0:
                continue
            distance = sqrt(dd)
            push = correction * (reach - distance) / distance
            state[body.X] += push * dx
            state[body.Y] += push * dy
        else:
            foot = dx * items[item, surface.TX] + dy * items[item, surface.TY]
            d = dx * items[item, surface.NX] + dy * items[item, surface.NY]
            if abs(d) >= board.radius or not 0.0 <= foot <= items[item, surface.LENGTH]:
                continue
            push = correction * (board.radius - abs(d))
            if d < 0.0:
                push = -push
            state[body.X] += push * items[item, surface.NX]
            state[body.Y] += push * items[item, surface.NY]


@lean_kernel
def _move(state: Floats, s: float) -> None:
    """Move the state along its straight line by s seconds."""
    state[body.T] += s
    state[body.X] += state[body.VX] * s
    state[body.Y] += state[body.VY] * s
    state[body.THETA] += state[body.OMEGA] * s


@lean_kernel
def _bounce_off(
    board: BoardArrays,
    state: Floats,
    item: int,
    side: float,
    threshold: float,
    lag: float,
    log: Log,
) -> None:
    """Bounce off `item`; an approach slower than the threshold does not rebound.

    Within a substep the velocity is constant, but on the true parabola it changes. `lag`, in m/s
    downwards, is the difference at the time of the impact. The impact acts on the parabola's
    velocity, so that an elastic bounce conserves energy.
    """
    nx, ny, state[body.X], state[body.Y] = touch(
        board.items, board.radius, item, side, state[body.X], state[body.Y]
    )
    approach = -(state[body.VX] * nx + state[body.VY] * ny)
    if approach <= 0.0:
        return
    restitution = restitution_of(board, item)
    if approach < threshold:
        restitution = 0.0
        lag = 0.0
    state[body.VY] += lag
    state[body.VX], state[body.VY], state[body.OMEGA], _ = bounce(
        state[body.VX],
        state[body.VY],
        state[body.OMEGA],
        nx,
        ny,
        board.radius,
        restitution,
        friction_of(board, item),
    )
    if approach >= threshold:
        note_impact(board, state, item, log)
    state[body.VY] -= lag
    outward = state[body.VX] * nx + state[body.VY] * ny
    if outward < 0.0:
        state[body.VX] -= outward * nx
        state[body.VY] -= outward * ny


@lean_kernel
def substep(
    board: BoardArrays,
    state: Floats,
    h: float,
    decay: float,
    gain: float,
    correction: float,
    log: Log,
) -> int:
    """Advance a ball by h seconds; decay = exp(-k h), gain = (1 - decay) / k.

    Returns RUNNING or an outcome. v <- v decay + g gain is the closed form of drag and gravity over
    the substep. A ball that approaches a surface at less than twice the speed that gravity adds in
    a substep lies on it, and does not rebound.
    """
    state[body.VX] = state[body.VX] * decay
    pull = board.gravity * gain
    state[body.VY] = state[body.VY] * decay + pull
    threshold = 2.0 * board.gravity * h
    rest = h
    hits = 0
    left = -1
    while rest > 0.0 and hits < MAX_HITS:
        speed = sqrt(state[body.VX] * state[body.VX] + state[body.VY] * state[body.VY])
        window = rest
        if speed * rest > board.travel:
            window = board.travel / speed
        half = 0.5 * window
        cell = cell_of(
            board, state[body.X] + state[body.VX] * half, state[body.Y] + state[body.VY] * half
        )
        if cell < 0:
            return ESCAPED
        s, item, side = sweep(
            board, cell, state[body.X], state[body.Y], state[body.VX], state[body.VY], window, left
        )
        note_segment(log, state, event_log.IN_FLIGHT, 0.0, 0.0, 0.0)
        if state[body.VY] > 0.0 and state[body.Y] + state[body.VY] * s >= board.bins_y:
            _move(state, (board.bins_y - state[body.Y]) / state[body.VY])
            return LANDED
        _move(state, s)
        rest -= s
        if item >= 0:
            hits += 1
            left = item
            _bounce_off(board, state, item, side, threshold, pull * (0.5 - rest / h), log)
        elif s < window:
            return ESCAPED
    if rest > 0.0:
        _note_freeze(state, log)
    push_out(board, state, correction)
    return RUNNING


@lean_kernel
def _note_freeze(state: Floats, log: Log) -> None:
    """Log that the ball stands still for the rest of the substep."""
    vx = state[body.VX]
    vy = state[body.VY]
    omega = state[body.OMEGA]
    state[body.VX] = 0.0
    state[body.VY] = 0.0
    state[body.OMEGA] = 0.0
    note_segment(log, state, event_log.IN_FLIGHT, 0.0, 0.0, 0.0)
    state[body.VX] = vx
    state[body.VY] = vy
    state[body.OMEGA] = omega


@lean_kernel
def _rests(a: Floats, b: Floats, speed: float, h: float, radius: float) -> bool:
    """Whether a ball rests: between state a and state b, a substep later, it hardly changed.

    Its velocity in both states, its motion per substep, and the change of its spin times the radius
    must be below `speed`, m/s.
    """
    still = abs(a[body.VX]) < speed and abs(a[body.VY]) < speed
    still = still and abs(b[body.VX]) < speed and abs(b[body.VY]) < speed
    still = (
        still and abs(b[body.X] - a[body.X]) < speed * h and abs(b[body.Y] - a[body.Y]) < speed * h
    )
    return bool(still and radius * abs(b[body.OMEGA] - a[body.OMEGA]) < speed)


@lean_kernel
def step_on(
    board: BoardArrays,
    state: Floats,
    before: Floats,
    steps: int,
    h: float,
    decay: float,
    gain: float,
    correction: float,
    log: Log,
) -> int:
    """Substep number `steps` (from 0) of a drop; returns RUNNING or an outcome.

    A ball that rests (see RESTING) is balanced. `before` is work space, shape (7,).
    """
    for column in range(body.SIZE):  # a slice would also compile numpy's broadcasting
        before[column] = state[column]
    outcome = substep(board, state, h, decay, gain, correction, log)
    if outcome != RUNNING:
        return outcome
    state[body.T] = (steps + 1) * h
    if _rests(before, state, RESTING * board.gravity * h, h, board.radius):
        return BALANCED
    if not state[body.T] <= MAX_TIME:
        return TIME_LIMIT
    return RUNNING


@kernel
def step_many(
    board: BoardArrays,
    states: Floats,
    steps: Ints,
    most_steps: int,
    h: float,
    correction: float,
    max_events: int,
    before: Floats,
    log: Log,
    outcomes: npt.NDArray[np.int8],
    bins: npt.NDArray[np.int32],
    impacts: npt.NDArray[np.int32],
) -> None:
    """Advance each ball, independently of the others, by up to `most_steps` substeps.

    states, shape (n, 7), and steps, shape (n,), the number of substeps of each ball, are changed in
    place. Writes each drop's outcome (RUNNING if it goes on), bin (-1 if it did not land) and
    impacts in these steps into arrays of shape (n,). `before` is work space, shape (7,).
    """
    decay, gain, _ = basis(board.drag, h)
    for i in range(len(states)):
        state = states[i]
        event_limit = log.counts[event_log.EVENTS] + max_events
        impacts_before = log.counts[event_log.IMPACTS]
        step = steps[i]
        last = step + most_steps
        outcome = RUNNING
        while outcome == RUNNING and step < last:
            outcome = step_on(board, state, before, step, h, decay, gain, correction, log)
            if outcome == RUNNING and log.counts[event_log.EVENTS] >= event_limit:
                outcome = EVENT_LIMIT
            step += 1
        steps[i] = step
        bins[i] = land(board, state, log) if outcome == LANDED else -1
        outcomes[i] = outcome
        impacts[i] = log.counts[event_log.IMPACTS] - impacts_before
        end_ball(log, i)


def trace_stepped_many(
    board: BoardArrays,
    states: Floats,
    h: float,
    correction: float,
    max_events: int,
    log: Log,
    outcomes: npt.NDArray[np.int8],
    bins: npt.NDArray[np.int32],
    impacts: npt.NDArray[np.int32],
) -> None:
    """`step_many` of balls from their starts, shape (n, 7), to their ends."""
    steps = np.zeros(len(states), np.int64)
    step_many(
        board, states, steps, ENDLESS, h, correction, max_events, np.empty(body.SIZE), log,
        outcomes, bins, impacts,
    )  # fmt: skip
