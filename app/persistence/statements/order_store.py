"""Statements of the operator's orders: their log, from which follows what is in force."""

from collections.abc import Sequence
from dataclasses import asdict

from sqlalchemy import Connection, insert, select

from plinko.app.persistence.statements import tables
from plinko.app.rooms.records import Order


def add(connection: Connection, rows: Sequence[Order]) -> None:
    values = [asdict(row) for row in rows]
    for each in values:
        del each["number"]
    connection.execute(insert(tables.operator_actions), values)


def orders(connection: Connection, after: int = 0) -> list[Order]:
    """The orders with a number above `after`, the first one first."""
    row = tables.operator_actions.c
    chosen = select(tables.operator_actions).where(row.number > after).order_by(row.number)
    return [Order(**found) for found in connection.execute(chosen).mappings()]
