"""Statements of room leases: take and release them, and check them before a write.

A transaction that writes to a room first checks its lease and locks that row for sharing. Taking
the room updates the row, so it waits for all such transactions, and later ones find another number.
So the new holder reads everything that the former one has written, and nothing is added after it.
"""

from collections.abc import Iterable
from typing import Final

import sqlalchemy as sa
from sqlalchemy import Connection, func, select, update

from plinko.app.persistence.statements import tables
from plinko.app.rooms.records import Lease, LeaseRow

_AT_ONCE: Final = 400  # rooms in one SELECT: SQLite limits the number of parameters
_LOCK_MS: Final = 100  # how long taking a room waits for the former holder's transaction
_LOCK_NOT_AVAILABLE: Final = "55P03"  # PostgreSQL's error code

_RUNS: Final = "sessions"  # the counter of run numbers
_LOG: Final = "log"  # the row that servers lock before they append to the log of receipts


def take(
    connection: Connection, room: str, holder: str, address: str, now: float, after: int | None
) -> int | None:
    """Take a room's lease from its former holder; returns the new lease's number.

    With `after`, takes the lease only if its number is still `after` (0: no lease yet), and returns
    0 if it is not. Returns None if a transaction of the former holder is still running. The
    connection's transaction must contain nothing else, whose locks could block that transaction.
    """
    values = {"holder": holder, "address": address, "taken": now}
    try:
        with connection.begin_nested():
            if connection.dialect.name == "postgresql":
                connection.execute(sa.text(f"SET LOCAL lock_timeout = {_LOCK_MS}"))
            taking = _taking(connection, room, after, values)
            return connection.execute(taking).scalar() or 0
    except sa.exc.OperationalError as error:
        if getattr(error.orig, "sqlstate", None) != _LOCK_NOT_AVAILABLE:
            raise
        return None


def _taking(
    connection: Connection, room: str, after: int | None, values: dict[str, object]
) -> sa.UpdateBase:
    row = tables.leases
    number = row.c.number
    if after:
        same = (row.c.room == room) & (number == after)
        return update(row).where(same).values(number=after + 1, **values).returning(number)
    adding = tables.adding(connection, row).values(room=room, number=1, **values)
    if after is not None:
        return adding.on_conflict_do_nothing().returning(number)
    following = {"number": number + 1, **values}
    return adding.on_conflict_do_update(index_elements=["room"], set_=following).returning(number)


def release(connection: Connection, lease: Lease, holder: str, address: str, now: float) -> None:
    """Give a room to `holder` ("": no server), unless another server has taken it already.

    Either way, later writes under `lease` are refused.
    """
    row = tables.leases
    connection.execute(
        update(row)
        .where(row.c.room == lease.room, row.c.number == lease.number)
        .values(number=lease.number + 1, holder=holder, address=address, taken=now)
    )


def lost(connection: Connection, leases: Iterable[Lease]) -> list[Lease]:
    """Those of `leases` that the ledger no longer has.

    Locks the others for sharing until the transaction ends.
    """
    row, asked = tables.leases.c, sorted(set(leases))
    found: set[tuple[str, int]] = set()
    for begin in range(0, len(asked), _AT_ONCE):
        rooms = [lease.room for lease in asked[begin : begin + _AT_ONCE]]
        chosen = (
            select(row.room, row.number)
            .where(row.room.in_(rooms))
            .order_by(row.room)
            .with_for_update(read=True)
        )
        found.update((each.room, each.number) for each in connection.execute(chosen))
    return [lease for lease in asked if (lease.room, lease.number) not in found]


def holder_of(connection: Connection, room: str) -> LeaseRow | None:
    """A room's lease; None if the room never had one."""
    found = connection.execute(select(tables.leases).where(tables.leases.c.room == room))
    row = found.mappings().first()
    return None if row is None else LeaseRow(**row)


def standing(connection: Connection, room: str) -> tuple[bool, LeaseRow | None]:
    """Whether there is an open room of this id, and its lease."""
    row = tables.rooms.c
    found = connection.execute(select(row.number).where(row.id == room, row.closed.is_(None)))
    return found.first() is not None, holder_of(connection, room)


def listing(connection: Connection) -> list[LeaseRow]:
    """The leases of all rooms that a server has, ordered by room."""
    chosen = (
        select(tables.leases).where(tables.leases.c.holder != "").order_by(tables.leases.c.room)
    )
    return [LeaseRow(**row) for row in connection.execute(chosen).mappings()]


def unix_time(connection: Connection) -> float:
    """The time of PostgreSQL's server: Unix time in s."""
    return float(connection.scalar(sa.text("SELECT extract(epoch FROM clock_timestamp())")) or 0)


# Counters and locks that servers share.


def reserve(connection: Connection) -> int:
    """A number for a room run that no other run has."""
    highest = connection.scalar(select(func.max(tables.rooms.c.number))) or 0
    number = max(_counted(connection, _RUNS), int(highest) + 1)
    row = tables.counters
    connection.execute(update(row).where(row.c.name == _RUNS).values(next=number + 1))
    return number


def wait_for_log(connection: Connection) -> None:
    """Lock the log of receipts until the transaction ends."""
    _counted(connection, _LOG)


def _counted(connection: Connection, name: str) -> int:
    """Lock a counter until the transaction ends, and read it; creates it with 1."""
    row = tables.counters
    chosen = select(row.c.next).where(row.c.name == name).with_for_update()
    found = connection.execute(chosen).scalar()
    if found is None:
        made = tables.adding(connection, row).values(name=name, next=1)
        connection.execute(made.on_conflict_do_nothing())
        found = connection.execute(chosen).scalar_one()
    return int(found)
