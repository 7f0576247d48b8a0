"""What a webhook's target is sent of a drop or a landing, and how that is signed. Pure."""

import base64
import hashlib
import hmac
from collections.abc import Sequence
from typing import Final

import msgspec

from app.persistence.statements.webhook_store import LANDED, Labels
from engine.json_text import Json, JsonObject

_ALWAYS: Final = ("tick", "seed", "x", "stake")
_OPTIONAL: Final = ("aim", "who", "name", "colour")
_RESULT: Final = ("tick", "bin", "score", "payout", "t", "x_end", "digest", "unsettled")


def event_of(row: JsonObject, labels: Labels) -> dict[str, object]:
    """One event, from what the ledger has of it; its `id` is the same however often it is told.

    labels: of the board's bins, or nothing. In an event `seed` is decimal text, `tick` that of the
    ball's start or of its end; lengths are in m, times in s, money is in minor units. `room` is the
    room's id and `run` numbers its present life.
    """
    landed = row["event"] == LANDED
    told: dict[str, Json] = {
        "id": f"{row['room']}.{row['ball']}.{row['event']}",
        "type": row["event"],
        "room": row["room_id"],
        "run": row["room"],
        "ball": row["ball"],
        "board": row["board"],
    }
    told |= {name: row[name] for name in _ALWAYS}
    told |= {name: row[name] for name in _OPTIONAL if row.get(name) is not None}
    if row["practice"]:
        told["practice"] = True
    if landed:
        told |= {name: row[f"result_{name}"] for name in _RESULT}
        if labels and told["bin"] is not None and (label := labels[told["bin"]]) is not None:
            told["label"] = label
    return told


def body_of(events: Sequence[JsonObject]) -> bytes:
    """The body of a request that tells of these."""
    return msgspec.json.encode({"events": events})


def signed(key: bytes, message: str, timestamp: int, body: bytes) -> dict[str, str]:
    """The headers by which a target knows who sent it this body, and when, in Unix time.

    As https://www.standardwebhooks.com has them, for which there are libraries in many languages.
    """
    whole = f"{message}.{timestamp}.".encode() + body
    code = base64.b64encode(hmac.digest(key, whole, hashlib.sha256)).decode()
    return {
        "content-type": "application/json",
        "webhook-id": message,
        "webhook-timestamp": str(timestamp),
        "webhook-signature": f"v1,{code}",
    }
