"""The statements of idempotency keys: an INSERT on a unique index decides which request was first.

The row is written in the transaction that writes what the request makes. So there is no key without
its fact, and a request that is refused leaves its key unused.
"""

import hashlib
import time
from collections.abc import Sequence

from sqlalchemy import Connection, delete, select

from plinko.app.errors import KeyReusedError
from plinko.app.persistence.statements import tables
from plinko.app.rooms.keys import QUEUE, IdempotencyKey, KeyUse, UsedKey


def use(connection: Connection, key: IdempotencyKey, run: int, fact: str) -> UsedKey | None:
    """Use a key for a fact. Returns None, or the earlier use by the same request.

    Raises KeyReusedError if the key belongs to another request.
    """
    row = {"id": _id(key), "request": _short(key.request), "run": run, "fact": fact}
    row |= {"own": key.scope.startswith(QUEUE), "used": int(time.time())}
    adding = tables.adding(connection, tables.idempotency_keys).on_conflict_do_nothing()
    new = adding.returning(tables.idempotency_keys.c.run)
    if connection.execute(new, row).first() is not None:
        return None
    found = used(connection, key)
    assert found is not None
    return found.check(key)


def release(connection: Connection, key: IdempotencyKey) -> None:
    """Free a key that this transaction has used, as its request is refused."""
    row = tables.idempotency_keys
    connection.execute(delete(row).where(row.c.id == _id(key)))


def forget(connection: Connection) -> None:
    """Delete all callers' keys, but not those of queues.

    A restored backup calls this: the fact of a key may be among the lost ones, and its caller may
    have the reply.
    """
    row = tables.idempotency_keys
    connection.execute(delete(row).where(~row.c.own))


def used(connection: Connection, key: IdempotencyKey) -> UsedKey | None:
    """The use of this caller's key, by whatever request."""
    row = tables.idempotency_keys.c
    chosen = select(row.request, row.run, row.fact).where(row.id == _id(key))
    found = connection.execute(chosen).first()
    if found is None:
        return None
    same = found.request == _short(key.request)
    request = key.request if same else found.request.hex()
    return UsedKey(key.scope, key.key, request, found.run, found.fact)


def decide(connection: Connection, uses: Sequence[KeyUse]) -> None:
    """Set in each of these uses whether it is new, a repeat or refused.

    The rows are written in the order of the keys, so that servers that share a ledger cannot
    deadlock.
    """
    with_keys = [(each.key, each) for each in uses if each.key is not None]
    for key, each in sorted(with_keys, key=lambda pair: (pair[0].scope, pair[0].key)):
        each.earlier = each.error = None
        try:
            each.earlier = use(connection, key, each.run, each.fact)
        except KeyReusedError as error:
            each.error = error


def _id(key: IdempotencyKey) -> bytes:
    return hashlib.sha256(f"{key.scope}{key.key}".encode()).digest()[:16]


def _short(digest: str) -> bytes:
    """Half of a digest: 128 bits are enough to tell requests apart."""
    return bytes.fromhex(digest)[:16]
