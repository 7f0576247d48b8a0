"""One client's connection, a layer between its socket and uvicorn's protocols.

It counts the connection while it is open, takes turns with all others in parsing, and cuts off a
client that does not read. For asyncio it is the protocol of the socket; for uvicorn's protocol it
is the transport: first for HTTP, and after an upgrade for the WebSocket. It uses only documented
parts of asyncio and nothing internal to uvicorn.
"""

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

from plinko.app.errors import AppError, response_for
from plinko.app.live.broadcast.transport import PAST, Past
from plinko.app.web.edge.addresses import Connections, one_client
from plinko.app.web.edge.front import SECURITY_HEADERS
from plinko.app.web.edge.intake import Intake
from plinko.app.web.problems import problem_response

_HEAD_END = b"\r\n\r\n"

_log = logging.getLogger("plinko")


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """The limits of a connection, and what all connections share.

    head_bytes: of the request line and headers
    head_seconds: until a head is complete
    body_seconds: from the head until the body is complete, or a WebSocket's handshake answered
    unread_seconds: in which a client must read something of what it is sent
    frame_rate: WebSocket frames a second; a burst may have twice that and one fragmented message
    refused: called with the code of each refusal
    """

    head_bytes: int
    head_seconds: float
    body_seconds: float
    unread_seconds: float
    frame_rate: float
    connections: Connections
    intake: Intake
    refused: Callable[[str], None] = lambda code: None


def refusal(error: Exception) -> bytes:
    """An error as the bytes of an HTTP response that closes its connection."""
    made = problem_response(error)
    made.headers.update(SECURITY_HEADERS)
    made.headers["connection"] = "close"
    head = f"HTTP/1.1 {made.status_code} {HTTPStatus(made.status_code).phrase}\r\n".encode()
    fields = b"".join(b"%s: %s\r\n" % field for field in made.raw_headers)
    return head + fields + b"\r\n" + bytes(made.body)


class Connection(asyncio.BufferedProtocol):
    """One client's connection; `protocol` is uvicorn's, and has the event loop as `loop`."""

    def __init__(self, protocol: Any, edge: Edge) -> None:
        self._protocol = protocol
        self._edge = edge
        self._read = bytearray()  # received but not parsed yet
        self._wanted = True  # the protocol has not paused reading
        self._reading = True  # the socket has not been paused
        self._queued = False
        self._written = 0  # bytes
        self._taken = -1  # bytes that the kernel had accepted at the last `_watch`

    # As asyncio's protocol.

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Pass it on, unless this client has too many connections."""
        self._transport = transport
        self.close, self.abort = transport.close, transport.abort
        self.is_closing = transport.is_closing
        self.get_write_buffer_size = transport.get_write_buffer_size
        self.set_write_buffer_limits = transport.set_write_buffer_limits
        self._past = Past(transport)
        edge = self._edge
        self._host = str((transport.get_extra_info("peername") or ("",))[0])
        self._client = one_client(self._host)
        self._watch()
        refused: AppError | None = edge.connections.refusal(self._host)
        self._counted = refused is None and edge.connections.enter(self._host)
        if refused is not None:
            edge.refused(response_for(refused).code)
            transport.write(refusal(refused))
            transport.close()
            return
        self._protocol.connection_made(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self._watching.cancel()
        self._read.clear()
        if self._counted:
            self._counted = False
            self._edge.connections.leave(self._host)
            self._protocol.connection_lost(exc)

    def get_buffer(self, sizehint: int) -> memoryview:
        return self._edge.intake.buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Parse the bytes at once if this turn of the event loop has time left."""
        self._read += self._edge.intake.buffer[:nbytes]
        self._queue()
        self._edge.intake.work()
        self._continue()

    def eof_received(self) -> None:
        """The client sends no more. Returning None closes the connection without an answer."""
        if self._counted:
            self._protocol.eof_received()

    def pause_writing(self) -> None:
        self._protocol.pause_writing()

    def resume_writing(self) -> None:
        self._protocol.resume_writing()

    # As a source of the intake.

    def parse(self) -> int:
        """Have the protocol parse the received bytes, at most to the end of the first head.

        A pipelined request therefore waits here, unparsed, for the answer to the one before.
        """
        self._queued = False
        if self._transport.is_closing() or not self._wanted:
            return 0
        end = self._read.find(_HEAD_END)
        piece = bytes(self._read if end < 0 else self._read[: end + len(_HEAD_END)])
        del self._read[: len(piece)]
        try:
            self._protocol.data_received(piece)
        except Exception:  # noqa: BLE001 - like an event loop: end one connection, not all
            _log.exception("connection failed")
            self._transport.abort()
        self._continue()
        return len(piece)

    def _continue(self) -> None:
        """Queue for parsing, or read on; do neither while the protocol has paused reading."""
        if self._transport.is_closing():
            return
        self._queue()
        reading = self._wanted and not self._read
        if reading != self._reading:
            self._reading = reading
            (self._transport.resume_reading if reading else self._transport.pause_reading)()

    def _queue(self) -> None:
        if self._read and self._wanted and not self._queued:
            self._queued = True
            self._edge.intake.put(self._client, self.parse)

    # As uvicorn's transport.

    def write(self, data: bytes) -> None:
        self._written += len(data)
        self._transport.write(data)

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        """As a transport's; `PAST` gives the writer that bypasses uvicorn for WebSocket frames."""
        return self._past if name == PAST else self._transport.get_extra_info(name, default)

    def pause_reading(self) -> None:
        self._wanted = False
        self._continue()

    def resume_reading(self) -> None:
        self._wanted = True
        self._continue()

    def set_protocol(self, protocol: Any) -> None:
        self._protocol = protocol

    # Clients that do not read.

    def _watch(self) -> None:
        """Cut off a client that has bytes waiting and has read none of them since the last call."""
        waiting = self._transport.get_write_buffer_size()
        taken = self._written + self._past.written - waiting
        if waiting and taken == self._taken:
            self._edge.refused("unread")
            self._transport.abort()
        self._taken = taken
        self._watching = self._protocol.loop.call_later(self._edge.unread_seconds, self._watch)


def connection(kind: type[Any], edge: Edge) -> Callable[..., Connection]:
    """A factory of connections for uvicorn, with `kind` as their first protocol."""
    return lambda **options: Connection(kind(**options), edge)
