"""The exact solver: closed-form flight, the next impact found to the last bits, impulse, repeat."""

import numpy as np
import numpy.typing as npt

from engine.constants import KIND_CONTACT_BEGIN, KIND_CONTACT_END
from engine.exact import (
    event_log,
    free_flight,
    initial_state,
    next_impact,
    sustained_contact,
    two_contacts,
)
from engine.exact.board_arrays import BoardArrays, surface_index
from engine.exact.event_log import Log, end_ball, land, note_event
from engine.exact.initial_state import Ints
from engine.exact.outcome import (
    BALANCED,
    ESCAPED,
    EVENT_LIMIT,
    LANDED,
    RUNNING,
    SEARCH_LIMIT,
    TIME_LIMIT,
    WEDGED,
)
from engine.jit.decorator import inner_kernel, kernel
from engine.physics.series import Series

State = npt.NDArray[np.float64]


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
        hits = item != initial_state.NONE
        how = int(initial[i, initial_state.PHASE])
        if not hits:
            item = int(initial[i, initial_state.SURFACE])
            side = float(initial[i, initial_state.SIDE])
        beside = int(initial[i, initial_state.BESIDE])
        roots = int(initial[i, initial_state.SLIP_ROOTS])
        slip_sign = float(initial[i, initial_state.SLIP_SIGN])
        met = initial_state.NONE
        met_side = 0.0
        outcome = RUNNING
        bins[i] = -1
        while outcome == RUNNING:
            if how == initial_state.LYING:
                cause, item, side, met, met_side, beside = sustained_contact.follow_contact(
                    board, series, state, item, side, roots, slip_sign, beside, max_time,
                    event_limit, log,
                )  # fmt: skip
                outcome = _ends_in_contact(cause)
                if outcome == EVENT_LIMIT:
                    roots = met
                    slip_sign = met_side
                if outcome != RUNNING:
                    break
                if cause != sustained_contact.HIT:
                    rolled_off = cause == sustained_contact.LEFT
                    how = next_impact.ROLLED_OFF if rolled_off else next_impact.LIFTED
                    note_event(log, state, KIND_CONTACT_END, surface_index(board, item))
                    continue
            else:
                cause, item, side, met, met_side, how, sticks = free_flight.follow_flight(
                    board, state, item, side, how, beside, hits, event_limit, max_time, log
                )
                hits = False
                beside = initial_state.NONE
                roots = 1 if sticks else 0
                slip_sign = 0.0
                if cause == free_flight.ON_SURFACE:
                    how = initial_state.LYING
                    note_event(log, state, KIND_CONTACT_BEGIN, surface_index(board, item))
                    continue
                outcome = _ends_in_flight(cause)
                if outcome != RUNNING:
                    beside = met
                    break
            noted = log.counts[event_log.EVENTS]
            end, item, side, beside, roots = two_contacts.meet(
                board, state, item, side, met, met_side, log
            )
            slip_sign = 0.0
            how = initial_state.LYING
            if end == two_contacts.FLIES:
                how = next_impact.BOUNCED
            elif end == two_contacts.LIFTS:
                how = next_impact.LIFTED
                if log.counts[event_log.EVENTS] == noted:  # an impact ends a contact by itself
                    note_event(log, state, KIND_CONTACT_END, surface_index(board, item))
            elif end == two_contacts.LIES_STILL:
                outcome = WEDGED
        if outcome == LANDED:
            bins[i] = land(board, state, log)
        if outcome == EVENT_LIMIT:
            initial[i, initial_state.HIT] = initial_state.NONE
            initial[i, initial_state.SURFACE] = item
            initial[i, initial_state.SIDE] = int(side)
            initial[i, initial_state.PHASE] = how
            initial[i, initial_state.SLIP_ROOTS] = roots
            initial[i, initial_state.SLIP_SIGN] = int(slip_sign)
            initial[i, initial_state.BESIDE] = beside
        outcomes[i] = outcome
        impacts[i] = log.counts[event_log.IMPACTS] - impacts_before
        end_ball(log, i)


@inner_kernel
def _ends_in_flight(cause: int) -> int:
    """How a drop ends whose flight ended so, RUNNING if it does not."""
    if cause == free_flight.AT_BINS:
        return LANDED
    if cause == free_flight.OUT_OF_EVENTS:
        return EVENT_LIMIT
    if cause == free_flight.LATE:
        return TIME_LIMIT
    if cause == free_flight.SEARCHED_OUT:
        return SEARCH_LIMIT
    if cause == free_flight.OUT_OF_BOARD:
        return ESCAPED
    return RUNNING


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
