"""Read and write the export of a fair session: one JSON object that anybody can check offline.

docs/fairness.md describes the format. It has a version, and unknown fields are refused. Signed
statements are included exactly as signed, with `kind` and `version`.
"""

from collections.abc import Iterable
from typing import Final

import msgspec

from plinko.app.fairness.statements import Count
from plinko.app.protocol.messages import SignedReceipt
from plinko.engine import merkle
from plinko.engine.errors import RecordError
from plinko.engine.json_text import JsonObject

KIND: Final = "plinko-session"
VERSION: Final = 1


class Signed(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A statement of the server with its signature in hexadecimal."""

    statement: JsonObject
    signature: str


class KeyChange(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The server's change from one key to the next, signed by both; see `KeyStatement`.

    former_signature: null if the former key was lost.
    """

    statement: JsonObject
    signature: str
    former_signature: str | None


class DropResult(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a drop ended: `payout` in minor units, `t` in s, `x_end` in m.

    The checker recomputes all of it from the receipt. Earlier exports also have the room's `tick`,
    which no signed value determines; it is ignored.
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
    """A drop with proofs that its receipt is in the log and that the log has only grown since."""

    inclusion: list[str]
    consistency: list[str]
    result: DropResult | None


class SessionExport(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A session. `server_seed` and `end` are null until it ends, `client_seed` until it is opened.

    heard: receipts that the player received during the session. heard_session: the statement that
    the player received before they opened their secret. The player adds both, because a server
    could change them. draw: the room's weights and seeds, if it has a draw. keys: the changes of
    the server's key since the session began, the latest first; `key` is the latest key.
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
    keys: list[KeyChange] | msgspec.UnsetType = msgspec.UNSET


def is_export(fields: JsonObject) -> bool:
    """Whether a JSON object claims to be a session's export."""
    return fields.get("kind") == KIND


def with_heard(fields: JsonObject, reply: JsonObject) -> JsonObject:
    """Add a REST reply that the player kept to an export.

    reply: to POST sessions, with the signed statement, or to a drop, with its receipt. Raises
    RecordError for other replies.
    """
    if isinstance(reply.get("statement"), dict) and "signature" in reply:
        given = {name: reply[name] for name in ("statement", "signature")}
        return {**fields, "heard_session": given}
    if isinstance(reply.get("receipt"), dict):
        return {**fields, "heard": [*fields.get("heard", ()), reply["receipt"]]}
    raise RecordError(
        "the kept reply has neither a statement with its signature nor a receipt: give the reply "
        "to POST sessions or to a drop in a session",
        field="heard",
    )


def read_export(fields: JsonObject) -> SessionExport:
    """Parse an export; raises RecordError if its form is wrong."""
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
    """Add drops to `session`, each with its proofs for the head of the log.

    `lookup` gives the hashes of the log's complete subtrees.
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
