"""Limits on a WebSocket's frames and handshake, before its messages reach the application.

The websockets library answers every ping, stores every fragment and reads as long as a client
sends; and uvicorn does not answer a handshake that the library cannot parse. `GuardedSocket` limits
frames of every kind, sends no pongs to a client that does not read, and answers every handshake
within a time limit.
"""

import asyncio
from typing import Any, ClassVar

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import HeaderLineTooLong, RequestLineTooLong
from websockets.frames import Frame, Opcode

from plinko.app.errors import (
    BusyError,
    HeadError,
    HeadTooLargeError,
    MessageFloodError,
    response_for,
)
from plinko.app.web.edge.connection import Edge, refusal
from plinko.app.web.limits import TokenBucket

_MOST_FRAGMENTS = 64  # of one message; browsers send messages of this size in one frame

_LINGER = 1.0
"""Seconds between the close frame and the end of the connection, in which the client can read the
reason. If the connection ended at once while the client is sending, the client's system would
discard the close frame."""

_PONG = bytes([0x80 | Opcode.PONG])  # the first byte of a pong frame


class GuardedSocket(WebSocketsSansIOProtocol):
    """uvicorn's WebSocket protocol with limits; `guarded_socket` makes subclasses of it."""

    edge: ClassVar[Edge]

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Start the time limit of the handshake; its head has arrived already."""
        super().connection_made(transport)
        rate = self.edge.frame_rate
        self._frames = TokenBucket(rate, 2 * rate + _MOST_FRAGMENTS, self.loop.time())
        self._handshake = self.loop.call_later(self.edge.body_seconds, self._check_handshake)

    def connection_lost(self, exc: Exception | None) -> None:
        self._handshake.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse the bytes, and answer a handshake that the library could not parse."""
        super().data_received(data)
        unread = self.conn.handshake_exc
        if unread is None or self.handshake_complete:
            return
        if isinstance(unread, HeaderLineTooLong | RequestLineTooLong):
            self._refuse(HeadTooLargeError(f"a line of the handshake is too long: {unread}"))
        else:
            self._refuse(HeadError(f"not a WebSocket handshake: {unread.__cause__ or unread}"))

    def handle_events(self) -> None:
        """Handle the received frames, unless there are too many."""
        count = len(self.conn.events)
        if self._frames.left(self.loop.time()) < count:
            self._end(
                MessageFloodError(f"more than {self._frames.rate:g} frames a second; send fewer")
            )
            return
        self._frames.charge(count)
        super().handle_events()

    def handle_cont(self, event: Frame) -> None:
        """Store a fragment, unless there are too many."""
        if len(self.frames) < _MOST_FRAGMENTS:
            super().handle_cont(event)
        elif not self.close_sent:
            self._end(MessageFloodError(f"a message has more than {_MOST_FRAGMENTS} fragments"))

    def handle_ping(self) -> None:
        """Send the pong only if the client reads; not every ping needs one (RFC 6455, 5.5.3)."""
        output = self.conn.data_to_send()
        if not self.writable.is_set():
            output = [each for each in output if not each.startswith(_PONG)]
        self.transport.write(b"".join(output))

    def handle_parser_exception(self) -> None:
        """Close with the library's code and reason; the library discards all further bytes."""
        if not self.close_sent and (said := self.conn.close_sent) is not None:
            self._close_later(said.code, said.reason)

    def send_500_response(self) -> None:
        """Answer a handshake on which the application failed, with a problem document."""
        if not (self.initial_response or self.handshake_complete):
            self._refuse(RuntimeError())

    def shutdown(self) -> None:
        """Close because the server stops, unless the connection is closing already."""
        if self.transport.is_closing():
            return
        if self.handshake_complete:
            super().shutdown()
        else:
            self._refuse(BusyError("the server is stopping"))

    def _check_handshake(self) -> None:
        if not self.handshake_complete and not self.transport.is_closing():
            late = f"no answer to the handshake in {self.edge.body_seconds:g} seconds"
            self._refuse(BusyError(late))

    def _refuse(self, error: Exception) -> None:
        """Answer the handshake with an error, and close."""
        self.edge.refused(response_for(error).code)
        self.handshake_complete = self.close_sent = True
        self.transport.write(refusal(error))
        self.transport.close()

    def _end(self, error: MessageFloodError) -> None:
        """Send a close frame with the error, and read nothing more."""
        self.edge.refused(response_for(error).code)
        code, reason = response_for(error).close, str(error)
        self.conn.fail(code, reason)
        self._close_later(code, reason)
        self.read_paused = False
        self.transport.pause_reading()

    def _close_later(self, code: int, reason: str) -> None:
        """Send the library's pending close frame, and abort the connection after `_LINGER`."""
        self.queue.put_nowait({"type": "websocket.disconnect", "code": code, "reason": reason})
        self.transport.write(b"".join(self.conn.data_to_send()))
        self.close_sent = True
        self.close_timer = self.loop.call_later(_LINGER, self.transport.abort)


def guarded_socket(base: type[WebSocketsSansIOProtocol], edge: Edge) -> type[Any]:
    """The class for `uvicorn.Config(ws=…)`: `base` with these limits."""
    return type("GuardedSocket", (GuardedSocket, base), {"edge": edge})
