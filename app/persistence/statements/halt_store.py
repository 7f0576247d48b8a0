"""Statements of halted rooms: which take nothing new, and since when."""

from dataclasses import asdict

from sqlalchemy import Connection, delete, insert, select

from app.persistence.statements import tables
from app.rooms.records import Halt, Release


def halts(connection: Connection) -> dict[str, float]:
    """The halted rooms by id, each with the Unix time, in s, since when it is."""
    return {row.room: row.since for row in connection.execute(select(tables.halts))}


def halt(connection: Connection, rows: list[Halt]) -> None:
    """Halt rooms, each since the time that its row says."""
    release(connection, [Release(row.room) for row in rows])
    connection.execute(insert(tables.halts), [asdict(row) for row in rows])


def release(connection: Connection, rows: list[Release]) -> None:
    """Let rooms go on; others are left alone."""
    rooms = [row.room for row in rows]
    connection.execute(delete(tables.halts).where(tables.halts.c.room.in_(rooms)))
