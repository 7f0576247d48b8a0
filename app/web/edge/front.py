"""The one layer in front of an application: what every request must pass and every response has.

A request's headers are read once. The layer finds the client behind a trusted proxy, refuses
requests for another host or from another site's page, bounds the body, and answers HEAD and every
error. A response gets its id, what is left of the client's limits, the security headers, and is
compressed for clients that prefer it.
"""

import asyncio
import functools
import logging
import random
import re
import socket
from collections.abc import Callable, Iterable
from typing import Final

from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import GZipResponder
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from plinko.app.errors import AppError, BusyError, HeadError, OriginError, TooLargeError
from plinko.app.settings import Settings
from plinko.app.web.edge.accepted import accepts_gzip
from plinko.app.web.edge.addresses import Proxies
from plinko.app.web.edge.hosts import Hosts
from plinko.app.web.limits import Allowance
from plinko.app.web.problems import HOPS, problem_response
from plinko.engine.errors import shorten

# Only the server's own files, and no inline scripts: a board's name or a room's id that is written
# into a page cannot become code.
_OWN_ONLY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; "
    "img-src 'self' data: blob:; "
    "font-src 'self'; connect-src 'self'; manifest-src 'self'; media-src 'self'; "
    "form-action 'none'; "
)
SECURITY_HEADERS: Final = {
    "content-security-policy": f"{_OWN_ONLY}base-uri 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
}
_SECURITY_FIELDS = [(name.encode(), value.encode()) for name, value in SECURITY_HEADERS.items()]
_POLICY = b"content-security-policy"
_FRAMED = b"frame-ancestors *"
EMBEDDED: Final = {"content-security-policy": f"{_OWN_ONLY}base-uri 'none'; {_FRAMED.decode()}"}
"""Headers of the only page that other sites may show in a frame."""

MAX_BODY: Final = 1 << 20  # bytes of a request's body

# After a 413 the server reads and discards the rest of the body, up to these bounds. A client that
# sends its whole body before it reads then gets the answer instead of a broken pipe.
_DISCARD_BYTES = 32 << 20
_DISCARD_SECONDS = 5.0

_AUTHORITY = re.compile(r"[^\s/?#@\\]+")
_SAFE_METHODS = ("GET", "HEAD", "OPTIONS")
_ID = re.compile(rb"[A-Za-z0-9._~-]{1,64}")
_FORWARDERS_NAMED = 8

_SCHEMES = dict.fromkeys(("http", "ws"), ("http", "ws"))
_SCHEMES |= dict.fromkeys(("https", "wss"), ("https", "wss"))

_COMPRESSED = 1024  # bytes; compressing a shorter body saves less than it costs
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
_gzip = functools.partial(
    GZipResponder,
    minimum_size=_COMPRESSED,
    compresslevel=5,  # 9 takes three times as long and saves two percent more
    thread_minimum_size=1 << 14,  # bytes; a longer body goes to a thread, so that no tick waits
    exclude_content_types=_PACKED,
)

_shared = functools.partial(
    CORSMiddleware,
    allow_methods=["GET", "POST", "PUT", "PATCH", "DELETE"],
    allow_headers=[
        "content-type",
        "authorization",
        "idempotency-key",
        "idempotency-secret",
        "x-request-id",
    ],
    expose_headers=[
        "etag",
        "link",
        "location",
        "ratelimit",
        "ratelimit-policy",
        "retry-after",
        "x-request-id",
    ],
)

_REQUEST_ID, _HOPS = b"x-request-id", HOPS.encode()

_ids = random.Random()

_log = logging.getLogger("plinko")

Fields = dict[bytes, bytes]
"""Headers by name; several lines of one header are one list."""


def note(scope: Scope, allowance: Allowance) -> None:
    """Have the response report a limit; of several reports of one limit the last counts."""
    found = scope.get("state", {}).get("allowances")
    if found is not None:
        found[allowance.name] = allowance


class Front:
    """An ASGI application around `app`; `respond` makes the response to an error of a request."""

    def __init__(
        self,
        app: ASGIApp,
        settings: Settings,
        respond: Callable[[Scope, Exception], Response] = lambda scope, error: problem_response(
            error, scope["path"]
        ),
        check_banned: Callable[[str], None] = lambda address: None,
    ) -> None:
        self._app = app
        self._respond = respond
        self._check_banned = check_banned
        self._proxies = Proxies(settings.trusted_proxies)
        self._hosts = Hosts(settings.host, settings.hosts, socket.gethostname())
        self._allowed = settings.allowed_origins
        self._root_path = settings.root_path
        self._named: set[str] = set()  # addresses whose X-Forwarded-For was ignored

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        fields = _fields(scope)
        scope["root_path"] = self._root_path
        self._find_client(scope, fields)
        if scope["type"] == "http":
            await self._request(scope, fields, receive, send)
        else:
            await self._socket(scope, fields, receive, send)

    async def _request(self, scope: Scope, fields: Fields, receive: Receive, send: Send) -> None:
        exchange = _Exchange(scope, fields, receive, send, self._root_path)
        try:
            self._admit(scope, fields)
        except AppError as refused:
            await self._respond(scope, refused)(scope, receive, exchange.send)
            return

        async def answered(scope: Scope, receive: Receive, send: Send) -> None:
            try:
                exchange.check_announced()
                await self._app(scope, receive, send)
            except _BodyOverflowError as overflow:
                if exchange.begun:
                    raise
                await exchange.refuse_body(self._respond(scope, overflow.error), send)
            except (Exception, asyncio.CancelledError) as error:
                if exchange.begun:  # uvicorn cuts the connection off
                    raise
                await self._respond(scope, _cause(error))(scope, receive, send)

        app: ASGIApp = answered
        if self._allowed and b"origin" in fields:
            app = _shared(app, allow_origins=self._allowed)
        if exchange.compresses:
            app = _gzip(app)
        await app(exchange.scope, exchange.receive, exchange.send)

    async def _socket(self, scope: Scope, fields: Fields, receive: Receive, send: Send) -> None:
        """Refuse a handshake, or pass it on; a refusal has the security headers."""

        async def send_secured(message: Message) -> None:
            if message["type"] == "websocket.http.response.start":
                message = {**message, "headers": secured(list(message["headers"]))}
            await send(message)

        try:
            self._admit(scope, fields)
        except AppError as refused:
            response = problem_response(refused, scope["path"])
            await receive()  # the connect message
            await response(scope, receive, send_secured)
            return
        await self._app(scope, receive, send_secured)

    def _find_client(self, scope: Scope, fields: Fields) -> None:
        """Replace a trusted proxy's address and scheme by those of its client.

        If a proxy names no address, its clients count as one: else each odd text would be a client
        of its own, without any limit. So do the clients of a proxy that is not trusted; the log
        warns of it. Anybody can send the header, so the log names only a few addresses, each once.
        """
        forwarded = fields.get(b"x-forwarded-for")
        host = (scope.get("client") or ("",))[0]
        if host in self._proxies:
            client = self._proxies.client_of((forwarded or b"").decode("latin-1"))
            if client is not None:
                scope["client"] = (client, 0)
            scheme = fields.get(b"x-forwarded-proto", b"").decode("latin-1").rpartition(",")[2]
            if (name := scheme.strip().lower()) in _SCHEMES:
                scope["scheme"] = _SCHEMES[name][scope["type"] == "websocket"]
        elif (
            forwarded is not None
            and host not in self._named
            and len(self._named) < _FORWARDERS_NAMED
        ):
            self._named.add(host)
            _log.warning(
                "X-Forwarded-For from %s is ignored: if this is your proxy, name it in "
                "--trusted-proxies; until then all its clients share the limits of one client",
                host,
            )

    def _admit(self, scope: Scope, fields: Fields) -> None:
        """Refuse requests of banned addresses, for foreign hosts, and of other sites' pages.

        Those for another host get 421: see hosts.py. Two Host lines get 400: a proxy may have
        trusted the other one. Another site's page may not open a WebSocket or send an unsafe
        request, or any page that a player opens could drop balls here, or overload a server on
        loopback.
        """
        if scope.get("client"):
            self._check_banned(scope["client"][0])
        host = fields.get(b"host")
        if host is not None and b"," in host:
            named = sum(name == b"host" for name, _ in scope["headers"])
            if named > 1:
                raise HeadError(
                    f"the request has {named} Host headers; it must have one", field="host"
                )
        self._hosts.check(None if host is None else host.decode("latin-1"))
        if b"origin" in fields and (
            scope["type"] == "websocket" or scope["method"] not in _SAFE_METHODS
        ):
            _check_origin(fields, self._allowed)


def _fields(scope: Scope) -> Fields:
    found: Fields = {}
    for name, value in scope["headers"]:
        found[name] = found[name] + b", " + value if name in found else value
    return found


def _check_origin(fields: Fields, allowed: Iterable[str]) -> None:
    """Raise OriginError if a page of another site sent the request."""
    origin = fields[b"origin"].decode("latin-1")
    if origin in allowed:
        return
    if _authority(origin) != fields.get(b"host", b"").decode("latin-1").lower():
        raise OriginError(f"origin {shorten(origin, 100)} may not use this server", field="origin")


def _authority(origin: str) -> str | None:
    """Host and port of an origin as browsers write it; None if it is invalid, such as `null`."""
    scheme, separator, authority = origin.lower().partition("://")
    whole = separator and scheme in ("http", "https") and _AUTHORITY.fullmatch(authority)
    return authority if whole else None


def _cause(error: BaseException) -> Exception:
    """The error to report: uvicorn cancels requests that outlast the grace period of a stop."""
    return error if isinstance(error, Exception) else BusyError("the server is stopping")


class _BodyOverflowError(Exception):
    """Carries the overflow of a body from `receive` up through the application."""

    def __init__(self, size: str) -> None:
        text = f"the body has {size}; the limit is {MAX_BODY} bytes"
        self.error = TooLargeError(text, field="body")


class _Exchange:
    """One request and its response."""

    def __init__(
        self, scope: Scope, fields: Fields, receive: Receive, send: Send, root_path: str
    ) -> None:
        self.begun = False
        self.compresses = accepts_gzip(fields.get(b"accept-encoding", b"").decode("latin-1"))
        self._fields = fields
        self._receive = receive
        self._send = send
        # If one server forwards the request to another, only the first one adds the path.
        self._root_path = b"" if _HOPS in fields else root_path.encode()
        given = fields.get(_REQUEST_ID, b"")
        self._id = given if _ID.fullmatch(given) else b"%032x" % _ids.getrandbits(128)
        self._allowances: dict[str, Allowance] = {}
        state = scope.setdefault("state", {})
        state["request_id"], state["allowances"] = self._id.decode(), self._allowances
        self._head = scope["method"] == "HEAD"
        self._ended = False
        self._size = 0  # bytes of the body received
        self.scope = _as_get(scope) if self._head else scope

    async def receive(self) -> Message:
        """The next message of the client; raises _BodyOverflowError.

        After the head of a HEAD's response it is `http.disconnect`, which ends a live stream.
        """
        if self._head and self._ended:
            return {"type": "http.disconnect"}
        message = await self._receive()
        self._size += len(message.get("body", b""))
        if self._size > MAX_BODY:
            raise _BodyOverflowError(f"more than {MAX_BODY} bytes")
        return message

    def check_announced(self) -> None:
        """Raise _BodyOverflowError if the body will be over the limit."""
        announced = self._fields.get(b"content-length", b"")[:20]
        if announced.isdigit() and int(announced) > MAX_BODY:
            raise _BodyOverflowError(f"{announced.decode()} bytes")

    async def refuse_body(self, response: Response, send: Send) -> None:
        """Answer at once, then read and discard the rest of the body, within bounds."""
        response.headers["connection"] = "close"
        start = {"status": response.status_code, "headers": response.raw_headers}
        await send({"type": "http.response.start", **start})
        await send({"type": "http.response.body", "body": response.body, "more_body": True})
        if b"expect" not in self._fields:
            await self._discard()
        await send({"type": "http.response.body", "body": b"", "more_body": False})

    async def _discard(self) -> None:
        size = 0
        try:
            async with asyncio.timeout(_DISCARD_SECONDS):
                while size <= _DISCARD_BYTES:
                    message = await self._receive()
                    size += len(message.get("body", b""))
                    if message["type"] == "http.disconnect" or not message.get("more_body", False):
                        return
        except TimeoutError:
            return  # the answer has been sent already

    async def send(self, message: Message) -> None:
        """Send a message of the response, its start with all headers; of a HEAD only the start."""
        if message["type"] == "http.response.start":
            self.begun = True
            _log_access(self.scope, self._id, message["status"])
            await self._send({**message, "headers": self._completed(message)})
        elif not self._head:
            await self._send(message)
        elif not self._ended:
            self._ended = True
            await self._send({"type": "http.response.body", "body": b"", "more_body": False})

    def _completed(self, start: Message) -> list[tuple[bytes, bytes]]:
        """The headers of a response, with those that every response has."""
        given = dict(start.get("headers", ()))
        status, etag = start["status"], given.get(b"etag", b"")
        more = {_REQUEST_ID: self._id}
        if self._allowances:
            limits = self._allowances.values()
            more[b"ratelimit-policy"] = ", ".join(each.policy for each in limits).encode()
            more[b"ratelimit"] = ", ".join(each.rest for each in limits).encode()
        if self._root_path:
            if given.get(b"location", b"").startswith(b"/"):
                more[b"location"] = self._root_path + given[b"location"]
            if given.get(b"link", b"").startswith(b"</"):
                more[b"link"] = b"<" + self._root_path + given[b"link"][1:]
        if not self.compresses and _would_compress(status, given):
            vary = given.get(b"vary")
            more[b"vary"] = vary + b", Accept-Encoding" if vary else b"Accept-Encoding"
        # The bytes of a compressed response differ from those of the plain one. If both had the
        # same strong tag, a cache could join parts of the two (RFC 9110, 8.8.1). A 304 gets the tag
        # in the form that the client sent.
        if etag.startswith(b'"') and (
            b"content-encoding" in given
            or (status == 304 and b"W/" + etag in self._fields.get(b"if-none-match", b""))
        ):
            more[b"etag"] = b"W/" + etag
        headers = [field for field in start.get("headers", ()) if field[0] not in more]
        return secured([*headers, *more.items()])


def _log_access(scope: Scope, request: bytes, status: int) -> None:
    if _log.isEnabledFor(logging.DEBUG):
        client, method = scope.get("client") or ("",), scope["method"]
        about = {"client": client[0], "method": method, "path": scope["path"], "status": status}
        _log.debug("request", extra={**about, "request": request.decode()})


def _as_get(scope: Scope) -> Scope:
    """A HEAD's scope as a GET's. A head describes the whole, never a part (RFC 9110, 14.2)."""
    headers = [each for each in scope["headers"] if each[0] != b"range"]
    return {**scope, "method": "GET", "headers": headers}


def _would_compress(status: int, given: Fields) -> bool:
    """Whether another client would get the response compressed, so that caches must distinguish."""
    if status in (204, 206, 304) or b"content-encoding" in given:
        return False
    size = given.get(b"content-length")
    return (size is None or int(size) >= _COMPRESSED) and not _is_packed(
        given.get(b"content-type", b"")
    )


@functools.lru_cache(maxsize=64)
def _is_packed(content_type: bytes) -> bool:
    kind = content_type.decode("latin-1").partition(";")[0].strip().lower()
    return kind in _PACKED or f"{kind.partition('/')[0]}/*" in _PACKED


def secured(headers: list[tuple[bytes, bytes]]) -> list[tuple[bytes, bytes]]:
    """Headers of a response with the security headers that it does not have yet."""
    given = dict(headers)
    headers = headers + [field for field in _SECURITY_FIELDS if field[0] not in given]
    if _FRAMED in given.get(_POLICY, b""):  # X-Frame-Options has no value for all sites
        headers = [field for field in headers if field[0] != b"x-frame-options"]
    return headers
