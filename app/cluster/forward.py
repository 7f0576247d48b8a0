"""Forwards each request to the server that has its room, so that any server serves every client.

The middleware first calls the app of this server. If the room is at another server, the app does
nothing and raises LeaseLostError, which names that server, and the middleware forwards the request
there. While a room moves between servers, it tries again after a pause. A request is forwarded only
once: the server that received it from the client is the one that tries again.
"""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Sequence
from typing import Final
from urllib.parse import quote, urlsplit

import httpx
from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect, Request
from starlette.responses import StreamingResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from plinko.app.cluster.alive import Alive
from plinko.app.cluster.membership import Member
from plinko.app.errors import AppError, EndedError, LeaseLostError
from plinko.app.relay.proxy import RESTART, both_ways, end_of
from plinko.app.web.problems import HOPS, MOVED, problem_response

_CONNECT: Final = 1.0  # s
_ANSWER: Final = 2.0
"""Seconds to wait for the answer to this server's own request: for a list, or until the other
server has restored a room, so that clients find it there."""


class Peers:
    """For the event loop's thread. `forwarded` counts requests and WebSockets."""

    def __init__(self, transport: httpx.AsyncBaseTransport | None = None) -> None:
        self.forwarded = 0
        # Shorter than a server keeps an idle connection open, so that the server does not close a
        # connection just as a request is sent on it.
        limits = httpx.Limits(max_connections=None, keepalive_expiry=2.0)
        timeout = httpx.Timeout(None, connect=_CONNECT)
        self.http = httpx.AsyncClient(
            timeout=timeout, limits=limits, trust_env=False, transport=transport
        )

    async def have_taken(self, member: Member, room_id: str) -> None:
        """Ask another server to take the room handed over to it; without this it does so later."""
        await self._get(member, f"/api/v1/rooms/{quote(room_id, safe='')}")

    async def ask(self, member: Member, path: str, part: str) -> list[object]:
        """The list `part` in another server's answer to a GET (its first page); [] on failure."""
        answer = await self._get(member, path)
        listed: list[object] = [] if answer is None or answer.is_error else answer.json()[part]
        return listed

    async def _get(self, member: Member, path: str) -> httpx.Response | None:
        with contextlib.suppress(httpx.HTTPError, TimeoutError):
            async with asyncio.timeout(_ANSWER):
                return await self.http.get(
                    f"{member.address}{path}", headers={HOPS: "1", "host": "localhost"}
                )
        return None


_SOCKETS: Final = "/ws/rooms/"

_PAUSES: Final = (0.05, 0.1, 0.2, *[0.4] * 19)
"""Seconds before each further attempt. The first pauses are as long as most moves of a room take;
the later ones are long, so that many waiting requests do not slow the move down."""

_CLOSE_SECONDS: Final = 1.0  # for the closing handshake with the other server

_OF_ONE_HOP: Final = frozenset(
    b"connection keep-alive proxy-connection te trailer transfer-encoding upgrade".split()
)
"""Headers for the next hop only (RFC 9110, 7.6.1)."""

_NOT_PASSED: Final = _OF_ONE_HOP | frozenset(
    b"content-length expect origin x-forwarded-for x-forwarded-proto".split()
)
"""Headers that are not forwarded: in addition those that are computed again for the new request,
and the origin, which this server has checked."""

_SAFE: Final = ("GET", "HEAD", "OPTIONS")  # methods of requests that may be sent twice

_UNKNOWN: Final = (
    "the server that had the room ended before it answered, so the request may or may not have "
    "taken effect; look at the room before you repeat it"
)


class Forward:
    """`app` answers here. `fetch` loads a room, or raises LeaseLostError with its server."""

    def __init__(
        self, app: ASGIApp, alive: Alive, peers: Peers, fetch: Callable[[str], Awaitable[None]]
    ) -> None:
        self.app = app
        self._alive = alive
        self._peers = peers
        self._fetch = fetch

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
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
        lost = await self._bring(
            lambda: self.app(dict(scope), _again(body, receive), send),
            lambda member: self._ask(member, scope, body, receive, send),
            pauses=() if HOPS in Headers(scope=scope) else _PAUSES,
        )
        if lost is not None:
            await problem_response(lost, scope["path"])(scope, receive, send)

    async def _socket(self, scope: Scope, receive: Receive, send: Send) -> None:
        client = WebSocket(scope, receive, send)

        async def here() -> None:
            try:
                await self._fetch(scope["path"].removeprefix(_SOCKETS))
            except LeaseLostError:
                raise
            except AppError:
                pass  # the app reports it to the client
            await self.app(scope, receive, send)

        pauses = () if HOPS in client.headers else _PAUSES
        if await self._bring(here, lambda member: self._talk(member, client), pauses=pauses):
            await self.app(scope, receive, send)  # it tells the client to reconnect

    async def _bring(
        self,
        here: Callable[[], Awaitable[None]],
        there: Callable[[Member], Awaitable[bool]],
        *,
        pauses: Sequence[float],
    ) -> LeaseLostError | None:
        """Answer here or there, and try again after each pause.

        Returns None, or the last LeaseLostError if no attempt succeeded.
        """
        for pause in (*pauses, None):
            try:
                await here()
            except LeaseLostError as error:
                lost = error
            else:
                return None
            if pause is not None:
                member = self._alive.view.members.get(lost.holder)
                if member and await there(member):
                    return None
                await asyncio.sleep(pause)
        return lost

    async def _ask(
        self, member: Member, scope: Scope, body: bytes, receive: Receive, send: Send
    ) -> bool:
        """Forward a request to `member`; False if the request may be sent again.

        It may be if the other server has done nothing, or if the method is safe.
        """
        self._peers.forwarded += 1
        asking = self._peers.http.stream(
            scope["method"],
            httpx.URL(member.address).copy_with(raw_path=_target(scope)),
            headers=_headers(scope),
            content=body,
        )
        answer = None
        try:
            async with self._alive.while_there(member), asking as answer:
                if MOVED in answer.headers:
                    return False
                passed = StreamingResponse(answer.aiter_raw(), answer.status_code)
                passed.raw_headers = [
                    each for each in answer.headers.raw if each[0].lower() not in _OF_ONE_HOP
                ]
                await passed(scope, receive, send)
                return True
        except (httpx.HTTPError, TimeoutError) as error:
            if answer is not None:
                raise  # part of the response was sent, so it must break off here too
            never_sent = isinstance(error, httpx.ConnectError | httpx.ConnectTimeout)
            if never_sent or scope["method"] in _SAFE:
                return False
        await problem_response(EndedError(_UNKNOWN), scope["path"])(scope, receive, send)
        return True

    async def _talk(self, member: Member, client: WebSocket) -> bool:
        """Connect a client with `member` until one side ends; False if `member` refuses."""
        self._peers.forwarded += 1
        at, host = urlsplit(member.address), client.headers.get("host", "localhost")
        scheme = at.scheme.replace("http", "ws")
        headers = [
            (name.decode("latin-1"), value.decode("latin-1"))
            for name, value in _headers(client.scope)
            if name != b"host"
        ]
        joining = connect(
            f"{scheme}://{host}{_target(client.scope).decode('latin-1')}",
            host=at.hostname,
            port=at.port or {"ws": 80, "wss": 443}[scheme],
            additional_headers=headers,
            user_agent_header=None,
            compression=None,
            max_size=None,
            proxy=None,
            ping_interval=None,
            # No limit while that server is alive: repeated attempts would add to its load.
            open_timeout=None,
            close_timeout=_CLOSE_SECONDS,
        )
        try:
            async with self._alive.while_there(member):
                room = await joining
        except (OSError, InvalidHandshake, ConnectionClosed, TimeoutError):
            return False
        async with room:
            end = RESTART, "the room is moving to another server; reconnect"
            with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                await client.accept()
                with contextlib.suppress(TimeoutError):
                    async with self._alive.while_there(member):
                        await both_ways(client, room)
                        end = end_of(room)
                await client.close(*end)
        return True


def _again(body: bytes, receive: Receive) -> Receive:
    """A `receive` that returns the body, already read, again, and then further messages."""
    whole: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

    async def receive_again() -> Message:
        return whole.pop() if whole else await receive()

    return receive_again


def _target(scope: Scope) -> bytes:
    query: bytes = scope["query_string"]
    path: bytes = scope["raw_path"].partition(b"?")[0]
    return path + (b"?" + query if query else b"")


def _headers(scope: Scope) -> list[tuple[bytes, bytes]]:
    """The forwarded request's headers: the client's, its address and scheme, and HOPS."""
    kept = [
        (name, value)
        for name, value in scope["headers"]
        if name not in _NOT_PASSED and not name.startswith(b"sec-websocket-")
    ]
    if scope.get("client"):
        kept.append((b"x-forwarded-for", scope["client"][0].encode()))
    proto = scope["scheme"].replace("ws", "http").encode()
    return [*kept, (b"x-forwarded-proto", proto), (HOPS.encode(), b"1")]
