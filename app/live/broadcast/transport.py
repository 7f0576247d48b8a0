"""The one module that knows uvicorn's WebSocket connection from inside.

Two things ASGI cannot do: write bytes that are framed already, once for all clients, and find out
whether a client has read what it was sent; and get a close frame past the full write buffer of one
that has not. Under `DirectProtocol` a WebSocket's scope carries an extension that can do both.
`choose` tries it out at start-up: where uvicorn has changed, and under another server, all is sent
through ASGI's own calls, a little slower and otherwise the same.
"""

import asyncio
import logging
from collections.abc import MutableMapping
from typing import Any, Literal, cast

import uvicorn
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from uvicorn.server import ServerState
from websockets.protocol import State

from app.errors import SettingError
from app.live.broadcast.hub import Connection
from app.protocol.wire import WireMessage

EXTENSION = "plinko.connection"

DIRECT: Literal["direct"] = "direct"
PUBLIC: Literal["public"] = "public"

_GONE = 1006  # RFC 6455: the connection ended without a close frame

_log = logging.getLogger("plinko")


class DirectConnection:
    """A connection written to without ASGI."""

    def __init__(self, connection: "DirectProtocol") -> None:
        self._connection = connection

    def write(self, wire: bytes) -> bool:
        """Hand the bytes to the transport, unless it still holds some of earlier ones."""
        connection = self._connection
        transport = connection.transport
        if connection.close_sent or transport.is_closing() or transport.get_write_buffer_size():
            return False
        transport.write(wire)
        return True

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


class PublicConnection:
    """A connection written to through ASGI's own calls."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket

    def write(self, wire: bytes) -> bool:
        """Nothing can be sent without waiting."""
        return False

    async def send(self, message: WireMessage) -> None:
        """Send the frame when the server's buffer has room; raises WebSocketDisconnect."""
        if message.text:
            await self._socket.send_text(message.payload.decode())
        else:
            await self._socket.send_bytes(message.payload)


def connection_of(socket: WebSocket) -> Connection:
    """How to send to this client."""
    direct: DirectConnection | None = socket.scope.get("extensions", {}).get(EXTENSION)
    return direct or PublicConnection(socket)


def sever(scope: MutableMapping[str, Any], linger: float) -> None:
    """Let one more frame out and drop the connection after `linger` seconds, where that is known.

    Where it is not, the close waits for the client, bounded by the caller's timeout.
    """
    direct: DirectConnection | None = scope.get("extensions", {}).get(EXTENSION)
    if direct is not None:
        direct.sever(linger)


def choose(wanted: str) -> Literal["direct", "public"]:
    """The kind of connection to serve with: `auto` takes the direct one if it works.

    Raises SettingError when `direct` is demanded and does not.
    """
    if wanted == PUBLIC:
        return PUBLIC
    fault = self_test()
    if fault is None:
        return DIRECT
    if wanted == DIRECT:
        raise SettingError(f"transport='direct' does not work here: {fault}", field="transport")
    _log.warning("sending through public calls, since writing directly does not work: %s", fault)
    return PUBLIC


def protocol_class(kind: str) -> Any:
    """What uvicorn is to speak WebSocket with."""
    return DirectProtocol if kind == DIRECT else WebSocketsSansIOProtocol


class _Sink:
    """A transport that keeps what is written to it."""

    def __init__(self) -> None:
        self.written = b""

    def write(self, data: bytes) -> None:
        self.written += data

    def is_closing(self) -> bool:
        return False

    def get_write_buffer_size(self) -> int:
        return 0

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return default


def self_test() -> str | None:
    """Whether a frame written directly is what uvicorn would have sent: None, or what is amiss."""
    try:
        for size in (0, 125, 126, 65535, 65536):
            for whole in (WireMessage.of_text(b"x" * size), WireMessage.of_bytes(b"\0" * size)):
                public, direct = _both_ways(whole)
                if public != direct:
                    kind = "text" if whole.text else "binary"
                    return f"a {kind} frame of {size} bytes comes out differently"
    except Exception as error:  # noqa: BLE001 - whatever has changed inside uvicorn
        return f"{type(error).__name__}: {error}"
    return None


def _both_ways(message: WireMessage) -> tuple[bytes, bytes]:
    """The bytes of a message sent through ASGI, and written directly, over one open connection."""
    config = uvicorn.Config(
        lambda: None, interface="asgi3", log_config=None, ws_per_message_deflate=False
    )
    config.loaded, config.loaded_app = True, None  # it is not going to run anything
    loop = cast(asyncio.AbstractEventLoop, object())
    connection = DirectProtocol(config, ServerState(), {}, _loop=loop)
    sink = _Sink()
    connection.connection_made(cast(asyncio.Transport, sink))
    connection.handshake_complete = True
    connection.conn.state = State.OPEN
    asked: Any = {"type": "websocket.send"}
    asked |= {"text": message.payload.decode()} if message.text else {"bytes": message.payload}
    sending = connection.send(asked)
    try:
        sending.send(None)
        raise RuntimeError("an open connection made the sender wait")
    except StopIteration:
        public, sink.written = sink.written, b""
    if not (DirectConnection(connection).write(message.wire) and connection.writable.is_set()):
        raise RuntimeError("an open connection took no frame")
    return public, sink.written
