"""The one module that knows uvicorn's WebSocket connection from inside.

Two things ASGI cannot do: write bytes that are framed already, once for all clients, and find out
whether a client has read what it was sent; and get a close frame past the full write buffer of one
that has not. Under `DirectProtocol` a WebSocket's scope carries an extension that can do both.
The insides change between releases, so pyproject.toml names the one that this is written for.
"""

import asyncio
from typing import Any, Final

from starlette.types import Scope
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from app.live.broadcast.hub import Connection
from app.protocol.wire import WireMessage

EXTENSION = "plinko.connection"

_GONE = 1006  # RFC 6455: the connection ended without a close frame


PAST: Final = "plinko.past"
"""The extra information of a transport which says how to write past it to the socket's own."""


class Past:
    """Writes to a socket's transport past the one that stands before it, which reads the count.

    A tick is sent to hundreds of clients, and each object that is touched for every one of them has
    to be fetched from memory: through the transport in between a frame takes a tenth longer.
    """

    __slots__ = ("_transport", "written")

    def __init__(self, transport: asyncio.Transport) -> None:
        self._transport = transport
        self.written = 0  # bytes

    def write(self, wire: bytes) -> bool:
        """Hand over the bytes, unless some of earlier ones still wait."""
        transport = self._transport
        if transport.is_closing() or transport.get_write_buffer_size():
            return False
        self.written += len(wire)
        transport.write(wire)
        return True


class DirectConnection:
    """A connection written to without ASGI."""

    def __init__(self, connection: "DirectProtocol") -> None:
        self._connection = connection
        transport = connection.transport
        self._past: Past = transport.get_extra_info(PAST) or Past(transport)

    def write(self, wire: bytes) -> bool:
        """Hand the bytes to the transport, unless it still holds some of earlier ones."""
        return not self._connection.close_sent and self._past.write(wire)

    async def send(self, message: WireMessage) -> None:
        """Write the frame once all earlier bytes have left; raises WebSocketDisconnect."""
        while not self.write(message.wire):
            self._check()
            # With no room at all the transport says at once that it is full, and when it is empty.
            self._connection.transport.set_write_buffer_limits(high=0)
            await self._connection.writable.wait()
            self._check()
            self._connection.transport.set_write_buffer_limits()

    def _check(self) -> None:
        if self._connection.close_sent or self._connection.transport.is_closing():
            raise WebSocketDisconnect(_GONE)

    def sever(self, linger: float) -> None:
        """Let one more frame past the full buffer and drop the connection some seconds later."""
        self._connection.writable.set()
        asyncio.get_running_loop().call_later(linger, self._connection.transport.abort)


class DirectProtocol(WebSocketsSansIOProtocol):
    """uvicorn's connection, which lets the application write to it directly."""

    async def run_asgi(self) -> None:
        """Run the application with the connection among the scope's extensions."""
        extensions: Any = self.scope["extensions"]
        extensions[EXTENSION] = DirectConnection(self)
        await super().run_asgi()


def connection_of(socket: WebSocket) -> Connection:
    return _direct(socket.scope)


def sever(scope: Scope, linger: float) -> None:
    """Let one more frame out and drop the connection after `linger` seconds."""
    _direct(scope).sever(linger)


def _direct(scope: Scope) -> DirectConnection:
    direct: DirectConnection = scope["extensions"][EXTENSION]
    return direct
