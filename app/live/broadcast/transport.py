"""Writes to uvicorn's WebSocket connections directly, past ASGI.

ASGI cannot write frames that are already encoded, once for all clients; it does not say whether a
client has read what it was sent; and it cannot close a connection whose write buffer is full. Under
`DirectProtocol` a WebSocket's scope has an extension that can. It uses uvicorn's internals, as
app/web/edge does. They change between releases, so pyproject.toml pins the release.
"""

import asyncio
import contextlib
from typing import Any, Final

from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from plinko.app.errors import AppError, SlowClientError, public_text, response_for
from plinko.app.protocol.wire import WireMessage

EXTENSION = "plinko.connection"

_CLOSE_SECONDS = 1.0  # s to wait for room in the send buffer, for the close frame

_GONE = 1006  # RFC 6455: the connection ended without a close frame


PAST: Final = "plinko.past"
"""Name of a wrapping transport's extra info that writes to the inner transport directly."""


class Past:
    """Writes to a socket's transport, past a transport that wraps it and reads `written`.

    A tick goes to hundreds of clients, and every object on the way to each of them has to be
    fetched from memory: through the wrapping transport a frame takes 10 % longer.
    """

    __slots__ = ("_transport", "written")

    def __init__(self, transport: asyncio.Transport) -> None:
        self._transport = transport
        self.written = 0  # bytes

    def write(self, wire: bytes) -> bool:
        """Write the bytes, unless earlier ones still wait in the buffer."""
        transport = self._transport
        if transport.is_closing() or transport.get_write_buffer_size():
            return False
        self.written += len(wire)
        transport.write(wire)
        return True


class DirectConnection:
    """A WebSocket connection without ASGI in between."""

    def __init__(self, connection: "DirectProtocol") -> None:
        self._connection = connection
        transport = connection.transport
        self._past: Past = transport.get_extra_info(PAST) or Past(transport)

    def write(self, wire: bytes) -> bool:
        """Write the bytes, unless earlier ones still wait or the connection is closing."""
        return not self._connection.close_sent and self._past.write(wire)

    async def send(self, message: WireMessage) -> None:
        """Wait until all earlier bytes have left, and write; raises WebSocketDisconnect."""
        while not self.write(message.wire):
            self._check()
            # With a limit of 0 the transport reports at once that it is full, and later that it
            # is empty, rather than below some limit.
            self._connection.transport.set_write_buffer_limits(high=0)
            await self._connection.writable.wait()
            self._check()
            self._connection.transport.set_write_buffer_limits()

    def _check(self) -> None:
        if self._connection.close_sent or self._connection.transport.is_closing():
            raise WebSocketDisconnect(_GONE)

    def sever(self, linger: float) -> None:
        """Let a close frame into the full buffer, and abort `linger` seconds later."""
        self._connection.writable.set()
        asyncio.get_running_loop().call_later(linger, self._connection.transport.abort)


class DirectProtocol(WebSocketsSansIOProtocol):
    """uvicorn's connection, with a `DirectConnection` among the scope's extensions."""

    async def run_asgi(self) -> None:
        extensions: Any = self.scope["extensions"]
        extensions[EXTENSION] = DirectConnection(self)
        await super().run_asgi()


def connection_of(socket: WebSocket) -> DirectConnection:
    direct: DirectConnection = socket.scope["extensions"][EXTENSION]
    return direct


async def close(socket: WebSocket, error: AppError, linger: float) -> None:
    """Close with the reason. A client that does not read has `linger` seconds to receive it."""
    if isinstance(error, SlowClientError):
        connection_of(socket).sever(linger)
    # RFC 6455 leaves 123 bytes for the reason.
    reason = public_text(error).encode()[:120].decode(errors="ignore")
    with contextlib.suppress(WebSocketDisconnect, TimeoutError, RuntimeError):
        async with asyncio.timeout(_CLOSE_SECONDS):
            await socket.close(response_for(error).close, reason)
