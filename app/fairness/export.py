"""A session as one JSON object that whoever has it can check with no network, read and written.

The format is versioned, a field it does not have is refused, and docs/fairness.md describes it.
What is signed is in it as it was signed, `kind` and `version` included.
"""

from collections.abc import Iterable
from typing import Final

import msgspec

from app.fairness.statements import Count
from app.protocol.messages import SignedReceipt
from engine import merkle
from engine.errors import RecordError
from engine.json_text import JsonObject

KIND: Final = "plinko-session"
VERSION: Final = 1


class Signed(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A statement of the server's, with its signature in hexadecimal."""

    statement: JsonObject
    signature: str


class DropResult(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a drop ended; `payout` in minor units, `t` in s, `x_end` in m.

    All of it follows from the receipt, and the checker computes it. Earlier exports also have the
    room's `tick`, which follows from nothing that is signed: it is read over.
    """

    bin: Count | None
    score: float
    t: float
    x_end: float
    digest: str
    unsettled: str | None
    payout: Count
    tick: int | msgspec.UnsetType = msgspec.UNSET


class ExportedDrop(SignedReceipt, frozen=True, forbid_unknown_fields=True):
    """A drop with the proofs that its receipt is in the log and that the log only grew since."""

    inclusion: list[str]
    consistency: list[str]
    result: DropResult | None


class SessionExport(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A session. `server_seed` and `end` are null while it goes on, `client_seed` before it is.

    heard, heard_session: receipts that the player was given at the time, and the statement that
    they had before they opened their secret. The player adds both: a server could change them.
    draw: weights and seeds of the room, where it has a draw.
    """

    kind: str
    version: int
    key: str
    session: Signed
    board: JsonObject
    client_seed: str | None
    server_seed: str | None
    drops: list[ExportedDrop]
    head: Signed
    end: Signed | None
    heard: list[SignedReceipt] = []
    heard_session: Signed | None = None
    draw: JsonObject | msgspec.UnsetType = msgspec.UNSET


def is_export(fields: JsonObject) -> bool:
    """Whether a JSON object says that it is a session's export."""
    return fields.get("kind") == KIND


def with_heard(fields: JsonObject, reply: JsonObject) -> JsonObject:
    """An export with what its player was answered with at the time, over REST.

    reply: of POST sessions, which has the signed statement, or of a drop, which has its receipt.
    Raises RecordError for anything else.
    """
    if isinstance(reply.get("statement"), dict) and "signature" in reply:
        given = {name: reply[name] for name in ("statement", "signature")}
        return {**fields, "heard_session": given}
    if isinstance(reply.get("receipt"), dict):
        return {**fields, "heard": [*fields.get("heard", ()), reply["receipt"]]}
    raise RecordError(
        "a reply that was heard is that of POST sessions, with a statement and its signature, or "
        "of a drop in a session, with a receipt",
        field="heard",
    )


def read_export(fields: JsonObject) -> SessionExport:
    """The session of a JSON object; raises RecordError that names what is wrong with its form."""
    if fields.get("version") != VERSION:
        raise RecordError(
            f"the session's version is {fields.get('version')!r}, not {VERSION}", field="version"
        )
    try:
        return msgspec.convert(dict(fields), SessionExport)
    except msgspec.ValidationError as error:
        raise RecordError(f"not a session's export: {error}", field="session") from error


def make_export(
    session: SessionExport,
    drops: Iterable[tuple[SignedReceipt, DropResult | None]],
    lookup: merkle.Lookup,
) -> SessionExport:
    """`session` with these drops, each with the proofs that lead to the head of the log.

    `lookup` gives the log's complete subtrees.
    """
    size = int(session.head.statement["size"])
    proven = [
        ExportedDrop(
            receipt=each.receipt,
            index=each.index,
            root=each.root,
            signature=each.signature,
            inclusion=[node.hex() for node in merkle.inclusion(each.index, size, lookup)],
            consistency=[node.hex() for node in merkle.consistency(each.index + 1, size, lookup)],
            result=result,
        )
        for each, result in drops
    ]
    return msgspec.structs.replace(session, drops=proven)
