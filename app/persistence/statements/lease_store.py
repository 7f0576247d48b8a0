"""Statements of leases: which server has a room, and that a write still comes from that server.

Who takes a room waits for every transaction that has looked at its lease, and every one that looks
later finds another number. So what the former holder wrote is all there when the next one reads,
and nothing comes after it.
"""

from collections.abc import Iterable
from typing import Final

import sqlalchemy as sa
from sqlalchemy import Connection, func, select, update

from app.persistence.statements import tables
from app.rooms.records import Lease, LeaseRow

_AT_ONCE: Final = 400  # rooms of one SELECT, below what SQLite takes
_LOCK_PATIENCE: Final = 100  # ms for which a take may wait for the former holder's transaction
_LOCK_NOT_AVAILABLE: Final = "55P03"  # PostgreSQL's error code

_RUNS: Final = "sessions"  # the counter of runs' numbers
_LOG: Final = "log"  # a row by which servers add to the log of receipts one after another


def take(
    connection: Connection, room: str, holder: str, address: str, now: float, after: int | None
) -> int | None:
    """Have a room from now on, whoever had it; returns the lease's number.

    With `after` only if that is still its number, 0 for none: 0 where it is another by now. None
    while the former holder's transaction lasts. Nothing else may be in the connection's
    transaction: it could hold up the other server's.
    """
    values = {"holder": holder, "address": address, "taken": now}
    try:
        with connection.begin_nested():
            if connection.dialect.name == "postgresql":
                connection.execute(sa.text(f"SET LOCAL lock_timeout = {_LOCK_PATIENCE}"))
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
    """Pass a room on to `holder`, "" for nobody, unless it is another's already.

    Nothing is written under this lease again.
    """
    row = tables.leases
    connection.execute(
        update(row)
        .where(row.c.room == lease.room, row.c.number == lease.number)
        .values(number=lease.number + 1, holder=holder, address=address, taken=now)
    )


def lost(connection: Connection, leases: Iterable[Lease]) -> list[Lease]:
    """Those of `leases` that are not as they were; the others stay so for this transaction."""
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
    """Who has a room; None where nobody ever had it."""
    found = connection.execute(select(tables.leases).where(tables.leases.c.room == room))
    row = found.mappings().first()
    return None if row is None else LeaseRow(**row)


def standing(connection: Connection, room: str) -> tuple[bool, LeaseRow | None]:
    """Whether there is an open room of this id, and who has it."""
    row = tables.rooms.c
    found = connection.execute(select(row.number).where(row.id == room, row.closed.is_(None)))
    return found.first() is not None, holder_of(connection, room)


def listing(connection: Connection) -> list[LeaseRow]:
    """Every room that some server has, by id."""
    chosen = (
        select(tables.leases).where(tables.leases.c.holder != "").order_by(tables.leases.c.room)
    )
    return [LeaseRow(**row) for row in connection.execute(chosen).mappings()]


# What servers number together.


def reserve(connection: Connection, count: int) -> int:
    """The first of `count` numbers of runs that no server has had."""
    highest = connection.scalar(select(func.max(tables.rooms.c.number))) or 0
    following = max(_counted(connection, _RUNS), int(highest) + 1)
    row = tables.counters
    changed = update(row).where(row.c.name == _RUNS).values(next=following + count)
    connection.execute(changed)
    return following


def wait_for_log(connection: Connection) -> None:
    """Have the log of receipts for this transaction alone, until it ends."""
    _counted(connection, _LOG)


def _counted(connection: Connection, name: str) -> int:
    """A counter, which is this transaction's alone from now on."""
    row = tables.counters
    chosen = select(row.c.next).where(row.c.name == name).with_for_update()
    found = connection.execute(chosen).scalar()
    if found is None:
        made = tables.adding(connection, row).values(name=name, next=1)
        connection.execute(made.on_conflict_do_nothing())
        found = connection.execute(chosen).scalar_one()
    return int(found)
