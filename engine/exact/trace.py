"""Follows balls from their start to the end of their drops.

A drop alternates three phases: flight and bounces (free_flight.py), sustained contact
(sustained_contact.py), and the meeting of a second surface (two_contacts.py). Each returns the
cause of its end, which decides the next phase.
"""

import numpy as np
import numpy.typing as npt

from plinko.engine.constants import KIND_CONTACT_BEGIN, KIND_CONTACT_END
from plinko.engine.exact import (
    event_log,
    free_flight,
    initial_state,
    next_impact,
    sustained_contact,
    two_contacts,
)
from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.event_log import Log, end_ball, land, note_contact
from plinko.engine.exact.initial_state import Ints
from plinko.engine.exact.outcome import (
    BALANCED,
    ESCAPED,
    EVENT_LIMIT,
    FALSE_PATH,
    IMPULSE_LIMIT,
    LANDED,
    RUNNING,
    SEARCH_LIMIT,
    TIME_LIMIT,
    WEDGED,
)
from plinko.engine.jit.decorator import inner_kernel, kernel
from plinko.engine.physics.series import Series

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
    """Follow each ball from its row of `states`, shape (n, 7), to the end of its drop.

    `states` is changed in place. initial, shape (n, COLUMNS), says in which phase each ball is.
    Writes each drop's outcome, bin (-1 if the ball did not land) and number of impacts into arrays
    of shape (n,). `series` is work space. There is one kernel for one ball and for many, so that
    the code of a drop is compiled only once.
    """
    for i in range(len(states)):
        event_limit = log.counts[event_log.EVENTS] + max_events
        impacts_before = log.counts[event_log.IMPACTS]
        outcomes[i] = follow(board, states[i], initial[i], event_limit, max_time, series, log)
        bins[i] = land(board, states[i], log) if outcomes[i] == LANDED else -1
        impacts[i] = log.counts[event_log.IMPACTS] - impacts_before
        end_ball(log, i)


@inner_kernel
def follow(
    board: BoardArrays,
    state: State,
    place: Ints,
    event_limit: int,
    max_time: float,
    series: Series,
    log: Log,
) -> int:
    """Follow one ball from `state`, changed in place, and from `place`, its row of `initial`.

    Returns the drop's outcome. After EVENT_LIMIT the drop can be continued from `state` and
    `place`, with the same bits as without the interruption.
    """
    item = int(place[initial_state.HIT])
    side = float(place[initial_state.HIT_SIDE])
    hits = item != initial_state.NONE
    how = int(place[initial_state.PHASE])
    if not hits:
        item = int(place[initial_state.SURFACE])
        side = float(place[initial_state.SIDE])
    beside = int(place[initial_state.BESIDE])
    roots = int(place[initial_state.SLIP_ROOTS])
    slip_sign = float(place[initial_state.SLIP_SIGN])
    met = initial_state.NONE
    met_side = 0.0
    outcome = RUNNING
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
                note_contact(board, state, KIND_CONTACT_END, item, log)
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
                note_contact(board, state, KIND_CONTACT_BEGIN, item, log)
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
            if log.counts[event_log.EVENTS] == noted:  # an impact already marks a contact's end
                note_contact(board, state, KIND_CONTACT_END, item, log)
        elif end == two_contacts.LIES_STILL:
            outcome = WEDGED
        elif end == two_contacts.BOUNCES_ON:
            outcome = IMPULSE_LIMIT
        elif end == two_contacts.FALSE:
            outcome = FALSE_PATH
    if outcome == EVENT_LIMIT:
        place[initial_state.HIT] = initial_state.NONE
        place[initial_state.SURFACE] = item
        place[initial_state.SIDE] = int(side)
        place[initial_state.PHASE] = how
        place[initial_state.SLIP_ROOTS] = roots
        place[initial_state.SLIP_SIGN] = int(slip_sign)
        place[initial_state.BESIDE] = beside
    return outcome


@inner_kernel
def _ends_in_flight(cause: int) -> int:
    """The outcome of a drop whose flight ended by this cause; RUNNING if the drop goes on."""
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
    if cause == free_flight.FALSE:
        return FALSE_PATH
    return RUNNING


@inner_kernel
def _ends_in_contact(cause: int) -> int:
    """The outcome of a drop whose contact ended by this cause; RUNNING if the drop goes on."""
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
    if cause == sustained_contact.FALSE:
        return FALSE_PATH
    return RUNNING
