"""Ends a run that cannot continue: drops that can get no result get their stake back."""

from dataclasses import dataclass

from sqlalchemy import Connection

from plinko.app.persistence.statements import store, writing
from plinko.app.rooms.kinds import format_of
from plinko.app.rooms.records import Close, ResultRow, RoomRow

DROPPED = "its room was taken off the ledger"
"""The reason in the results of balls whose room the operator gave up."""


@dataclass(frozen=True, slots=True)
class Retired:
    """A run that was ended: its number and room, and the drops and stakes that were returned."""

    session: int
    room: str
    drops: int
    stakes: int  # minor units


def voided(connection: Connection, row: RoomRow, tick: int, why: str) -> list[ResultRow]:
    """Results at `tick` that return the stakes of a run's drops without a result."""
    inputs = format_of(row.mode)
    if not inputs.has_results:
        return []
    found = [inputs.void(drop, tick, why) for drop in store.unended_drops(connection, row.number)]
    return [result for result in found if result is not None]


def retire(connection: Connection, room_id: str, now: float) -> Retired | None:
    """End the run of a room as it is, damaged or not; None if there is no such room.

    `now` is Unix time. Nothing is replayed and no row is deleted: drops with a result keep it, and
    the others get their stake back.
    """
    row = store.open_room(connection, room_id)
    if row is None:
        return None
    results = voided(connection, row, row.tick, DROPPED)
    writing.apply(connection, [*results, Close(row.number, row.tick, now)])
    return Retired(row.number, row.id, len(results), sum(result.payout for result in results))
