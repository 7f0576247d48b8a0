"""Ends a run that cannot continue: its balls land, and those that cannot return their stake."""

import contextlib
from dataclasses import dataclass
from typing import Final

from sqlalchemy import Connection

from plinko.app.errors import DamagedRoomError
from plinko.app.persistence.recovery.rebuild import basis_of
from plinko.app.persistence.statements import store, writing
from plinko.app.rooms.outcome import computed
from plinko.app.rooms.records import Close, ResultRow, RoomRow, Void
from plinko.engine import PHYSICS_VERSION
from plinko.engine.errors import EngineError

DROPPED: Final = "its room was taken off the ledger"
"""The reason in the results of balls whose room the operator gave up."""


@dataclass(frozen=True, slots=True)
class Retired:
    """A run that was ended: its number and room.

    landed: its balls that got their results now, which pay `paid`; void: those that cannot be
    computed, which return `returned`. Both amounts in minor units.
    """

    session: int
    room: str
    landed: int
    paid: int
    void: int
    returned: int


def results(connection: Connection, row: RoomRow) -> list[ResultRow]:
    """The results that a table's run lacks, computed from its facts.

    Leaves out what this release cannot compute: drops of another physics version, damaged ones.
    """
    found: list[ResultRow] = []
    open_drops = store.unended_drops(connection, row.number)
    if not open_drops or row.physics_version != PHYSICS_VERSION:
        return found
    try:
        basis = basis_of(row, store.basis(connection, row.board, row.draw))
    except DamagedRoomError:
        return found
    for ball, _ in open_drops:
        with contextlib.suppress(DamagedRoomError, EngineError):
            fact, _, _ = store.drop(connection, row.number, ball)
            found.append(computed(basis, fact, row.tick_rate))
    return found


def retire(connection: Connection, room_id: str, now: float) -> Retired | None:
    """End the run of a room as it is, damaged or not; None if there is no such room.

    `now` is Unix time. Nothing is replayed and no row is deleted.
    """
    row = store.open_room(connection, room_id)
    if row is None:
        return None
    landed = results(connection, row)
    writing.apply(connection, landed)
    void = store.unended_drops(connection, row.number)
    tick = max((row.tick, *(each.tick for each in landed)))
    writing.apply(connection, [Void(row.number, tick, DROPPED), Close(row.number, tick, now)])
    paid, returned = sum(each.payout for each in landed), sum(stake for _, stake in void)
    return Retired(row.number, row.id, len(landed), paid, len(void), returned)
