"""Generates the AsyncAPI document of a room's WebSocket from the types of the messages."""

from collections.abc import Iterable
from typing import Final

import msgspec

from plinko.app.protocol import messages
from plinko.app.protocol.client_messages import Message
from plinko.engine.json_text import JsonObject

VERSION: Final = "3.0.0"

QUERY: Final = {
    "stream": {
        "type": "string",
        "enum": list(messages.STREAMS),
        "default": messages.SNAPSHOTS,
        "description": "The stream; it decides which binary messages the server sends.",
    },
    "protocol": {
        "type": "string",
        "enum": [str(messages.PROTOCOL_VERSION)],
        "description": "The version that the client speaks; the server refuses any other.",
    },
    "watch": {
        "type": "string",
        "enum": ["true"],
        "description": "The client will only watch, so any relay may serve it.",
    },
}
"""All query parameters of a room's address, by name."""

_SCHEMAS: Final = "#/components/schemas/{name}"
_CHANNEL: Final = "room"


def document(version: str) -> JsonObject:
    """The document for a server of this release; docs/protocol.md explains the messages."""
    events = _by_name(*messages.Event.__subclasses__())
    requests = _by_name(*Message.__args__)
    return {
        "asyncapi": VERSION,
        "info": {
            "title": "Plinko: the WebSocket of a room",
            "version": version,
            "description": "Text messages are JSON: one event or an array of them from the server, "
            "one message from the client. Binary messages, the snapshots or paths of balls, "
            "are described in docs/protocol.md byte by byte.",
        },
        "defaultContentType": "application/json",
        "channels": {
            _CHANNEL: {
                "address": "/ws/rooms/{room}",
                "parameters": {
                    "room": {"description": "`main`, a preset's name, or the id from `POST rooms`."}
                },
                "bindings": {
                    "ws": {
                        "query": {
                            "type": "object",
                            "properties": QUERY,
                            "additionalProperties": False,
                        }
                    }
                },
                "messages": {
                    name: {"$ref": f"#/components/messages/{name}"} for name in (*events, *requests)
                },
            }
        },
        "operations": {
            "hear": _operation("send", "The server sends an event.", events),
            "say": _operation("receive", "A client sends a message.", requests),
        },
        "components": {
            "messages": {name: _message(kind) for name, kind in (events | requests).items()},
            "schemas": schemas(),
        },
    }


def schemas() -> JsonObject:
    """The JSON Schemas of all events and messages, by name."""
    kinds = [*messages.Event.__subclasses__(), *Message.__args__]
    return msgspec.json.schema_components(kinds, ref_template=_SCHEMAS)[1]


def _by_name(*kinds: type[msgspec.Struct]) -> dict[str, type[msgspec.Struct]]:
    return {kind.__name__: kind for kind in kinds}


def _message(kind: type[msgspec.Struct]) -> dict[str, object]:
    name = kind.__name__
    return {
        "name": kind.__struct_config__.tag,
        "title": name,
        "summary": (kind.__doc__ or "").partition("\n")[0],
        "payload": {"$ref": _SCHEMAS.format(name=name)},
    }


def _operation(action: str, summary: str, kinds: Iterable[str]) -> dict[str, object]:
    return {
        "action": action,
        "summary": summary,
        "channel": {"$ref": f"#/channels/{_CHANNEL}"},
        "messages": [{"$ref": f"#/channels/{_CHANNEL}/messages/{name}"} for name in kinds],
    }
