"""Statements about what happened to the ledger itself: restores with their logs, and its keys.

A restored backup begins a new log of receipts, because the former log may have leaves that the
backup lacks. A ledger's first log has number 0 and no id; the restore of number n began log n.
"""

from dataclasses import asdict, dataclass

from sqlalchemy import Connection, delete, func, insert, select

from plinko.app.persistence.statements import tables

FIRST_LOG = "0" * 32
"""Stands for the id of the first log, which has none."""

STATEMENTS = "statements"
"""The keys that sign statements: rows with their public keys."""

TOKENS = "tokens"
"""The secrets that sign tokens: rows with marks that do not reveal them."""


@dataclass(frozen=True, slots=True)
class RestoreRow:
    """A restore, which began log `number`; `statement` is JSON, and `log` the log's random id.

    superseded: the id of the log that the restored ledger had before, if the backup lacks it.
    """

    number: int
    log: str
    superseded: str | None
    statement: str
    signature: str


@dataclass(frozen=True, slots=True)
class KeyRow:
    """A key, used since this Unix time, in s: `name` is STATEMENTS or TOKENS.

    statement: JSON that names this key and its predecessor, signed by this key and, unless that was
    lost, by its predecessor. A first key has none.
    """

    number: int
    name: str
    value: str
    since: float
    statement: str | None = None
    signature: str | None = None
    former_signature: str | None = None


def restores(connection: Connection) -> list[RestoreRow]:
    chosen = select(tables.restores).order_by(tables.restores.c.number)
    return [RestoreRow(**row) for row in connection.execute(chosen).mappings()]


def add_restore(connection: Connection, row: RestoreRow) -> None:
    connection.execute(insert(tables.restores).values(asdict(row)))


def log_number(connection: Connection) -> int:
    return int(connection.scalar(select(func.max(tables.restores.c.number))) or 0)


def log_id(connection: Connection, number: int | None = None) -> str:
    """The id of a log, by default of the current one; FIRST_LOG for the first."""
    row = tables.restores.c
    chosen = select(row.log).order_by(row.number.desc()).limit(1)
    found = connection.scalar(chosen if number is None else chosen.where(row.number == number))
    return found or FIRST_LOG


def former_logs(connection: Connection) -> set[str]:
    """The ids of all logs that the current one replaces."""
    rows = restores(connection)
    logs = [FIRST_LOG, *(row.log for row in rows)]
    return {*logs[:-1], *(row.superseded for row in rows if row.superseded)}


def keys(connection: Connection, name: str) -> list[KeyRow]:
    """The keys of this name, the first one first."""
    row = tables.keys.c
    chosen = select(tables.keys).where(row.name == name).order_by(row.number)
    return [KeyRow(**found) for found in connection.execute(chosen).mappings()]


def add_key(connection: Connection, row: KeyRow) -> None:
    connection.execute(insert(tables.keys).values(asdict(row)))


def forget_keys(connection: Connection, name: str) -> None:
    """Delete the keys of a ledger in which nothing is signed."""
    connection.execute(delete(tables.keys).where(tables.keys.c.name == name))


def next_key(connection: Connection) -> int:
    return int(connection.scalar(select(func.max(tables.keys.c.number))) or 0) + 1
