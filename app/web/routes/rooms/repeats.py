"""Requests that a client may repeat: the headers that identify the request and its caller."""

from dataclasses import dataclass
from typing import Annotated, Final

import msgspec
from fastapi import Depends, Header, Request

from plinko.app.rooms.keys import Caller, KeyUse, key_of
from plinko.app.web.routes.common import Server, address_of

Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=255,
        description="A text of your choice. A request repeated with it is carried out only once; "
        "another request with it is refused.",
    ),
]

Secret = Annotated[
    str | None,
    Header(
        alias="Idempotency-Secret",
        min_length=32,
        max_length=255,
        description="A random text that only you know. Keys sent with it belong to it and not to "
        "your address, and a repeated request gets its token again.",
    ),
]

OWNER: Final = Caller("owner")
"""The caller of a request that needs a room's token, among the callers of that room."""


@dataclass(frozen=True, slots=True)
class Repeatable:
    """The headers of a request. caller: the sender, unless the request names a session or owner."""

    key: str | None
    caller: Caller

    def use(
        self, kind: str, room_id: str, request: msgspec.Struct | None, caller: Caller | None = None
    ) -> KeyUse:
        """The use of the request's key; `kind` and `room_id` stand for the path."""
        if self.key is None:
            return KeyUse()
        return KeyUse(key_of(kind, room_id, caller or self.caller, self.key, request))


def session_caller(session_id: str) -> Caller:
    """The caller of a request that needs a session's token."""
    return Caller(f"session {session_id}")


def _repeatable(
    request: Request, server: Server, key: Key = None, secret: Secret = None
) -> Repeatable:
    if secret is not None:
        return Repeatable(key, Caller(f"secret {secret}", proven=True))
    return Repeatable(key, Caller(f"address {server.tokens.mark_of(address_of(request))}"))


Repeats = Annotated[Repeatable, Depends(_repeatable)]
