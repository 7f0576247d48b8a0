"""The OpenAPI document: an introduction, and the same schemas that decode the bodies."""

from collections.abc import Sequence
from typing import Final

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from starlette.routing import BaseRoute

from plinko.app.web.routes.common import components, documented_failures

DESCRIPTION: Final = """\
A Plinko board with exact physics. The same board and seed give the same path, to the last bit,
here, in a live room, on the command line and on any other machine. Equal `digest`s prove it.

Lengths are in metres (x right, y down), times in seconds, angles in radians. Seeds are integers
0 <= seed < 2^64, written as decimal strings because JSON readers round large numbers. Errors are
RFC 9457 problem details whose `detail` names the bad value. Live play uses the WebSocket
`/ws/rooms/{id}`.
"""

TAGS: Final = [
    {"name": "boards", "description": "Boards by name or by content."},
    {"name": "drops", "description": "Drops outside of rooms: computed, replayed, verified."},
    {"name": "pictures", "description": "Pictures of drops, and of the results of many drops."},
    {"name": "rooms", "description": "Live rooms that any number of people can watch."},
    {"name": "sessions", "description": "Fair sessions: staked drops that nobody can choose."},
    {"name": "health", "description": "For the server's operator."},
]


LIMITED: Final = {
    "Retry-After": "Seconds to wait before the next try.",
    "RateLimit-Policy": "The limit: `q` at once, all of it again after `w` seconds.",
    "RateLimit": "What is left of the limit: `r` now, all of it in `t` seconds.",
}
"""Headers of a response that refuses a request because of a limit."""


def _add_common_answers(responses: dict[str, object], has_body: bool) -> None:
    """Add 429, which any request may get, and 415 for requests with a body."""
    text = {"schema": {"type": "string"}}
    limit = documented_failures(429)[429]
    limit["headers"] = {name: {"description": what, **text} for name, what in LIMITED.items()}
    responses["429"] = limit
    if has_body:
        responses["415"] = documented_failures(415)[415]


def document(app: FastAPI, routes: Sequence[BaseRoute]) -> dict[str, object]:
    """The OpenAPI document, made once."""
    if app.openapi_schema is None:
        made = get_openapi(
            title=app.title,
            version=app.version,
            summary=app.summary,
            description=app.description,
            tags=app.openapi_tags,
            routes=routes,
            servers=[{"url": app.state.services.settings.root_path or "/"}],
        )
        made.setdefault("components", {})["schemas"] = components()
        for path in made["paths"].values():
            for operation in path.values():
                _add_common_answers(operation["responses"], "requestBody" in operation)
                # This server's 422 is a problem document, not the framework's own shape.
                refusal = operation["responses"].get("422")
                if refusal and "HTTPValidationError" in str(refusal):
                    del operation["responses"]["422"]
        app.openapi_schema = made
    return app.openapi_schema
