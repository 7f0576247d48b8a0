"""Statements of rooms' shows: one row for each room, which outlives its runs."""

from dataclasses import asdict

from sqlalchemy import Connection, select

from plinko.app.persistence.statements import tables
from plinko.app.rooms.records import ShowRow


def show(connection: Connection, room: str) -> ShowRow | None:
    found = connection.execute(select(tables.shows).where(tables.shows.c.room == room)).mappings()
    return next((ShowRow(**row) for row in found), None)


def put(connection: Connection, rows: list[ShowRow]) -> None:
    """Write shows, and replace the former ones of their rooms."""
    adding = tables.adding(connection, tables.shows)
    new = {name: adding.excluded[name] for name in ("data", "updated")}
    adding = adding.on_conflict_do_update(index_elements=["room"], set_=new)
    for row in rows:
        connection.execute(adding, asdict(row))
