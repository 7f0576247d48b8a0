"""Follows balls from their start to the end of their drops.

A drop alternates three phases: flight and bounces (free_flight.py), sustained contact
(sustained_contact.py), and the meeting of a second surface (two_contacts.py). Each returns
its end: a cause, which decides the next phase, or the drop's outcome.
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
from plinko.engine.exact.initial_state import Resume
from plinko.engine.exact.outcome import EVENT_LIMIT, LANDED, PHASE_ENDS
from plinko.engine.jit.decorator import inner_kernel, kernel
from plinko.engine.physics.array_types import Floats, Ints
from plinko.engine.physics.series import Series


@kernel
def trace_many(
    board: BoardArrays,
    states: Floats,
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
    state: Floats,
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
    resume = Resume(
        int(place[initial_state.SLIP_ROOT]),
        float(place[initial_state.SLIP_SIGN]),
        int(place[initial_state.SECOND_SURFACE]),
    )
    while True:
        if how == initial_state.LYING:
            cause, item, side, met, met_side, resume = sustained_contact.follow_contact(
                board, series, state, item, side, resume, max_time, event_limit, log
            )
            if cause in (sustained_contact.LEFT, sustained_contact.OFF):
                rolled_off = cause == sustained_contact.LEFT
                how = next_impact.ROLLED_OFF if rolled_off else next_impact.LIFTED
                note_contact(board, state, KIND_CONTACT_END, item, log)
                continue
        else:
            cause, item, side, met, met_side, how, resume = free_flight.follow_flight(
                board, state, item, side, how, resume.second_surface, hits, event_limit, max_time,
                log,
            )  # fmt: skip
            hits = False
            if cause == free_flight.ON_SURFACE:
                how = initial_state.LYING
                note_contact(board, state, KIND_CONTACT_BEGIN, item, log)
                continue
        if cause < PHASE_ENDS:
            break
        noted = log.counts[event_log.EVENTS]
        cause, item, side, resume = two_contacts.meet(board, state, item, side, met, met_side, log)
        if cause < PHASE_ENDS:
            break
        how = initial_state.LYING
        if cause == two_contacts.FLIES:
            how = next_impact.BOUNCED
        elif cause == two_contacts.LIFTS:
            how = next_impact.LIFTED
            if log.counts[event_log.EVENTS] == noted:  # an impact already marks a contact's end
                note_contact(board, state, KIND_CONTACT_END, item, log)
    if cause == EVENT_LIMIT:
        place[initial_state.HIT] = initial_state.NONE
        place[initial_state.SURFACE] = item
        place[initial_state.SIDE] = int(side)
        place[initial_state.PHASE] = how
        place[initial_state.SLIP_ROOT] = resume.slip_root
        place[initial_state.SLIP_SIGN] = int(resume.slip_sign)
        place[initial_state.SECOND_SURFACE] = resume.second_surface
    return cause
