"""The statements of idempotency keys: an INSERT on a unique index decides which request was first.

The row is written in the transaction that writes what the request makes. So there is no key without
its fact, and a request that is refused leaves its key unused.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, replace

from sqlalchemy import ColumnElement, Connection, delete, select

from plinko.app.errors import KeyReusedError
from plinko.app.persistence.statements import history, tables
from plinko.app.rooms.keys import IdempotencyKey, KeyUse, UsedKey


def use(connection: Connection, key: IdempotencyKey, run: int, fact: str) -> UsedKey | None:
    """Use a key for a fact. Returns None, or the earlier use by the same request.

    Raises KeyReusedError if the key belongs to another request.
    """
    key = _since_restore(connection, key)
    row = UsedKey(key.scope, key.key, key.request, run, fact)
    adding = tables.adding(connection, tables.idempotency_keys).on_conflict_do_nothing()
    new = adding.returning(tables.idempotency_keys.c.run)
    if connection.execute(new, asdict(row)).first() is not None:
        return None
    found = _stored(connection, key)
    assert found is not None
    return found.check(key)


def release(connection: Connection, key: IdempotencyKey) -> None:
    """Free a key that this transaction has used, as its request is refused."""
    key = _since_restore(connection, key)
    connection.execute(delete(tables.idempotency_keys).where(_is(key)))


def used(connection: Connection, key: IdempotencyKey) -> UsedKey | None:
    """The use of this caller's key, by whatever request."""
    return _stored(connection, _since_restore(connection, key))


def _since_restore(connection: Connection, key: IdempotencyKey) -> IdempotencyKey:
    """The key in the scope of the present: a caller's key from before a restore is another one.

    Its fact may be among the lost ones, and the caller may have the reply.
    """
    if key.is_own or (log := history.log_id(connection)) == history.FIRST_LOG:
        return key
    return replace(key, scope=hashlib.sha256(f"{log}{key.scope}".encode()).hexdigest())


def _stored(connection: Connection, key: IdempotencyKey) -> UsedKey | None:
    found = connection.execute(select(tables.idempotency_keys).where(_is(key))).mappings().first()
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
    row = tables.idempotency_keys.c
    return (row.scope == key.scope) & (row.key == key.key)
