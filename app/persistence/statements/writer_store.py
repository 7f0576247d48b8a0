"""Statements with which a server finds out whether its commits are in the ledger.

Each start of a server has a row, its epoch, with the number of its last batch and of its
reconnections. A batch changes this row first, and its COMMIT is sent after all statements were
answered. So the row is locked for as long as the batch may still commit, and shows afterwards
whether it did. The next start compares the number with the one beside the ledger (`epoch.py`).
"""

from dataclasses import dataclass
from datetime import datetime
from typing import Final

import sqlalchemy as sa
from sqlalchemy import Connection, bindparam, delete, func, insert, select, update

from plinko.app.errors import LedgerError
from plinko.app.persistence.statements import tables


@dataclass(frozen=True, slots=True)
class Backend:
    """PostgreSQL's process for one connection."""

    pid: int
    started: datetime


def enter(connection: Connection, name: str, former: str) -> None:
    """Add the epoch of a start, and delete the epoch before `former`, which is the last one."""
    row = tables.writers
    before = connection.scalar(select(row.c.former).where(row.c.name == former))
    connection.execute(delete(row).where(row.c.name == before))
    connection.execute(insert(row).values(name=name, batch=0, epoch=0, former=former))


def last_batch(connection: Connection, name: str) -> int | None:
    """The number of the last batch of a start; None if the ledger does not have its epoch."""
    chosen = select(tables.writers.c.batch).where(tables.writers.c.name == name)
    found: int | None = connection.scalar(chosen)
    return found


def any_epoch(connection: Connection) -> bool:
    """Whether a server of this release has started with the ledger."""
    row = tables.writers.c
    return bool(connection.scalar(select(func.count()).where(row.former.is_not(None))))


_COUNT: Final = (
    update(tables.writers)
    .where(tables.writers.c.name == bindparam("mine"), tables.writers.c.epoch == bindparam("since"))
    .values(batch=bindparam("number"))
)


def count(connection: Connection, name: str, reconnects: int, batch: int) -> None:
    """Begin a batch; raises LedgerError on a connection that another one has replaced."""
    values = {"mine": name, "since": reconnects, "number": batch}
    if connection.execute(_COUNT, values).rowcount != 1:
        raise LedgerError("the ledger's writer has replaced this connection with another one")


def renew(connection: Connection, name: str) -> tuple[int, int]:
    """Count a reconnection; returns the number of the last durable batch, and that count.

    Waits for the end of the former connection's transaction. In SQLite that has ended with its
    connection, so the count stays: nothing need be written, as the disk may be full.
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
