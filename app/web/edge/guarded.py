"""Limits on HTTP heads and bodies, which uvicorn lacks. Only this module uses its HTTP internals.

uvicorn's parser in C accepts heads of any size and waits for them without end. `GuardedProtocol`
limits the size of a head and the time in which a head and a body must arrive.
"""

import asyncio
from collections import deque
from typing import ClassVar

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle

from plinko.app.errors import AppError, HeadError, HeadTooLargeError, TooLateError, response_for
from plinko.app.web.edge.connection import Edge, refusal

_MOST_FIELDS = 100  # headers of one request; browsers send some twenty


class GuardedProtocol(HttpToolsProtocol):
    """uvicorn's HTTP protocol with limits; `guarded` makes subclasses with an `edge`."""

    edge: ClassVar[Edge]

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._in_head, self._in_body = True, False
        self._head = 0  # bytes of the head that were parsed
        self._raw = 0  # bytes received for this head, in pieces that hold nothing else
        self._fields = 0
        self._refusal: AppError | None = None
        self._unanswered: deque[RequestResponseCycle] = deque()
        self._deadline: float | None = None
        self._late = ""
        self._timer: asyncio.TimerHandle | None = None
        self._expect(self.edge.head_seconds, "head")

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop all unanswered requests; uvicorn itself stops only the last one."""
        self._stop_watching()
        self._disconnect_all()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse the bytes, and refuse a head that is too large before it is complete."""
        if self.transport.is_closing():
            return
        if self._deadline is None and not self._in_body:
            self._expect(self.edge.head_seconds, "head")
        began_before = self._in_head
        super().data_received(data)
        if began_before and self._in_head:
            self._raw += len(data)
            if max(self._raw, self._head) > self.edge.head_bytes:
                self._refuse(self._too_large())

    def handle_websocket_upgrade(self) -> None:
        """Stop the timer: the WebSocket's protocol has its own limits."""
        self._stop_watching()
        super().handle_websocket_upgrade()

    def send_400_response(self, msg: str) -> None:
        """Refuse a request that could not be parsed, with a problem document."""
        self._refuse(self._refusal or HeadError("the received bytes are not an HTTP request"))

    # Called by the parser.

    def on_message_begin(self) -> None:
        super().on_message_begin()
        self._in_head, self._head, self._raw, self._fields = True, 0, 0, 0
        if self._deadline is None:
            self._expect(self.edge.head_seconds, "head")

    def on_url(self, url: bytes) -> None:
        self._head += len(url)
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        self._head += len(name) + len(value) + 4  # colon, space, line end
        self._fields += 1
        super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """The head is complete. If it is refused, raise: uvicorn then calls `send_400_response`."""
        self._in_head = False
        self._refusal = self._fault()
        if self._refusal is not None:
            raise self._refusal
        self._in_body = True
        self._expect(self.edge.body_seconds, "body")
        cycle = self.cycle
        super().on_headers_complete()
        if self.cycle is not cycle:  # an upgrade to a WebSocket makes no cycle
            self._unanswered.append(self.cycle)
            # uvicorn ignores an upgrade to anything else, but the parser stops there for good:
            # close the connection after the answer.
            self.cycle.keep_alive &= not self.parser.should_upgrade()

    def on_message_complete(self) -> None:
        """The request is complete; the answer has no deadline here."""
        self._in_body = False
        self._deadline = None
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """The oldest unanswered request has its answer."""
        self._unanswered.popleft()
        super().on_response_complete()

    # Deadlines.

    def _expect(self, seconds: float, what: str) -> None:
        """Set the deadline of a head or a body. One timer serves many requests."""
        self._deadline, self._late = self.loop.time() + seconds, what
        if self._timer is not None and self._timer.when() > self._deadline:
            self._timer.cancel()
            self._timer = None
        if self._timer is None:
            self._timer = self.loop.call_at(self._deadline, self._check_deadline)

    def _check_deadline(self) -> None:
        self._timer = None
        if self._deadline is None:
            return
        if self.loop.time() < self._deadline:
            self._timer = self.loop.call_at(self._deadline, self._check_deadline)
        elif self._late == "head" and self._unanswered:
            self._expect(self.edge.head_seconds, "head")
        elif self._late == "head" and not self._raw and not self._head:
            self.transport.close()  # the client sent nothing, so it gets no answer
        else:
            edge = self.edge
            seconds = edge.head_seconds if self._late == "head" else edge.body_seconds
            self._refuse(
                TooLateError(f"the {self._late} was not complete after {seconds:g} seconds")
            )

    def _stop_watching(self) -> None:
        self._deadline = None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    # Refusals.

    def _fault(self) -> AppError | None:
        """Why to refuse the request whose head is complete; None to accept it."""
        if self._head > self.edge.head_bytes or self._fields > _MOST_FIELDS:
            return self._too_large()
        if not self.parser.should_upgrade():
            return None
        headers = dict(self.headers)
        if b"transfer-encoding" in headers or headers.get(b"content-length", b"").strip(b"0"):
            # The parser would not read the body.
            return HeadError("a request to upgrade must have no body")
        if self._unanswered:
            return HeadError("a request to upgrade must wait for the answers to earlier requests")
        return None

    def _too_large(self) -> HeadTooLargeError:
        return HeadTooLargeError(
            f"the head has more than {self.edge.head_bytes} bytes or {_MOST_FIELDS} headers"
        )

    def _refuse(self, error: AppError) -> None:
        """Answer with the error, and close.

        Only close if an earlier request has no answer yet, or this one's answer has begun: the
        client would take the error for that answer, or for part of it.
        """
        if self.transport.is_closing():
            return
        self.edge.refused(response_for(error).code)
        own = self.cycle if self._in_body else None
        earlier = [cycle for cycle in self._unanswered if cycle is not own]
        if not earlier and not (own and own.response_started):
            self.transport.write(refusal(error))
        self._disconnect_all()  # so that no answer follows the refusal
        self._deadline = None
        self.transport.close()

    def _disconnect_all(self) -> None:
        """Tell the unanswered requests that their client has disconnected."""
        for cycle in self._unanswered:
            cycle.disconnected = True
            cycle.message_event.set()
        self._unanswered.clear()


def guarded(edge: Edge) -> type[GuardedProtocol]:
    """The class for `uvicorn.Config(http=…)`, with these limits."""
    return type("GuardedProtocol", (GuardedProtocol,), {"edge": edge})
