"""ASGI middleware for every request: host, origin, body limit, security headers."""

import asyncio
import functools
import logging
import re
from collections.abc import Iterable, Mapping

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.gzip import GZipResponder, IdentityResponder
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from plinko.app.errors import AppError, HeadError, OriginError, TooLargeError, shorten
from plinko.app.web.edge.accepted import accepts_gzip, whole
from plinko.app.web.edge.addresses import Proxies
from plinko.app.web.edge.hosts import Hosts
from plinko.app.web.problems import problem_response

# Only the server's own files, and no inline scripts: a board's name or a room's id that is written
# into a page cannot become code.
_OWN_ONLY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; "
    "img-src 'self' data: blob:; "
    "font-src 'self'; connect-src 'self'; manifest-src 'self'; media-src 'self'; "
    "form-action 'none'; "
)
SECURITY_HEADERS = {
    "content-security-policy": f"{_OWN_ONLY}base-uri 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
}
_SECURITY_FIELDS = [(name.encode(), value.encode()) for name, value in SECURITY_HEADERS.items()]
_POLICY = b"content-security-policy"
_FRAMED = b"frame-ancestors *"
EMBEDDED = {"content-security-policy": f"{_OWN_ONLY}base-uri 'self'; {_FRAMED.decode()}"}
"""Headers of the only page that other sites may show in a frame."""

_AUTHORITY = re.compile(r"[^\s/?#@\\]+")

_SAFE_METHODS = ("GET", "HEAD", "OPTIONS")

# After a 413 the server reads and discards the rest of the body, up to these bounds. A client that
# sends its whole body before it reads then gets the answer instead of a broken pipe.
_DISCARD_BYTES = 32 << 20
_DISCARD_SECONDS = 5.0

_FORWARDERS_NAMED = 8

_SCHEMES = dict.fromkeys(("http", "ws"), ("http", "ws"))
_SCHEMES |= dict.fromkeys(("https", "wss"), ("https", "wss"))

_COMPRESSED = 1024  # bytes; compressing a shorter body saves less than it costs
_EFFORT = 5  # zlib's level; 9 takes three times as long and saves two percent more
_IN_THREAD = 1 << 14  # bytes; a longer body is compressed on a thread, so that no tick waits
_PACKED = (
    "image/png",
    "image/jpeg",
    "image/gif",
    "image/webp",
    "image/apng",
    "multipart/*",
    "video/*",
    "font/*",
)

MAX_BODY = 1 << 20  # bytes of a request's body

_log = logging.getLogger("plinko")


def check_origin(headers: Mapping[str, str], allowed: Iterable[str]) -> None:
    """Raise OriginError if a page of another site sent the request.

    A request without an Origin header does not come from a page.
    """
    origin = headers.get("origin")
    if origin is None or origin in allowed:
        return
    if _authority(origin) != headers.get("host", "").lower():
        raise OriginError(f"origin {shorten(origin, 100)} may not use this server", field="origin")


def _authority(origin: str) -> str | None:
    """Host and port of an origin as browsers write it; None if it is invalid, such as `null`."""
    scheme, separator, authority = origin.lower().partition("://")
    whole = separator and scheme in ("http", "https") and _AUTHORITY.fullmatch(authority)
    return authority if whole else None


class Admission:
    """Refuses requests for a host that is not this server, and those of other sites' pages.

    The first get 421: see edge/hosts.py. Two Host lines get 400: a proxy may have trusted the other
    one. Another site's page may not open a WebSocket or send an unsafe request, or any page that a
    player opens could drop balls here, or overload a server on loopback.
    """

    def __init__(self, app: ASGIApp, hosts: Hosts, allowed: tuple[str, ...]) -> None:
        self.app = app
        self.hosts = hosts
        self.allowed = allowed

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] in ("http", "websocket"):
            try:
                self._check(scope)
            except AppError as error:
                await _refuse(scope, receive, send, error)
                return
        await self.app(scope, receive, send)

    def _check(self, scope: Scope) -> None:
        headers = Headers(scope=scope)
        named = headers.getlist("host")
        if len(named) > 1:
            raise HeadError(f"{len(named)} Host lines, instead of one", field="host")
        self.hosts.check(named[0] if named else None)
        if scope["type"] == "websocket" or scope["method"] not in _SAFE_METHODS:
            check_origin(headers, self.allowed)


async def _refuse(scope: Scope, receive: Receive, send: Send, error: AppError) -> None:
    response = problem_response(error, scope["path"])
    if scope["type"] == "http":
        await response(scope, receive, send)
        return
    await receive()  # the connect message
    start = {"status": response.status_code, "headers": response.raw_headers}
    await send({"type": "websocket.http.response.start", **start})
    await send({"type": "websocket.http.response.body", "body": response.body})


class Forwarded:
    """Replaces a trusted proxy's address and scheme by those of its client.

    If a proxy names no address, its clients count as one: else each odd text would be a client of
    its own, without any limit. So do the clients of a proxy that is not trusted; the log warns of
    it. Anybody can send the header, so the log names only a few addresses, each once.
    """

    def __init__(self, app: ASGIApp, proxies: Proxies) -> None:
        self.app = app
        self._proxies = proxies
        self._named: set[str] = set()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "lifespan":
            host = (scope.get("client") or ("",))[0]
            if host in self._proxies:
                self._believe(scope)
            elif len(self._named) < _FORWARDERS_NAMED:
                self._warn(scope, host)
        await self.app(scope, receive, send)

    def _believe(self, scope: Scope) -> None:
        headers = Headers(scope=scope)
        client = self._proxies.client_of(", ".join(headers.getlist("x-forwarded-for")))
        if client is not None:
            scope["client"] = (client, 0)
        scheme = headers.getlist("x-forwarded-proto")[-1:]
        if scheme and (name := scheme[0].strip().lower()) in _SCHEMES:
            scope["scheme"] = _SCHEMES[name][scope["type"] == "websocket"]

    def _warn(self, scope: Scope, host: str) -> None:
        if host not in self._named and "x-forwarded-for" in Headers(scope=scope):
            self._named.add(host)
            _log.warning(
                "X-Forwarded-For from %s is ignored: if this is your proxy, name it in "
                "--trusted-proxies; until then all its clients share the limits of one client",
                host,
            )


class SecurityHeaders:
    """Adds the security headers to every HTTP response, also to a refused WebSocket handshake."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                headers = list(message.get("headers", ()))
                given = dict(headers)
                headers += [field for field in _SECURITY_FIELDS if field[0] not in given]
                if _FRAMED in given.get(_POLICY, b""):  # X-Frame-Options has no value for all sites
                    headers = [field for field in headers if field[0] != b"x-frame-options"]
                message["headers"] = headers
            await send(message)

        await self.app(scope, receive, send_with_headers)


class Compression:
    """Compresses responses for clients that prefer it, and then makes their ETags weak.

    The bytes differ from those of the uncompressed response. If both had the same strong tag, a
    cache could join parts of the two (RFC 9110, 8.8.1). A 304 gets the tag in the form that the
    client sent. Starlette's own middleware looks for `gzip` anywhere in the client's header.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        async def send_weakened(message: Message) -> None:
            if message["type"] == "http.response.start":
                _weaken(message, Headers(scope=scope))
            await send(message)

        compressed = accepts_gzip(whole(Headers(scope=scope), "accept-encoding"))
        responder = _gzip(self.app) if compressed else _identity(self.app)
        await responder(scope, receive, send_weakened)


_identity = functools.partial(
    IdentityResponder, minimum_size=_COMPRESSED, exclude_content_types=_PACKED
)
_gzip = functools.partial(
    GZipResponder,
    minimum_size=_COMPRESSED,
    compresslevel=_EFFORT,
    thread_minimum_size=_IN_THREAD,
    exclude_content_types=_PACKED,
)


def _weaken(start: Message, asked: Headers) -> None:
    headers = MutableHeaders(scope=start)
    etag = headers.get("etag", "")
    if etag.startswith('"') and (
        "content-encoding" in headers
        or (start["status"] == 304 and f"W/{etag}" in asked.get("if-none-match", ""))
    ):
        headers["etag"] = f"W/{etag}"


class _BodyOverflowError(Exception):
    """Carries the overflow from `receive` up through the application."""


class BodyLimit:
    """Answers 413 as soon as a body is known to be over the limit; keeps nothing of the body."""

    def __init__(self, app: ASGIApp, max_body: int) -> None:
        self.app = app
        self.max_body = max_body

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        announced = headers.get("content-length", "")
        if announced.isdigit() and int(announced[:20]) > self.max_body:
            await self._answer(scope, receive, send, headers, f"{announced[:20]} bytes")
            return
        size = 0
        started = False

        async def counted_receive() -> Message:
            nonlocal size
            message = await receive()
            size += len(message.get("body", b""))
            if size > self.max_body:
                raise _BodyOverflowError
            return message

        async def watched_send(message: Message) -> None:
            nonlocal started
            started = True
            await send(message)

        try:
            await self.app(scope, counted_receive, watched_send)
        except _BodyOverflowError:
            if started:
                raise
            await self._answer(scope, receive, send, headers, f"more than {size - 1} bytes")

    async def _answer(
        self, scope: Scope, receive: Receive, send: Send, headers: Headers, size: str
    ) -> None:
        error = TooLargeError(
            f"the body has {size}; the limit is {self.max_body} bytes", field="body"
        )
        response = problem_response(error, scope["path"])
        response.headers["connection"] = "close"
        start = {"status": response.status_code, "headers": response.raw_headers}
        await send({"type": "http.response.start", **start})
        # Send the whole answer now; only its formal end waits for the rest of the request's body.
        await send({"type": "http.response.body", "body": response.body, "more_body": True})
        if "expect" not in headers:
            await _discard(receive)
        await send({"type": "http.response.body", "body": b"", "more_body": False})


async def _discard(receive: Receive) -> None:
    """Read and discard the rest of the body, within bounds of size and time."""
    size = 0
    try:
        async with asyncio.timeout(_DISCARD_SECONDS):
            while size <= _DISCARD_BYTES:
                message = await receive()
                size += len(message.get("body", b""))
                if message["type"] == "http.disconnect" or not message.get("more_body", False):
                    return
    except TimeoutError:
        return  # the answer has been sent already
