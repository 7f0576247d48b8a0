"""Bodies of players' sessions, over REST."""

from typing import Annotated

import msgspec
from msgspec import Meta

from app.fairness.export import Signed
from app.web.schemas.fields import Digest
from engine.json_text import Json, JsonObject

_HEX = {"type": "string", "pattern": "^[0-9a-fA-F]{64}$"}

Key = Annotated[
    str,
    Meta(description="The server's public key (Ed25519), 64 hexadecimal digits."),
]
Signature = Annotated[
    str,
    Meta(
        description="Ed25519 over the statement as canonical JSON (RFC 8785), 128 hexadecimal "
        "digits."
    ),
]


class SessionRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Begin a session in a room."""

    commitment: Annotated[
        Json,
        Meta(
            description="SHA-256 of a secret of yours of 32 bytes, 64 hexadecimal digits.",
            extra_json_schema=_HEX,
        ),
    ]
    room: Annotated[str, Meta(description="The room in which its drops are.")] = "main"


class SessionOpening(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Open the secret that was committed to."""

    seed: Annotated[
        Json,
        Meta(description="Your secret, 64 hexadecimal digits.", extra_json_schema=_HEX),
    ]


class SessionView(msgspec.Struct, frozen=True, kw_only=True):
    """A session as it stands."""

    session: str
    room: str
    statement: Annotated[
        JsonObject, Meta(description="What the server committed to at the beginning.")
    ]
    signature: Signature
    key: Key
    open: Annotated[bool, Meta(description="Whether the player's secret is open.")]
    drops: Annotated[int, Meta(description="How many there were: the next one's number.")]
    ended: bool


class SessionBegun(SessionView, frozen=True, kw_only=True):
    """A session of one's own. The token is shown this once and cannot be had again."""

    token: Annotated[
        str, Meta(description="Send it as `Authorization: Bearer TOKEN` to drop and to end.")
    ]


class SessionEnd(msgspec.Struct, frozen=True):
    """The end of a session, with the server's secret."""

    session: str
    server_seed: Digest
    statement: JsonObject
    signature: Signature


class LogHead(msgspec.Struct, frozen=True):
    """How the log of all receipts stands, and that it only grew since."""

    key: Key
    head: Signed
    consistency: Annotated[
        list[str], Meta(description="The proof (RFC 6962) from the size asked for; empty for none.")
    ]
