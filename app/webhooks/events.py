"""A webhook's events, and the signature of a request that carries them. Pure."""

import base64
import hashlib
import hmac
from collections.abc import Sequence
from typing import Final

import msgspec

from plinko.app.persistence.statements.webhook_store import LANDED, Labels
from plinko.engine.json_text import Json, JsonObject

_ALWAYS: Final = ("tick", "seed", "x", "stake")
_OPTIONAL: Final = ("aim", "who", "name", "colour")
_RESULT: Final = ("tick", "bin", "score", "payout", "t", "x_end", "digest", "unsettled")


def event_of(row: JsonObject, labels: Labels) -> dict[str, object]:
    """One event, from its row in the ledger; sent again, it has the same `id`.

    `labels` are those of the board's bins, or empty. In the event `seed` is decimal text, and
    `tick` is the tick of the ball's start or landing. Lengths are in m, times in s, money in minor
    units. `room` is the room's id, `run` the number of its run.
    """
    landed = row["event"] == LANDED
    event: dict[str, Json] = {
        "id": f"{row['room']}.{row['ball']}.{row['event']}",
        "type": row["event"],
        "room": row["room_id"],
        "run": row["room"],
        "ball": row["ball"],
        "board": row["board"],
    }
    event |= {name: row[name] for name in _ALWAYS} | {"seed": str(row["seed"])}
    event |= {name: row[name] for name in _OPTIONAL if row.get(name) is not None}
    if row["practice"]:
        event["practice"] = True
    if landed:
        event |= {name: row[f"result_{name}"] for name in _RESULT}
        if labels and event["bin"] is not None and (label := labels[event["bin"]]) is not None:
            event["label"] = label
    return event


def body_of(events: Sequence[JsonObject]) -> bytes:
    return msgspec.json.encode({"events": events})


def signed(key: bytes, message: str, timestamp: int, body: bytes) -> dict[str, str]:
    """The headers that prove to a target who sent this body, and when (Unix time).

    They follow https://www.standardwebhooks.com, which has libraries in many languages. `message`
    is the request's id.
    """
    whole = f"{message}.{timestamp}.".encode() + body
    code = base64.b64encode(hmac.digest(key, whole, hashlib.sha256)).decode()
    return {
        "content-type": "application/json",
        "webhook-id": message,
        "webhook-timestamp": str(timestamp),
        "webhook-signature": f"v1,{code}",
    }
