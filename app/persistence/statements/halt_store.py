"""Statements of halted rooms, which accept no new drops."""

from dataclasses import asdict

from sqlalchemy import Connection, delete, insert, select

from plinko.app.persistence.statements import tables
from plinko.app.rooms.records import Halt, Release


def halts(connection: Connection) -> dict[str, float]:
    """The halted rooms: the Unix time of each halt in s, by the room's id."""
    return {row.room: row.since for row in connection.execute(select(tables.halts))}


def halt(connection: Connection, rows: list[Halt]) -> None:
    release(connection, [Release(row.room) for row in rows])
    connection.execute(insert(tables.halts), [asdict(row) for row in rows])


def release(connection: Connection, rows: list[Release]) -> None:
    """End halts; rooms that are not halted are ignored."""
    rooms = [row.room for row in rows]
    connection.execute(delete(tables.halts).where(tables.halts.c.room.in_(rooms)))
