"""Brings each request to the server that has its room; for the client there is one server.

A request is answered here. Where the answer is that its room is at another server, which the answer
names, nothing was done, and the request is handed on to that server; where the room is on its way
between servers, it is tried again. A request is handed on once: the server that it came to is the
one to try again.
"""

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable, Iterable, Iterator, Set
from typing import Final
from urllib.parse import urlsplit

import httpx
from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect, Request
from starlette.responses import StreamingResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from app.cluster.alive import Alive
from app.cluster.membership import Member
from app.cluster.peers import Peers
from app.errors import AppError, EndedError, LeaseLostError
from app.relay.line import RESTART, both_ways, end_of
from app.web.problems import MOVED, problem_response
from app.web.shared import HOPS

_SOCKETS: Final = "/ws/rooms/"

_TRY_SECONDS: Final = 8.0  # for which a request is tried again
_FIRST_PAUSE: Final = 0.03  # s until it is; each pause is twice the one before, up to
_LONGEST_PAUSE: Final = 0.4  # s

_OPEN_SECONDS: Final = 2.0  # for another server to take a WebSocket
_CLOSE_SECONDS: Final = 1.0  # for it to hear that the client has left

_OF_ONE_HOP: Final = {
    *(b"connection", b"keep-alive", b"proxy-connection", b"te", b"trailer"),
    *(b"transfer-encoding", b"upgrade"),
}
"""Headers that are for the next hop alone (RFC 9110, 7.6.1)."""

_NOT_PASSED: Final = _OF_ONE_HOP | {
    *(b"content-length", b"expect", b"x-forwarded-for", b"x-forwarded-proto", HOPS.encode()),
}
_OF_A_HANDSHAKE: Final = {
    *(b"host", b"origin", b"user-agent"),  # the origin was found good here
    *(b"sec-websocket-key", b"sec-websocket-version"),
    *(b"sec-websocket-extensions", b"sec-websocket-protocol"),
}

_NEVER_SENT: Final = (httpx.ConnectError, httpx.ConnectTimeout)
_SAFE: Final = ("GET", "HEAD", "OPTIONS")  # methods of requests that may be sent twice

_UNKNOWN: Final = (
    "the server that had the room ended before it answered; whether it did what was asked is seen "
    "in the room"
)


class HandOn:
    """`app` answers here. `fetch` has a room in memory, or raises which server has it instead."""

    def __init__(
        self, app: ASGIApp, alive: Alive, peers: Peers, fetch: Callable[[str], Awaitable[None]]
    ) -> None:
        self.app = app
        self._alive = alive
        self._peers = peers
        self._fetch = fetch

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, here or there."""
        if scope["type"] == "http" and HOPS not in Headers(scope=scope):
            await self._request(scope, receive, send)
        elif scope["type"] == "websocket" and scope["path"].startswith(_SOCKETS):
            await self._socket(scope, receive, send)
        else:
            await self.app(scope, receive, send)

    async def _request(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            body = await Request(scope, receive).body()
        except ClientDisconnect:
            return
        for pause in _pauses():
            holder = await self._here(dict(scope), _again(body, receive), send)
            if holder is None:
                return
            member = self._alive.view.members.get(holder)
            if member and await self._there(member, scope, body, receive, send):
                return
            await asyncio.sleep(pause)
        await self.app(scope, _again(body, receive), send)

    async def _here(self, scope: Scope, receive: Receive, send: Send) -> str | None:
        """Answer here; where the room is at another server, return its name and answer nothing."""
        holder: str | None = None

        async def unless_moved(message: Message) -> None:
            nonlocal holder
            if message["type"] == "http.response.start" and message["status"] == 503:
                holder = Headers(raw=message["headers"]).get(MOVED)
            if holder is None:
                await send(message)

        await self.app(scope, receive, unless_moved)
        return holder

    async def _there(
        self, member: Member, scope: Scope, body: bytes, receive: Receive, send: Send
    ) -> bool:
        """Have `member` answer; False where nothing was done, or may be done again."""
        self._peers.handed_on += 1
        asking = self._peers.http.stream(
            scope["method"],
            httpx.URL(member.address).copy_with(raw_path=_target(scope)),
            headers=_headers(scope),
            content=body,
        )
        answer = None
        try:
            async with self._alive.while_there(member), asking as answer:
                if answer.status_code == 503 and MOVED in answer.headers:
                    return False
                passed = StreamingResponse(answer.aiter_raw(), answer.status_code)
                passed.raw_headers = _without(answer.headers.raw, _OF_ONE_HOP)
                await passed(scope, receive, send)
                return True
        except (httpx.HTTPError, TimeoutError) as error:
            if answer is not None:
                raise  # an answer that breaks off there breaks off here
            if isinstance(error, _NEVER_SENT) or scope["method"] in _SAFE:
                return False
        await problem_response(EndedError(_UNKNOWN), scope["path"])(scope, receive, send)
        return True

    async def _socket(self, scope: Scope, receive: Receive, send: Send) -> None:
        client = WebSocket(scope, receive, send)
        if HOPS not in client.headers:
            for pause in _pauses():
                try:
                    await self._fetch(scope["path"].removeprefix(_SOCKETS))
                    break
                except LeaseLostError as moved:
                    member = self._alive.view.members.get(moved.holder)
                    if member and await self._talk(member, client):
                        return
                except AppError:
                    break  # the app tells the client below
                await asyncio.sleep(pause)
        elif self._alive.leaving:  # the server before this one finds the room where it goes
            await client.close(RESTART)
            return
        await self.app(scope, receive, send)

    async def _talk(self, member: Member, client: WebSocket) -> bool:
        """Have `member` talk to a client until one of them ends; False if it does not answer."""
        self._peers.handed_on += 1
        at, host = urlsplit(member.address), client.headers.get("host", "localhost")
        scheme, port = ("wss", 443) if at.scheme == "https" else ("ws", 80)
        headers = _without(_headers(client.scope), _OF_A_HANDSHAKE)
        try:
            async with self._alive.while_there(member):
                room = await connect(
                    f"{scheme}://{host}{_target(client.scope).decode('latin-1')}",
                    host=at.hostname,
                    port=at.port or port,
                    additional_headers=[
                        (n.decode("latin-1"), v.decode("latin-1")) for n, v in headers
                    ],
                    user_agent_header=None,
                    compression=None,
                    max_size=None,
                    proxy=None,
                    ping_interval=None,
                    open_timeout=_OPEN_SECONDS,
                    close_timeout=_CLOSE_SECONDS,
                )
        except (OSError, InvalidHandshake, ConnectionClosed, TimeoutError):
            return False
        async with room:
            end = RESTART, "the room is brought to another server"
            with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                await client.accept()
                with contextlib.suppress(TimeoutError):
                    async with self._alive.while_there(member), self._peers.socket():
                        await both_ways(client, room)
                        end = end_of(room)
                await client.close(*end)
        return True


def _pauses() -> Iterator[float]:
    """s after which a request is tried again, each time, until that has lasted long enough."""
    end, pause = time.monotonic() + _TRY_SECONDS, _FIRST_PAUSE
    while time.monotonic() < end:
        yield pause
        pause = min(2 * pause, _LONGEST_PAUSE)


def _again(body: bytes, receive: Receive) -> Receive:
    """What gives a body that was read once more, and then what comes after it."""
    whole: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

    async def receive_again() -> Message:
        return whole.pop() if whole else await receive()

    return receive_again


def _target(scope: Scope) -> bytes:
    query: bytes = scope["query_string"]
    path: bytes = scope["raw_path"].partition(b"?")[0]
    return path + (b"?" + query if query else b"")


def _headers(scope: Scope) -> list[tuple[bytes, bytes]]:
    """The client's headers, who it is, and that its request was handed on."""
    kept = _without(scope["headers"], _NOT_PASSED)
    if scope.get("client"):
        kept.append((b"x-forwarded-for", scope["client"][0].encode()))
    kept.append((b"x-forwarded-proto", scope["scheme"].replace("ws", "http").encode()))
    kept.append((HOPS.encode(), b"1"))
    return kept


def _without(
    headers: Iterable[tuple[bytes, bytes]], names: Set[bytes]
) -> list[tuple[bytes, bytes]]:
    """Those headers that have none of these names."""
    return [(name, value) for name, value in headers if name.lower() not in names]
