"""HTTP to a target that is not trusted: it can send no more than a reply's head.

A head of any length would be parsed on the event loop, and a reply may begin with any number of
interim ones (`100 Continue`): a target that sends those without end would stop every room.
"""

import ssl
from typing import Any, Final

import httpcore
import httpx

MOST_READ: Final = 1 << 14
"""Bytes of a connection. Parsing as many of `100 Continue` takes 6 ms."""

_AT_ONCE: Final = 1 << 12  # bytes between two turns of the event loop


class Transport(httpx.AsyncBaseTransport):
    """Sends requests as httpx does; a response has only the status and the headers."""

    def __init__(self) -> None:
        context = httpx.create_ssl_context(trust_env=False)
        self._pool = httpcore.AsyncConnectionPool(context, network_backend=_Network())

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        url = request.url
        address = httpcore.URL(
            scheme=url.raw_scheme, host=url.raw_host, port=url.port, target=url.raw_path
        )
        try:
            async with self._pool.stream(
                request.method,
                address,
                headers=request.headers.raw,
                content=await request.aread(),
                extensions=request.extensions,
            ) as found:
                return httpx.Response(found.status, headers=found.headers)
        except (
            httpcore.NetworkError,
            httpcore.ProtocolError,
            httpcore.TimeoutException,
        ) as error:
            text = str(error) or type(error).__name__
            raise httpx.TransportError(text, request=request) from error

    async def aclose(self) -> None:
        await self._pool.aclose()


class _Network(httpcore.AnyIOBackend):
    async def connect_tcp(self, *args: Any, **options: Any) -> httpcore.AsyncNetworkStream:
        return _Bounded(await super().connect_tcp(*args, **options))


class _Bounded(httpcore.AsyncNetworkStream):
    """A connection that fails after MOST_READ bytes have been read."""

    def __init__(self, stream: httpcore.AsyncNetworkStream) -> None:
        self._stream = stream
        self._left = MOST_READ

    async def read(self, max_bytes: int, timeout: float | None = None) -> bytes:
        if self._left <= 0:
            raise httpcore.ReadError(f"more than {MOST_READ} bytes before the reply's head ends")
        found = await self._stream.read(min(max_bytes, self._left, _AT_ONCE), timeout)
        self._left -= len(found)
        return found

    async def write(self, buffer: bytes, timeout: float | None = None) -> None:
        await self._stream.write(buffer, timeout)

    async def start_tls(
        self,
        ssl_context: ssl.SSLContext,
        server_hostname: str | None = None,
        timeout: float | None = None,
    ) -> httpcore.AsyncNetworkStream:
        return _Bounded(await self._stream.start_tls(ssl_context, server_hostname, timeout))

    async def aclose(self) -> None:
        await self._stream.aclose()

    def get_extra_info(self, info: str) -> Any:
        return self._stream.get_extra_info(info)
