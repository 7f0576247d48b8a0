"""The OpenAPI document: what the interface is about, and the schemas that bodies are decoded by."""

from typing import Any, Final

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from app.web.schemas.document import components

DESCRIPTION: Final = """\
A Plinko board whose physics is true. The same board and seed give the same path, to the last bit,
here, in a live room, on the command line and on any other machine; a drop's `digest` says so.

Lengths are in metres (x right, y down), times in seconds, angles in radians. Seeds are integers
0 <= seed < 2^64, written as decimal strings because JSON readers round large numbers. Errors are
RFC 9457 problem details whose `detail` names the bad value. Live play is on the WebSocket
`/ws/rooms/{id}`.
"""

TAGS: Final = [
    {"name": "boards", "description": "Boards by name or by content."},
    {"name": "drops", "description": "Drops as values: computed, replayed, drawn, verified."},
    {"name": "pictures", "description": "Drops and what many drops come to, drawn."},
    {"name": "rooms", "description": "Live tables that any number of people watch."},
    {"name": "sessions", "description": "Staked drops that nobody could choose, and their log."},
    {"name": "health", "description": "For those who run the server."},
]


def document(app: FastAPI) -> dict[str, Any]:
    """The OpenAPI document, with the schemas that requests are really decoded by."""
    if app.openapi_schema is None:
        made = get_openapi(
            title=app.title,
            version=app.version,
            summary=app.summary,
            description=app.description,
            tags=app.openapi_tags,
            routes=app.routes,
        )
        made.setdefault("components", {})["schemas"] = components()
        for path in made["paths"].values():
            for operation in path.values():
                # The framework's own 422 has another shape than what this server sends.
                refusal = operation["responses"].get("422")
                if refusal and "HTTPValidationError" in str(refusal):
                    del operation["responses"]["422"]
        app.openapi_schema = made
    return app.openapi_schema
