"""One HTTP request handed on to the server that has its room, and the answer handed back."""

import asyncio
import contextlib
from collections.abc import Iterable
from enum import Enum
from typing import Final

import httpx
from starlette.types import Scope, Send

from app.cluster.body import Body
from app.cluster.membership import Member
from app.cluster.node import Node
from app.web.problems import MOVED
from app.web.shared import HOPS

_OF_ONE_HOP: Final = frozenset(
    (
        b"connection",
        b"keep-alive",
        b"proxy-connection",
        b"te",
        b"trailer",
        b"transfer-encoding",
        b"upgrade",
    )
)
"""Headers that are for the next hop alone (RFC 9110, 7.6.1)."""

_OURS: Final = frozenset(
    (b"content-length", b"x-forwarded-for", b"x-forwarded-proto", HOPS.encode(), b"expect")
)

_REPEATABLE: Final = ("GET", "HEAD", "OPTIONS")

_NEVER_SENT: Final = (httpx.ConnectError, httpx.ConnectTimeout)


class Outcome(Enum):
    """What came of handing a request on."""

    DONE = "answered"
    AGAIN = "nothing was done: the room has left"
    SILENT = "nothing was done: its server takes no connection"
    UNKNOWN = "the server ended over it, and it may have been done or not"


async def pass_http(
    node: Node, member: Member, scope: Scope, body: Body, send: Send, hops: int
) -> Outcome:
    """Have `member` answer a request, whose client may leave meanwhile."""
    request = httpx.Request(
        scope["method"],
        httpx.URL(member.address).copy_with(raw_path=_target(scope)),
        headers=headers_for(scope, hops),
        content=await body.whole(),
    )
    asking = asyncio.create_task(node.line.http.send(request, stream=True))
    leaving = asyncio.create_task(body.until_left())
    ending = asyncio.create_task(node.alive.until_gone(member))
    try:
        await asyncio.wait((asking, leaving, ending), return_when=asyncio.FIRST_COMPLETED)
        if leaving.done() and not asking.done():
            return Outcome.DONE
        if not asking.done():
            return _lost(scope)
        try:
            answer = asking.result()
        except _NEVER_SENT:
            return Outcome.SILENT
        except httpx.HTTPError:
            return _lost(scope)
        async with contextlib.aclosing(answer):
            if answer.status_code == 503 and MOVED in answer.headers:
                return Outcome.AGAIN
            await _answer(answer, send, leaving, ending)
        return Outcome.DONE
    finally:
        await _ended(asking, leaving, ending)


async def _ended(asking: "asyncio.Task[httpx.Response]", *tasks: "asyncio.Task[None]") -> None:
    for task in (asking, *tasks):
        task.cancel()
    await asyncio.gather(asking, *tasks, return_exceptions=True)


def _lost(scope: Scope) -> Outcome:
    return Outcome.AGAIN if scope["method"] in _REPEATABLE else Outcome.UNKNOWN


def _target(scope: Scope) -> bytes:
    query: bytes = scope["query_string"]
    path: bytes = scope["raw_path"].partition(b"?")[0]
    return path + (b"?" + query if query else b"")


def headers_for(scope: Scope, hops: int) -> list[tuple[bytes, bytes]]:
    """The client's headers, who it is, and that the request was handed on once more."""
    kept = list(without(scope["headers"], _OF_ONE_HOP | _OURS))
    client = scope.get("client")
    if client:
        kept.append((b"x-forwarded-for", client[0].encode()))
    kept.append((b"x-forwarded-proto", scope["scheme"].replace("ws", "http").encode()))
    kept.append((HOPS.encode(), str(hops + 1).encode()))
    return kept


def without(
    headers: Iterable[tuple[bytes, bytes]], names: frozenset[bytes]
) -> Iterable[tuple[bytes, bytes]]:
    """Those headers that have none of these names."""
    return ((name, value) for name, value in headers if name.lower() not in names)


async def _answer(
    answer: httpx.Response,
    send: Send,
    leaving: "asyncio.Task[None]",
    ending: "asyncio.Task[None]",
) -> None:
    """Pass an answer on as it comes; a stream ends when its client or its server does."""
    headers = list(without(answer.headers.raw, _OF_ONE_HOP))
    await send({"type": "http.response.start", "status": answer.status_code, "headers": headers})
    passing = asyncio.create_task(_stream(answer, send))
    await asyncio.wait((passing, leaving, ending), return_when=asyncio.FIRST_COMPLETED)
    try:
        if passing.done():
            passing.result()  # an answer that broke off is broken off here as well
    finally:
        passing.cancel()
        await asyncio.gather(passing, return_exceptions=True)


async def _stream(answer: httpx.Response, send: Send) -> None:
    async for part in answer.aiter_raw():
        await send({"type": "http.response.body", "body": part, "more_body": True})
    await send({"type": "http.response.body", "body": b"", "more_body": False})
