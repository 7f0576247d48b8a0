"""Idempotency keys: how the server recognises a request that its client repeats.

A key belongs to its caller and its request. The same caller with the same request gets the fact
that the first request has made. Another request with the same key is refused. Another caller's key
is another key. The key is written in the transaction that writes the fact, so the database decides
which request was the first (app/persistence/statements/keys.py).
"""

import hashlib
from dataclasses import dataclass
from typing import Final

import msgspec

from plinko.app.errors import KeyReusedError

QUEUE: Final = "queue of run "
"""Begins the scopes of the keys of queues' balls, which are the server's own."""


@dataclass(frozen=True, slots=True)
class Caller:
    """The sender of a request.

    proven: only this caller knows the `name`. A repeat then comes from the first request's sender,
    and may have the token that the first response had.
    """

    name: str
    proven: bool = False


@dataclass(frozen=True, slots=True)
class IdempotencyKey:
    """Three hashes of 64 hexadecimal digits; nothing that a client has sent can be read in them.

    scope: of the kind of request, its room and the caller; in words for a queue's ball.
    key: of the caller's key.
    request: of the request.
    """

    scope: str
    key: str
    request: str


@dataclass(frozen=True, slots=True)
class UsedKey(IdempotencyKey):
    """A key in the ledger, and the fact that its first request has made.

    fact: the number of a drop, input or queue item in the room run `run`, or the id of a room or
    session.
    """

    run: int
    fact: str

    def check(self, key: IdempotencyKey) -> "UsedKey":
        """Raise KeyReusedError if `key` comes with another request."""
        if key.request != self.request:
            raise KeyReusedError(
                "this key was used before for another request; use a new key for each request",
                field="key",
            )
        return self


@dataclass(slots=True, eq=False)
class KeyUse:
    """The use of a key by a request, whose writes are skipped unless the use is new.

    key: None if the client sent none; the use is then new. run, fact: what the writes make, as in
    `UsedKey`. earlier: the first use, if the request is a repeat. error: set if the key belongs to
    another request.
    """

    key: IdempotencyKey | None = None
    run: int = 0
    fact: str = ""
    earlier: UsedKey | None = None
    error: KeyReusedError | None = None

    @property
    def is_new(self) -> bool:
        return self.earlier is None and self.error is None


def key_of(
    kind: str, room_id: str, caller: Caller, key: str, request: msgspec.Struct | None
) -> IdempotencyKey:
    """The key of a request of this kind, in this room; `request` must not contain the key."""
    body = msgspec.json.encode(request, order="sorted").decode()
    scope = _hash("scope", kind, room_id, caller.name)
    return IdempotencyKey(scope, _hash("key", key), _hash("request", body))


def ball_key(run: int, item: int, ball: int) -> IdempotencyKey:
    """The key of a queue's ball: no ball is dropped twice, even after a restart."""
    key = _hash("key", str(item), str(ball))
    return IdempotencyKey(f"{QUEUE}{run}", key, key)


def _hash(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()
