"""Statements of rooms' queues of drops: one row for each run, with the whole queue as JSON."""

from dataclasses import asdict

import msgspec
from sqlalchemy import Connection, select

from plinko.app.persistence.statements import tables
from plinko.app.rooms.queue import EMPTY, Queue
from plinko.app.rooms.records import QueueRow


def queue(connection: Connection, room: int) -> Queue:
    """The queue of run number `room`."""
    chosen = select(tables.queues.c.data).where(tables.queues.c.room == room)
    text = connection.scalar(chosen)
    return EMPTY if text is None else msgspec.json.decode(text, type=Queue)


def waiting(connection: Connection) -> list[str]:
    """The ids of open rooms with a queue that is neither empty nor paused."""
    chosen = (
        select(tables.rooms.c.id, tables.queues.c.data)
        .join(tables.rooms, tables.rooms.c.number == tables.queues.c.room)
        .where(tables.rooms.c.closed.is_(None))
    )
    found = (
        (room, msgspec.json.decode(data, type=Queue)) for room, data in connection.execute(chosen)
    )
    return [room for room, each in found if each.items and not each.paused]


def put(connection: Connection, rows: list[QueueRow]) -> None:
    """Write queues, and replace their runs' former ones."""
    adding = tables.adding(connection, tables.queues)
    adding = adding.on_conflict_do_update(
        index_elements=["room"], set_={"data": adding.excluded.data}
    )
    for row in rows:
        connection.execute(adding, asdict(row))
