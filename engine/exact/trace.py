"""The exact solver: closed-form flight, the next impact found to the last bits, impulse, repeat."""

import numpy as np
import numpy.typing as npt

from engine.constants import KIND_CONTACT_BEGIN, KIND_CONTACT_END
from engine.exact import event_log, free_flight, initial_state, next_impact, sustained_contact
from engine.exact.board_arrays import BoardArrays, surface_index
from engine.exact.event_log import Log, end_ball, land, note_event
from engine.exact.initial_state import Ints
from engine.exact.outcome import BALANCED, ESCAPED, EVENT_LIMIT, LANDED, RUNNING, TIME_LIMIT, WEDGED
from engine.jit.decorator import inner_kernel, kernel
from engine.physics import body
from engine.physics.series import Series
from engine.physics.surface import is_wedged, touch

State = npt.NDArray[np.float64]


@inner_kernel
def _comes_to_rest(
    board: BoardArrays, state: State, item: int, side: float, hit: int, hit_side: float
) -> bool:
    """Whether a ball that rolled or slid on `item` into `hit` has no speed left to go on with."""
    ax, ay, _, _ = touch(board.items, board.radius, item, side, state[body.X], state[body.Y])
    bx, by, _, _ = touch(board.items, board.radius, hit, hit_side, state[body.X], state[body.Y])
    slow = state[body.VX] * bx + state[body.VY] * by >= -free_flight.DYING_BOUNCE
    return slow and is_wedged(board.gravity, ax, ay, bx, by)


@kernel
def trace_many(
    board: BoardArrays,
    states: State,
    initial: Ints,
    max_events: int,
    max_time: float,
    series: Series,
    log: Log,
    outcomes: npt.NDArray[np.int8],
    bins: npt.NDArray[np.int32],
    impacts: npt.NDArray[np.int32],
) -> None:
    """Follow each ball from its row of `states`, shape (n, 7), changed in place, until it ends.

    initial, shape (n, COLUMNS), says where in its drop the ball is by then; nothing but impacts
    may have gone before. Writes down how each drop ended, its bin, -1 if it did not land, and its
    number of impacts, all of shape (n,). `series` is work space. One function for one ball and for
    many: the machine code of all of a drop is then made once.

    A ball that ended with EVENT_LIMIT can be gone on with: its row of `initial` says from where,
    and the bits are those of a drop that was never interrupted.
    """
    for i in range(len(states)):
        state = states[i]
        before = initial[i, initial_state.IMPACTS_BEFORE]
        event_limit = log.counts[event_log.EVENTS] + max_events - before
        impacts_before = log.counts[event_log.IMPACTS] - before
        item = int(initial[i, initial_state.HIT])
        side = float(initial[i, initial_state.HIT_SIDE])
        touching = item != initial_state.NONE
        how = int(initial[i, initial_state.PHASE])
        if not touching:
            item = int(initial[i, initial_state.SURFACE])
            side = float(initial[i, initial_state.SIDE])
        roots = int(initial[i, initial_state.SLIP_ROOTS])
        slip_sign = float(initial[i, initial_state.SLIP_SIGN])
        outcome = RUNNING
        bins[i] = -1
        while outcome == RUNNING:
            if how != initial_state.LYING:
                bounces = log.counts[event_log.IMPACTS]
                end, item, side, sticks = free_flight.follow_flight(
                    board, state, item, side, how, touching, event_limit, max_time, log
                )
                if end != free_flight.ON_SURFACE:
                    outcome = _ends_in_flight(end)
                    if log.counts[event_log.IMPACTS] > bounces:
                        how = next_impact.BOUNCED
                    break
                note_event(log, state, KIND_CONTACT_BEGIN, surface_index(board, item))
                roots = 1 if sticks else 0
                slip_sign = 0.0
            how = next_impact.BOUNCED
            cause, item, side, hit, hit_side = sustained_contact.follow_contact(
                board, series, state, item, side, roots, slip_sign, max_time, event_limit, log
            )
            touching = cause == sustained_contact.HIT
            if touching:
                if _comes_to_rest(board, state, item, side, hit, hit_side):
                    outcome = WEDGED
                item = hit
                side = hit_side
                continue
            outcome = _ends_in_contact(cause)
            if outcome == EVENT_LIMIT:
                how = initial_state.LYING
                roots = hit
                slip_sign = hit_side
            if outcome == RUNNING:
                how = (
                    next_impact.ROLLED_OFF
                    if cause == sustained_contact.LEFT
                    else next_impact.BOUNCED
                )
                note_event(log, state, KIND_CONTACT_END, surface_index(board, item))
        if outcome == LANDED:
            bins[i] = land(board, state, log)
        if outcome == EVENT_LIMIT:
            initial[i, initial_state.HIT] = initial_state.NONE
            initial[i, initial_state.SURFACE] = item
            initial[i, initial_state.SIDE] = int(side)
            initial[i, initial_state.PHASE] = how
            initial[i, initial_state.SLIP_ROOTS] = roots
            initial[i, initial_state.SLIP_SIGN] = int(slip_sign)
        outcomes[i] = outcome
        impacts[i] = log.counts[event_log.IMPACTS] - impacts_before
        end_ball(log, i)


@inner_kernel
def _ends_in_flight(cause: int) -> int:
    """How a drop ends whose flight ended so."""
    if cause == free_flight.AT_BINS:
        return LANDED
    if cause == free_flight.OUT_OF_EVENTS:
        return EVENT_LIMIT
    if cause == free_flight.OUT_OF_TIME:
        return TIME_LIMIT
    return ESCAPED


@inner_kernel
def _ends_in_contact(cause: int) -> int:
    """How a drop ends whose contact ended so, RUNNING if it does not."""
    if cause == sustained_contact.LANDED:
        return LANDED
    if cause == sustained_contact.AT_REST:
        return BALANCED
    if cause == sustained_contact.OUT_OF_TIME:
        return TIME_LIMIT
    if cause == sustained_contact.OUT_OF_EVENTS:
        return EVENT_LIMIT
    if cause == sustained_contact.OUT_OF_BOARD:
        return ESCAPED
    return RUNNING
