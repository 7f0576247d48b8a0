"""Errors as RFC 9457 problem details: the one place where an exception becomes a response."""

import logging
from collections.abc import Sequence
from typing import Annotated
from urllib.parse import quote

import msgspec
from fastapi import Response
from fastapi.exceptions import RequestValidationError
from msgspec import Meta
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.types import Scope

from plinko.app.errors import (
    InvalidValueError,
    LeaseLostError,
    public_text,
    response_for,
    retry_after,
)
from plinko.engine.errors import BoardError, shorten
from plinko.engine.json_text import JsonObject


class FaultOf(msgspec.Struct, frozen=True):
    """One of several faults of a board."""

    field: Annotated[str, Meta(description="The bad value's place in the board's JSON.")]
    detail: str


class Problem(msgspec.Struct, frozen=True, omit_defaults=True):
    """An error, as RFC 9457 problem details; `detail` names the bad value."""

    type: str
    title: str
    status: int
    detail: str
    code: Annotated[str, Meta(description="The kind of error, a stable short name.")]
    field: Annotated[
        str | None, Meta(description="The bad value's place, if it is a single value.")
    ] = None
    instance: str | None = None
    faults: Annotated[
        tuple[FaultOf, ...], Meta(description="All faults of a board that has several.")
    ] = ()


MEDIA_TYPE = "application/problem+json"

MOVED = "plinko-moved"
"""Header of a response: nothing was done, because another server has the room.

Its value is that server's name in the ledger, if it is known.
"""

HOPS = "plinko-hops"
"""Header of a request that another server has forwarded."""

_TYPE = "urn:plinko:problem:"

_CLIENT_GONE = 499  # nginx's status for it; only logs show it

_PATH = "/:@!$&'()*+,;=~"  # characters that a path need not escape (RFC 3986, 3.3)

_log = logging.getLogger("plinko")


def problem_of(error: Exception, path: str = "") -> Problem:
    """The problem details of an error; the message of a foreign exception is not sent."""
    assigned = response_for(error)
    return Problem(
        type=f"{_TYPE}{assigned.code}",
        title=assigned.title,
        status=assigned.status,
        detail=public_text(error),
        code=assigned.code,
        field=getattr(error, "field", "") or None,
        instance=quote(path, safe=_PATH) or None,
        faults=_faults(error),
    )


def _faults(error: Exception) -> tuple[FaultOf, ...]:
    """All faults of a board that has several; `detail` and `field` describe a single one."""
    found = error.faults if isinstance(error, BoardError) else ()
    return tuple(FaultOf(*fault) for fault in found) if len(found) > 1 else ()


def problem_response(error: Exception, path: str = "") -> Response:
    problem = problem_of(error, path)
    headers = {}
    if problem.status == 401:
        headers["www-authenticate"] = "Bearer"
    if isinstance(error, LeaseLostError):
        headers[MOVED] = error.holder
    seconds = retry_after(error)
    if seconds is not None:
        headers["retry-after"] = str(seconds)
    return Response(msgspec.json.encode(problem), problem.status, headers, MEDIA_TYPE)


def respond(scope: Scope, error: Exception) -> Response:
    """The response to an error of a request; counts it, and logs what is the server's fault."""
    if isinstance(error, HTTPException):
        return _http_error(scope, error)
    about = {
        "method": scope["method"],
        "path": scope["path"],  # not the query, which may be private
        "request_id": scope["state"]["request_id"],
    }
    if isinstance(error, ClientDisconnect):  # no failure, and nobody to answer
        _log.info("client left", extra=about)
        return Response(status_code=_CLIENT_GONE)
    if isinstance(error, RequestValidationError):
        error = _named(error.errors())
    assigned = response_for(error)
    if assigned.status == 500:
        _log.error("request failed", extra=about, exc_info=error)
    scope["app"].state.services.metrics.errors.labels(assigned.code).inc()
    return problem_response(error, scope["path"])


def _named(errors: Sequence[JsonObject]) -> InvalidValueError:
    """The framework's first error, with the bad value in its message."""
    first = errors[0]
    field = str(first["loc"][-1])
    message = first["msg"][:1].lower() + first["msg"][1:]
    return InvalidValueError(f"{field} {shorten(first.get('input'))}: {message}", field=field)


def _http_error(scope: Scope, error: HTTPException) -> Response:
    """An error that the framework raises itself: no such path, no such method."""
    code = error.detail.lower().replace(" ", "-")
    problem = Problem(
        type=f"{_TYPE}{code}",
        title=error.detail,
        status=error.status_code,
        detail=f"{scope['method']} {shorten(scope['path'], 200)}: {error.detail}",
        code=code,
        instance=quote(scope["path"], safe=_PATH),
    )
    headers = dict(error.headers or {})
    return Response(msgspec.json.encode(problem), problem.status, headers, MEDIA_TYPE)
