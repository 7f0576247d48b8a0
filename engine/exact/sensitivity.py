"""Estimates how certain a drop is, by two tangents that are carried along the log of its trace.

The first is the change of the path per metre by which the start moves. The second is an error: it
begins as the start's rounding, and at each event grows by the rounding of that event, in the
direction in which it already points. A contact phase can make a ball forget earlier errors, but not
later ones; only the second tangent shows this. Both are first-order, and say nothing if the error
is as large as a ball.
"""

from math import copysign, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from plinko.engine.constants import (
    KIND_CONTACT_BEGIN,
    KIND_CONTACT_CHANGE,
    KIND_CONTACT_END,
    KIND_LANDING,
    KIND_WALL,
)
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import BoardArrays, friction_of, law_on, restitution_of
from plinko.engine.exact.sampling import sample_segment
from plinko.engine.exact.sustained_contact import start_series
from plinko.engine.jit.decorator import inner_kernel, kernel
from plinko.engine.physics import body, contact, surface, tangent
from plinko.engine.physics.array_types import Floats
from plinko.engine.physics.contact import new_series
from plinko.engine.physics.series import Series
from plinko.engine.physics.surface import curvature, side_of, touch
from plinko.engine.physics.tangent import (
    bounce_tangent,
    contact_rates,
    delay,
    flight_rates,
    shift,
    through_contact,
    through_flight,
)

PATH = 0
ERROR = 1
TANGENTS = 2

ROUNDING = 2.220446049250313e-16
"""Relative rounding of an event, 2^-52: two results, each rounded by half a unit."""


class Space(NamedTuple):
    series: Series
    variation: Series
    tangents: Floats  # (TANGENTS, TANGENT_SIZE)
    rates: Floats  # (TANGENT_SIZE,)
    delays: Floats  # (TANGENTS,)
    state: Floats  # (STATE_SIZE,)


def new_space() -> Space:
    """Work space of zeros, the initial values of tangents and delays."""
    return Space(
        new_series(),
        np.zeros((tangent.VARIATION_ROWS, contact.ORDER + 1)),
        np.zeros((TANGENTS, tangent.TANGENT_SIZE)),
        np.zeros(tangent.TANGENT_SIZE),
        np.zeros(TANGENTS),
        np.zeros(body.SIZE),
    )


@inner_kernel
def _part(board: BoardArrays, wall: int, x: float, y: float) -> int:
    """The item of a wall that a ball at (x, y) touches: the line or one of its ends."""
    line = int(board.items[board.peg_count + 3 * wall, surface.OWNER])
    row = board.items[line]
    foot = (x - row[surface.X]) * row[surface.TX] + (y - row[surface.Y]) * row[surface.TY]
    if foot < 0.0:
        return int(row[surface.FIRST_END])
    if foot > row[surface.LENGTH]:
        return int(row[surface.LAST_END])
    return line


@inner_kernel
def _rates_of(board: BoardArrays, segment: Floats, state: Floats, rates: Floats) -> None:
    """Write the rates of `state` under a segment's law into `rates`."""
    if segment[event_log.ITEM] < 0.0:
        flight_rates(state[body.VX], state[body.VY], board.gravity, board.drag, rates)
        return
    if int(segment[event_log.MODE]) == contact.HELD:
        for i in range(tangent.TANGENT_SIZE):
            rates[i] = 0.0
        rates[tangent.DOMEGA] = segment[event_log.SLIP_SIGN]
        return
    item = int(segment[event_log.ITEM])
    nx, ny, _, _ = touch(
        board.items, board.radius, item, segment[event_log.SIDE], state[body.X], state[body.Y]
    )
    u = state[body.VY] * nx - state[body.VX] * ny
    contact_rates(
        nx, ny, u, state[body.OMEGA], int(segment[event_log.MODE]), segment[event_log.SLIP_SIGN],
        law_on(board, item), rates,
    )  # fmt: skip


@inner_kernel
def _take_along(
    board: BoardArrays,
    segment: Floats,
    s: float,
    series: Series,
    variation: Series,
    tangents: Floats,
) -> None:
    """Carry the tangents through a segment of s seconds."""
    if segment[event_log.ITEM] < 0.0:
        for i in range(TANGENTS):
            through_flight(tangents[i], board.drag, s)
        return
    item = int(segment[event_log.ITEM])
    mode = int(segment[event_log.MODE])
    if mode == contact.HELD:
        return
    start_series(
        board, series, segment, item, segment[event_log.SIDE], mode, segment[event_log.SLIP_SIGN]
    )
    law = law_on(board, item)
    for i in range(TANGENTS):
        through_contact(tangents[i], series, variation, s, mode, segment[event_log.SLIP_SIGN], law)


@inner_kernel
def _contact_delay(
    board: BoardArrays,
    segment: Floats,
    state: Floats,
    rates: Floats,
    following: Floats,
    kind: int,
    vector: Floats,
) -> float:
    """Delay of the end of a contact segment, in s per unit of the tangent.

    The end is where one quantity is zero: the delay is minus its change over its rate.
    """
    if int(segment[event_log.MODE]) == contact.HELD:  # the spin becomes zero
        return float(-vector[tangent.DOMEGA] / segment[event_log.SLIP_SIGN])
    item = int(segment[event_log.ITEM])
    bend, gravity, drag, friction, _ = law_on(board, item)
    nx, ny, _, _ = touch(
        board.items, board.radius, item, segment[event_log.SIDE], state[body.X], state[body.Y]
    )
    u = state[body.VY] * nx - state[body.VX] * ny
    along = vector[tangent.DY] * nx - vector[tangent.DX] * ny
    change = vector[tangent.DVY] * nx - vector[tangent.DVX] * ny
    if (
        kind == KIND_CONTACT_CHANGE and int(following[event_log.ITEM]) != item
    ):  # at a fixed position, a line's end
        return -along / u if u != 0.0 else 0.0
    rate = rates[tangent.DVY] * nx - rates[tangent.DVX] * ny
    # Changes of the normal force, per second and per unit of the tangent.
    slope = -gravity * bend * u * nx - 2.0 * bend * u * rate
    offset = -gravity * bend * along * nx - 2.0 * bend * u * change
    if (
        kind == KIND_CONTACT_CHANGE and int(segment[event_log.MODE]) == contact.SLIDING
    ):  # the slip becomes zero
        slope = rate - board.radius * rates[tangent.DOMEGA]
        offset = change - board.radius * vector[tangent.DOMEGA]
    elif kind == KIND_CONTACT_CHANGE:  # rolling needs all friction that Coulomb's law allows
        sign = following[event_log.SLIP_SIGN]
        share = 3.0 * friction
        slope = share * slope + sign * (gravity * bend * u * ny + drag * rate)
        offset = share * offset + sign * (gravity * bend * along * ny + drag * change)
    return -offset / slope if slope != 0.0 else 0.0


@inner_kernel
def _add_rounding(vector: Floats, state: Floats, nx: float, ny: float) -> None:
    """Add an event's rounding: of the position along the surface, of velocity and of spin."""
    along = vector[tangent.DY] * nx - vector[tangent.DX] * ny
    place = copysign(ROUNDING * (abs(state[body.X]) + abs(state[body.Y])), along)
    vector[tangent.DX] -= place * ny
    vector[tangent.DY] += place * nx
    speed = ROUNDING * (abs(state[body.VX]) + abs(state[body.VY]))
    vector[tangent.DVX] += copysign(speed, vector[tangent.DVX])
    vector[tangent.DVY] += copysign(speed, vector[tangent.DVY])
    vector[tangent.DOMEGA] += copysign(ROUNDING * abs(state[body.OMEGA]), vector[tangent.DOMEGA])


@inner_kernel
def _bounce(
    board: BoardArrays,
    item: int,
    left: int,
    state: Floats,
    rates: Floats,
    tangents: Floats,
    delays: Floats,
) -> None:
    """Carry the tangents through an impact on `item`; `state` is the one before it.

    The tangents then belong to the state at the event, which comes `delays` later. The error also
    grows by a rounding across the surface, unless the ball returns to the surface `left`: its root
    at the start was divided out, so its distance to that surface has no rounding.
    """
    side = side_of(board.items, item, state[body.X], state[body.Y])
    nx, ny, _, _ = touch(board.items, board.radius, item, side, state[body.X], state[body.Y])
    if item != left:
        across = tangents[ERROR, tangent.DX] * nx + tangents[ERROR, tangent.DY] * ny
        depth = copysign(ROUNDING * (abs(state[body.X]) + abs(state[body.Y])), across)
        tangents[ERROR, tangent.DX] += depth * nx
        tangents[ERROR, tangent.DY] += depth * ny
    for i in range(TANGENTS):
        delays[i] = delay(tangents[i], nx, ny, state[body.VX], state[body.VY])
        shift(tangents[i], rates, delays[i])
        bounce_tangent(
            tangents[i], state[body.VX], state[body.VY], state[body.OMEGA], nx, ny,
            curvature(board.items, item), board.radius, restitution_of(board, item),
            friction_of(board, item),
        )  # fmt: skip
    _add_rounding(tangents[ERROR], state, nx, ny)


@inner_kernel
def _forget_place(board: BoardArrays, segment: Floats, tangents: Floats) -> None:
    """Set the tangents to zero, except the spin's, if two surfaces have stopped the ball.

    Balls from neighbouring starts stop at the same place.
    """
    if segment[event_log.ITEM] < 0.0 or segment[body.VX] != 0.0 or segment[body.VY] != 0.0:
        return
    for i in range(TANGENTS):
        for column in (tangent.DX, tangent.DY, tangent.DVX, tangent.DVY):
            tangents[i, column] = 0.0
    nx, ny, _, _ = touch(
        board.items, board.radius, int(segment[event_log.ITEM]), segment[event_log.SIDE],
        segment[body.X], segment[body.Y],
    )  # fmt: skip
    _add_rounding(tangents[ERROR], segment, nx, ny)


@inner_kernel
def _put_behind(event: Floats, state: Floats) -> None:
    """Set `state` to the one right after an impact."""
    state[body.X] = event[1]
    state[body.Y] = event[2]
    state[body.VX] = event[3]
    state[body.VY] = event[4]
    state[body.OMEGA] = event[5]


@inner_kernel
def _write(tangents: Floats, out: Floats) -> None:
    for i in range(TANGENTS):
        out[i] = sqrt(
            tangents[i, tangent.DX] * tangents[i, tangent.DX]
            + tangents[i, tangent.DY] * tangents[i, tangent.DY]
        )


@kernel
def sensitivity(
    board: BoardArrays,
    segments: Floats,
    events: Floats,
    marks: npt.NDArray[np.int32],
    end: Floats,
    start_rounding: float,
    space: Space,
    out: Floats,
) -> None:
    """Write how far the position of each event moves into `out`, shape (events, 2).

    The first column is per metre by which the start moves in x. The second is the estimated error
    of the position in m, which is `start_rounding` at the start. `space` must be a new one.
    """
    series, variation, tangents, rates, delays, state = space
    tangents[PATH, tangent.DX] = 1.0
    tangents[ERROR, tangent.DX] = start_rounding
    total = len(marks)
    at = 0
    left = -1
    for k in range(len(segments)):
        segment = segments[k]
        last = k + 1 == len(segments)
        following = segment if last else segments[k + 1]
        in_flight = segment[event_log.ITEM] < 0.0
        _forget_place(board, segment, tangents)
        # Tangents at the last event, which is delayed, become tangents at a fixed time.
        _rates_of(board, segment, segment, rates)
        for i in range(TANGENTS):
            shift(tangents[i], rates, -delays[i])
            delays[i] = 0.0
        until = end[body.T] if last else following[body.T]
        sample_segment(board, segments, k, until, False, series, state)
        _take_along(board, segment, until - segment[body.T], series, variation, tangents)
        _rates_of(board, segment, state, rates)
        first = True
        while at < total and events[at, 0] <= until:
            kind = marks[at, 0]
            if kind == KIND_LANDING:
                for i in range(TANGENTS):
                    shift(
                        tangents[i],
                        rates,
                        delay(tangents[i], 0.0, 1.0, state[body.VX], state[body.VY]),
                    )
                tangents[ERROR, tangent.DX] += copysign(
                    ROUNDING * (abs(state[body.X]) + abs(state[body.Y])),
                    tangents[ERROR, tangent.DX],
                )
                _write(tangents, out[at])
                return
            if kind < KIND_CONTACT_BEGIN:
                if not first:  # at the same time as the impact before
                    flight_rates(state[body.VX], state[body.VY], board.gravity, board.drag, rates)
                    for i in range(TANGENTS):
                        shift(tangents[i], rates, -delays[i])
                item = marks[at, 1]
                if kind == KIND_WALL:
                    item = _part(board, marks[at, 1], state[body.X], state[body.Y])
                if not in_flight:
                    left = int(segment[event_log.ITEM])
                _bounce(board, item, left, state, rates, tangents, delays)
                _put_behind(events[at], state)
                left = item
                in_flight = True
            elif first and not in_flight and kind in (KIND_CONTACT_CHANGE, KIND_CONTACT_END):
                for i in range(TANGENTS):
                    delays[i] = _contact_delay(
                        board, segment, state, rates, following, kind, tangents[i]
                    )
                    shift(tangents[i], rates, delays[i])
                left = int(segment[event_log.ITEM])
                nx, ny, _, _ = touch(
                    board.items,
                    board.radius,
                    left,
                    segment[event_log.SIDE],
                    state[body.X],
                    state[body.Y],
                )
                _add_rounding(tangents[ERROR], state, nx, ny)
            first = False
            _write(tangents, out[at])
            at += 1
