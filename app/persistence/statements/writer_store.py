"""Statements with which a server finds out whether a commit without an answer is durable.

Each server has a row with the number of its last batch and an epoch. A batch changes this row
first, and its COMMIT is sent after all statements were answered. So the row is locked for as long
as the batch may still commit, and shows afterwards whether it did.
"""

from dataclasses import dataclass
from datetime import datetime
from typing import Final

import sqlalchemy as sa
from sqlalchemy import Connection, bindparam, delete, insert, select, update

from app.errors import LedgerError
from app.persistence.statements import tables


@dataclass(frozen=True, slots=True)
class Backend:
    """PostgreSQL's process for one connection."""

    pid: int
    started: datetime


def enter(connection: Connection, name: str, *, alone: bool) -> None:
    """Add a writer; with `alone`, first delete all others, left by former servers."""
    if alone:
        connection.execute(delete(tables.writers))
    connection.execute(insert(tables.writers).values(name=name, batch=0, epoch=0))


_COUNT: Final = (
    update(tables.writers)
    .where(tables.writers.c.name == bindparam("mine"), tables.writers.c.epoch == bindparam("since"))
    .values(batch=bindparam("number"))
)


def count(connection: Connection, name: str, epoch: int, batch: int) -> None:
    """Begin a batch; raises LedgerError on a connection of an earlier epoch."""
    values = {"mine": name, "since": epoch, "number": batch}
    if connection.execute(_COUNT, values).rowcount != 1:
        raise LedgerError("the ledger's writer has replaced this connection with another one")


def renew(connection: Connection, name: str) -> tuple[int, int]:
    """Raise the epoch; returns the number of the last durable batch, and the new epoch.

    Waits for the end of the former connection's transaction. In SQLite that has ended with its
    connection, so the epoch stays: nothing need be written, as the disk may be full.
    """
    row = tables.writers
    found = connection.execute(select(row).where(row.c.name == name).with_for_update()).one()
    if connection.dialect.name == "sqlite":
        return found.batch, found.epoch
    connection.execute(update(row).where(row.c.name == name).values(epoch=found.epoch + 1))
    return found.batch, found.epoch + 1


def succeed(connection: Connection, former: Backend | None) -> Backend:
    """End PostgreSQL's process for the former connection; returns that of this connection."""
    activity = "FROM pg_stat_activity WHERE pid ="
    with connection.begin():
        if former is not None:
            ending = f"SELECT pg_terminate_backend(pid) {activity} :pid AND backend_start = :start"
            connection.execute(sa.text(ending), {"pid": former.pid, "start": former.started})
        own = sa.text(f"SELECT pid, backend_start {activity} pg_backend_pid()")
        return Backend(*connection.execute(own).one())
