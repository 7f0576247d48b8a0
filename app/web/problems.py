"""Errors as RFC 9457 problem details: the one place where an exception becomes a response."""

import logging
from collections.abc import Sequence
from urllib.parse import quote

import msgspec
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from plinko.app.errors import (
    InvalidValueError,
    LeaseLostError,
    answer,
    retry_after,
    shorten,
    told,
)
from plinko.app.web.schemas.problem import FaultOf, Problem
from plinko.engine.errors import BoardError, PlinkoError
from plinko.engine.json_text import JsonObject

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
    assigned = answer(error)
    return Problem(
        type=f"{_TYPE}{assigned.code}",
        title=assigned.title,
        status=assigned.status,
        detail=told(error),
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


def _answer(request: Request, error: Exception) -> Response:
    if isinstance(error, LeaseLostError):
        raise error  # `plinko.app.cluster.hand_on` catches it and forwards the request
    request.app.state.services.metrics.errors.labels(answer(error).code).inc()
    return problem_response(error, request.url.path)


def _about(request: Request) -> dict[str, object]:
    """What the log says of a request; not its query, which may be private."""
    request_id = getattr(request.state, "request_id", None)
    return {"method": request.method, "path": request.url.path, "request_id": request_id}


async def _known_error(request: Request, error: Exception) -> Response:
    if answer(error).status == 500:
        _log.error("request failed", extra=_about(request), exc_info=error)
    return _answer(request, error)


async def _unknown_error(request: Request, error: Exception) -> Response:
    _log.error("request failed", extra=_about(request), exc_info=error)
    return _answer(request, error)


async def _gone(request: Request, error: Exception) -> Response:
    """The client left before its request was complete: no failure, and nobody to answer."""
    _log.info("client left", extra=_about(request))
    return Response(status_code=_CLIENT_GONE)


async def _bad_parameter(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    return _answer(request, _named(error.errors()))


def _named(errors: Sequence[JsonObject]) -> InvalidValueError:
    """The framework's first error, with the bad value in its message."""
    first = errors[0]
    field = str(first["loc"][-1])
    message = first["msg"][:1].lower() + first["msg"][1:]
    return InvalidValueError(f"{field} {shorten(first.get('input'))}: {message}", field=field)


async def _http_error(request: Request, error: Exception) -> Response:
    """An error that the framework raises itself: no such path, no such method."""
    assert isinstance(error, HTTPException)
    code = error.detail.lower().replace(" ", "-")
    problem = Problem(
        type=f"{_TYPE}{code}",
        title=error.detail,
        status=error.status_code,
        detail=f"{request.method} {shorten(request.url.path, 200)}: {error.detail}",
        code=code,
        instance=quote(request.url.path, safe=_PATH),
    )
    headers = dict(error.headers or {})
    return Response(msgspec.json.encode(problem), problem.status, headers, MEDIA_TYPE)


def install(app: FastAPI) -> None:
    """Make every error of the application leave it as problem details."""
    app.add_exception_handler(PlinkoError, _known_error)
    app.add_exception_handler(RequestValidationError, _bad_parameter)
    app.add_exception_handler(ClientDisconnect, _gone)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(Exception, _unknown_error)
