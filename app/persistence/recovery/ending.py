"""How a run ends that cannot go on: what has no result and can get none gets its stake back."""

from dataclasses import dataclass

from sqlalchemy import Connection

from app.persistence.statements import store, writing
from app.rooms.kinds import format_of
from app.rooms.records import Close, ResultRow, RoomRow

DROPPED = "its room was taken off the ledger"
"""What a result says of a ball whose room whoever runs the server gave up."""


@dataclass(frozen=True, slots=True)
class Retired:
    """A run that was ended: of which room, and what was given back."""

    session: int
    room: str
    drops: int
    stakes: int  # minor units


def voided(connection: Connection, row: RoomRow, tick: int, why: str) -> list[ResultRow]:
    """Results, at `tick`, for the drops of a run that have none."""
    inputs = format_of(row.mode)
    if not inputs.has_results:
        return []
    found = [inputs.void(drop, tick, why) for drop in store.unended_drops(connection, row.number)]
    return [result for result in found if result is not None]


def retire(connection: Connection, room_id: str, now: float) -> Retired | None:
    """End the run of a room as it stands, damaged or not; None when there is no such room.

    `now` is in Unix time. Nothing of it is replayed and no row is deleted: what has a result keeps
    it, what has none gets its stake back.
    """
    row = store.open_room(connection, room_id)
    if row is None:
        return None
    results = voided(connection, row, row.tick, DROPPED)
    writing.apply(connection, [*results, Close(row.number, row.tick, now)])
    return Retired(row.number, row.id, len(results), sum(result.payout for result in results))
