"""Many balls of a billiard moved to one instant: the exact solver's flights, cell by cell."""

from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from plinko.engine.exact import event_log, free_flight, initial_state, next_impact
from plinko.engine.exact.board_arrays import BoardArrays, friction_of, restitution_of
from plinko.engine.exact.event_log import Log
from plinko.engine.exact.outcome import EVENT_LIMIT
from plinko.engine.jit.decorator import inner_kernel, kernel
from plinko.engine.physics import body, tangent
from plinko.engine.physics.flight import advance_flight
from plinko.engine.physics.surface import curvature, touch
from plinko.engine.physics.tangent import (
    bounce_tangent,
    delay,
    flight_rates,
    shift,
    through_flight,
)

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# How a ball's flow ended.
REACHED = 0
STAYED = 1
ESCAPED = 2
IMPACT_LIMIT = 3

REASONS = (
    "",
    "stayed: a bounce died, and the ball rolls or slides, which a flow does not follow",
    "escaped: too long a flight that hits nothing, away from the board",
    "impact limit: more impacts than the allowed number",
)

HALVINGS = 64
"""A tangent longer than 2^64 is divided by 2^64, which is exact, and counted."""

_LARGE = 2.0**HALVINGS


class Repeat(NamedTuple):
    """How pegs repeat. A flight is followed for `hop` m at a time, from within the first cell.

    `along` and `across`, two numbers each, turn a place into parts of the cell's two vectors. All
    zero but the hop on an open board, where nothing repeats.
    """

    ax: float  # m, the cell's vectors
    ay: float
    bx: float
    by: float
    along_x: float  # 1/m
    along_y: float
    across_x: float
    across_y: float
    pegs: int  # in a cell
    side: int  # cells in a row of copies
    hop: float  # m


class Balls(NamedTuple):
    """n balls, all changed in place."""

    states: Floats  # (n, 7)
    cells: Ints  # (n, 2): whole vectors of the cell by which a ball is farther than its state says
    impacts: Ints  # (n,) so far
    outcomes: npt.NDArray[np.int8]  # (n,)
    tangents: Floats  # (n, 5), or (n, 0) for none
    halvings: Ints  # (n,): how often a tangent was divided by 2^64

    def copy(self) -> "Balls":
        """The same balls in arrays of their own."""
        return Balls(
            self.states.copy(), self.cells.copy(), self.impacts.copy(), self.outcomes.copy(),
            self.tangents.copy(), self.halvings.copy(),
        )  # fmt: skip


class Space(NamedTuple):
    """Work space of a flow."""

    before: Floats  # (7,): the state at the start of a flight
    hit: Floats  # (7,): the state at its end, before the impact
    rates: Floats  # (5,)
    log: Log  # counts alone


def new_space() -> Space:
    """Work space full of zeros."""
    state = np.zeros(body.SIZE)
    return Space(state, state.copy(), np.zeros(tangent.TANGENT_SIZE), event_log.new_log(0, 0))


@inner_kernel
def _hop_time(state: Floats, gravity: float, hop: float) -> float:
    """Seconds in which a ball moves `hop` m at most; drag only makes it slower."""
    vx = state[body.VX]
    vy = state[body.VY]
    speed = sqrt(vx * vx + vy * vy)
    divisor = speed + sqrt(speed * speed + 2.0 * gravity * hop)
    return 2.0 * hop / divisor if divisor > 0.0 else np.inf


@inner_kernel
def _into_first_cell(repeat: Repeat, state: Floats, cell: Ints, item: int) -> int:
    """Move a ball and the surface it left by whole cells; returns that surface's number there."""
    a = _floor(repeat.along_x * state[body.X] + repeat.along_y * state[body.Y])
    b = _floor(repeat.across_x * state[body.X] + repeat.across_y * state[body.Y])
    if a != 0 or b != 0:
        state[body.X] -= a * repeat.ax + b * repeat.bx
        state[body.Y] -= a * repeat.ay + b * repeat.by
        cell[0] += a
        cell[1] += b
        item -= (a * repeat.side + b) * repeat.pegs
    return item


@inner_kernel
def _floor(value: float) -> int:
    """Largest whole number that is at most `value`, which is a few cells."""
    whole = int(value)
    return whole - 1 if whole > value else whole


@inner_kernel
def _fly(board: BoardArrays, state: Floats, vector: Floats, s: float) -> None:
    """Move a ball, and its tangent if it has one, by s seconds of free flight."""
    advance_flight(state, board.gravity, board.drag, s)
    if len(vector) > 0:
        through_flight(vector, board.drag, s)


@inner_kernel
def _tangent_through_impact(
    board: BoardArrays, space: Space, state: Floats, item: int, side: float, vector: Floats
) -> None:
    """Take a tangent through a flight and the impact that ended it; `state` is right after it."""
    hit = space.hit
    rates = space.rates
    for i in range(body.SIZE):
        hit[i] = space.before[i]
    s = state[body.T] - hit[body.T]
    advance_flight(hit, board.gravity, board.drag, s)
    through_flight(vector, board.drag, s)
    nx, ny, _, _ = touch(board.items, board.radius, item, side, hit[body.X], hit[body.Y])
    later = delay(vector, nx, ny, hit[body.VX], hit[body.VY])
    flight_rates(hit[body.VX], hit[body.VY], board.gravity, board.drag, rates)
    shift(vector, rates, later)
    bounce_tangent(
        vector, hit[body.VX], hit[body.VY], hit[body.OMEGA], nx, ny, curvature(board.items, item),
        board.radius, restitution_of(board, item), friction_of(board, item),
    )  # fmt: skip
    flight_rates(state[body.VX], state[body.VY], board.gravity, board.drag, rates)
    shift(vector, rates, -later)


@inner_kernel
def _halve(vector: Floats) -> int:
    """Divide a tangent by 2^64 if it has grown beyond; returns how often that was done, 0 or 1."""
    size = 0.0
    for i in range(tangent.TANGENT_SIZE):
        size = max(size, abs(vector[i]))
    if size <= _LARGE:
        return 0
    for i in range(tangent.TANGENT_SIZE):
        vector[i] /= _LARGE
    return 1


@inner_kernel
def _follow_to_impact(
    board: BoardArrays, state: Floats, item: int, side: float, how: int, end: float, log: Log
) -> tuple[int, int, float, int]:
    """`follow_flight` for one impact: the cause, the surface and side, and how it was left.

    Of two impacts at one instant each is an impact of its own.
    """
    limit = log.counts[event_log.EVENTS] + 1
    cause, item, side, met, met_side, how, _ = free_flight.follow_flight(
        board, state, item, side, how, initial_state.NONE, False, limit, end, log
    )
    if cause == free_flight.MET_ANOTHER:
        cause, item, side, _, _, how, _ = free_flight.follow_flight(
            board, state, met, met_side, how, initial_state.NONE, True, limit, end, log
        )
    return cause, item, side, how


@kernel
def flow_many(
    board: BoardArrays,
    repeat: Repeat,
    balls: Balls,
    until: float,
    max_impacts: int,
    space: Space,
) -> None:
    """Move each ball to the time `until`, in s, or as far as its outcome says.

    Each flight and bounce is `follow_flight`'s, asked for one impact; one that would come after
    `until` is not made: the ball flies there instead.
    """
    before = space.before
    for i in range(len(balls.states)):
        if balls.outcomes[i] != REACHED:
            continue
        state = balls.states[i]
        cell = balls.cells[i]
        vector = balls.tangents[i]
        item, side, how = 0, 0.0, next_impact.FREE
        while state[body.T] < until:
            if balls.impacts[i] >= max_impacts:
                balls.outcomes[i] = IMPACT_LIMIT
                break
            for column in range(body.SIZE):
                before[column] = state[column]
            t = state[body.T]
            end = min(until, t + _hop_time(state, board.gravity, repeat.hop))
            cause, item, side, how = _follow_to_impact(
                board, state, item, side, how, end, space.log
            )
            hit_one = cause in (EVENT_LIMIT, free_flight.ON_SURFACE)
            if not hit_one or state[body.T] > until:
                for column in range(body.SIZE):
                    state[column] = before[column]
                _fly(board, state, vector, end - t)
                state[body.T] = end
                item, how = 0, next_impact.FREE
                if repeat.side == 0 and end < until:
                    balls.outcomes[i] = ESCAPED
                    break
            else:
                balls.impacts[i] += 1
                if len(vector) > 0:
                    _tangent_through_impact(board, space, state, item, side, vector)
                    balls.halvings[i] += _halve(vector)
                if cause == free_flight.ON_SURFACE:
                    balls.outcomes[i] = STAYED
                    break
            if repeat.side > 0:
                item = _into_first_cell(repeat, state, cell, item)
