"""The OpenAPI document: what the interface is about, and the schemas that bodies are decoded by."""

from typing import Final

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from app.web.routes.common import components, documented_failures

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


LIMITED: Final = {
    "Retry-After": "Seconds after which trying again makes sense.",
    "RateLimit-Policy": "The limit: `q` at once, all of it again after `w` seconds.",
    "RateLimit": "What is left of it: `r` now, all of it in `t` seconds.",
}
"""Headers of an answer that a limit was reached."""


def _add_common_answers(responses: dict[str, object], has_body: bool) -> None:
    """What any request may get: a limit was reached; and any body: it is not JSON."""
    text = {"schema": {"type": "string"}}
    limit = documented_failures(429)[429]
    limit["headers"] = {name: {"description": what, **text} for name, what in LIMITED.items()}
    responses["429"] = limit
    if has_body:
        responses["415"] = documented_failures(415)[415]


def document(app: FastAPI) -> dict[str, object]:
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
                _add_common_answers(operation["responses"], "requestBody" in operation)
                # The framework's own 422 has another shape than what this server sends.
                refusal = operation["responses"].get("422")
                if refusal and "HTTPValidationError" in str(refusal):
                    del operation["responses"]["422"]
        app.openapi_schema = made
    return app.openapi_schema
