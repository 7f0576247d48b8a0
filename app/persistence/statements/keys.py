"""The statements of idempotency keys: an INSERT on a unique index decides which request was first.

The row is written in the transaction that writes what the request makes. So there is no key without
its fact, and a request that is refused leaves its key unused.
"""

from collections.abc import Sequence
from dataclasses import asdict

from sqlalchemy import ColumnElement, Connection, delete, select

from app.errors import KeyReusedError
from app.persistence.statements import tables
from app.rooms.keys import IdempotencyKey, KeyUse, UsedKey


def use(connection: Connection, key: IdempotencyKey, run: int, fact: str) -> UsedKey | None:
    """Use a key for a fact. Returns None, or the earlier use by the same request.

    Raises KeyReusedError if the key belongs to another request.
    """
    row = UsedKey(key.scope, key.key, key.request, run, fact)
    adding = tables.adding(connection, tables.keys).on_conflict_do_nothing()
    new = adding.returning(tables.keys.c.run)
    if connection.execute(new, asdict(row)).first() is not None:
        return None
    found = used(connection, key)
    assert found is not None
    return found.check(key)


def release(connection: Connection, key: IdempotencyKey) -> None:
    """Free a key that this transaction has used, as its request is refused."""
    connection.execute(delete(tables.keys).where(_is(key)))


def used(connection: Connection, key: IdempotencyKey) -> UsedKey | None:
    """The use of this caller's key, by whatever request."""
    found = connection.execute(select(tables.keys).where(_is(key))).mappings().first()
    return None if found is None else UsedKey(**found)


def decide(connection: Connection, uses: Sequence[KeyUse]) -> None:
    """Set in each of these uses whether it is new, a repeat or refused.

    The rows are written in the order of the keys, so that servers that share a ledger cannot
    deadlock.
    """
    keyed = [(each.key, each) for each in uses if each.key is not None]
    for key, each in sorted(keyed, key=lambda pair: (pair[0].scope, pair[0].key)):
        each.earlier = each.error = None
        try:
            each.earlier = use(connection, key, each.run, each.fact)
        except KeyReusedError as error:
            each.error = error


def _is(key: IdempotencyKey) -> ColumnElement[bool]:
    row = tables.keys.c
    return (row.scope == key.scope) & (row.key == key.key)
