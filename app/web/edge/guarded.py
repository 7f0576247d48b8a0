"""The one module that knows uvicorn's HTTP connection from inside: the limits that it lacks.

uvicorn's parser in C takes heads without end and waits for them for ever. `GuardedProtocol` counts
what comes and looks at a clock: a head has a size and a time, and a body has a time. `choose.py`
tries it out at start-up.
"""

import asyncio
from collections import deque
from typing import ClassVar

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle

from app.errors import AppError, HeadError, HeadTooLargeError, TooLateError, answer
from app.web.edge.connection import Edge, refusal

_MOST_FIELDS = 100  # headers of one request; browsers send some twenty


class GuardedProtocol(HttpToolsProtocol):
    """uvicorn's HTTP connection with limits; made by `guarded`."""

    edge: ClassVar[Edge]

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a head."""
        super().connection_made(transport)
        self._in_head, self._in_body = True, False
        self._head = 0  # bytes of it that were parsed
        self._raw = 0  # and that came, as far as no request began in their midst
        self._fields = 0
        self._refusal: AppError | None = None
        self._unanswered: deque[RequestResponseCycle] = deque()
        self._deadline: float | None = None
        self._late = ""
        self._timer: asyncio.TimerHandle | None = None
        self._expect(self.edge.head_seconds, "head")

    def connection_lost(self, exc: Exception | None) -> None:
        """Have no request write an answer any more: uvicorn tells only the last that came."""
        self._stop_watching()
        self._give_up()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take what came, and refuse a head that has become too large without an end."""
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
        """From here on it is a WebSocket, whose protocol has its own limits."""
        self._stop_watching()
        super().handle_websocket_upgrade()

    def send_400_response(self, msg: str) -> None:
        """Refuse what could not be parsed, in this server's own words."""
        self._refuse(self._refusal or HeadError("what was received is no HTTP request"))

    # What the parser tells.

    def on_message_begin(self) -> None:
        super().on_message_begin()
        self._in_head, self._head, self._raw, self._fields = True, 0, 0, 0
        if self._deadline is None:
            self._expect(self.edge.head_seconds, "head")

    def on_url(self, url: bytes) -> None:
        self._head += len(url)
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        """One whole header, with its colon and line end."""
        self._head += len(name) + len(value) + 4
        self._fields += 1
        super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """The head is whole. Raises its refusal, which the parser hands to `send_400_response`."""
        self._in_head = False
        self._refusal = self._why_not()
        if self._refusal is not None:
            raise self._refusal
        self._in_body = True
        self._expect(self.edge.body_seconds, "body")
        cycle = self.cycle
        super().on_headers_complete()
        if self.cycle is not cycle:  # else it is going to be a WebSocket
            self._unanswered.append(self.cycle)
            # After an upgrade to anything else, which is ignored, the parser reads nothing more.
            self.cycle.keep_alive &= not self.parser.should_upgrade()

    def on_message_complete(self) -> None:
        """The request is whole; for its answer the client may wait."""
        self._in_body = False
        self._deadline = None
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """The first of the requests that wait has its answer."""
        self._unanswered.popleft()
        super().on_response_complete()

    # Clocks.

    def _expect(self, seconds: float, what: str) -> None:
        """Have the head or the body arrive by then. One timer serves many requests."""
        self._deadline, self._late = self.loop.time() + seconds, what
        if self._timer is not None and self._timer.when() > self._deadline:
            self._timer.cancel()
            self._timer = None
        if self._timer is None:
            self._timer = self.loop.call_at(self._deadline, self._look)

    def _look(self) -> None:
        self._timer = None
        if self._deadline is None:
            return
        if self.loop.time() < self._deadline:
            self._timer = self.loop.call_at(self._deadline, self._look)
        elif self._late == "head" and self._unanswered:
            self._expect(self.edge.head_seconds, "head")
        elif self._late == "head" and not self._raw and not self._head:
            self.transport.close()  # who has said nothing is told nothing
        else:
            edge = self.edge
            seconds = edge.head_seconds if self._late == "head" else edge.body_seconds
            self._refuse(TooLateError(f"the {self._late} was not whole after {seconds:g} seconds"))

    def _stop_watching(self) -> None:
        self._deadline = None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    # Refusals.

    def _why_not(self) -> AppError | None:
        """Why the request whose head is whole is refused; None if it is not."""
        if self._head > self.edge.head_bytes or self._fields > _MOST_FIELDS:
            return self._too_large()
        if not self.parser.should_upgrade():
            return None
        headers = dict(self.headers)
        if b"transfer-encoding" in headers or headers.get(b"content-length", b"").strip(b"0"):
            return HeadError("a request to upgrade has no body")  # the parser would not read it
        if self._unanswered:
            return HeadError("a request to upgrade waits for the answers to earlier ones")
        return None

    def _too_large(self) -> HeadTooLargeError:
        return HeadTooLargeError(
            f"a head of more than {self.edge.head_bytes} bytes or {_MOST_FIELDS} headers"
        )

    def _refuse(self, error: AppError) -> None:
        """Say why, and close; close only, where the client would take it for another's answer."""
        if self.transport.is_closing():
            return
        self.edge.refused(answer(error).code)
        own = self.cycle if self._in_body else None
        earlier = [cycle for cycle in self._unanswered if cycle is not own]
        if not earlier and not (own and own.response_started):
            self.transport.write(refusal(error))
        self._give_up()  # an answer that comes now would follow the refusal
        self._deadline = None
        self.transport.close()

    def _give_up(self) -> None:
        """Let the requests that wait know that their client is gone."""
        for cycle in self._unanswered:
            cycle.disconnected = True
            cycle.message_event.set()
        self._unanswered.clear()


def guarded(edge: Edge) -> type[GuardedProtocol]:
    """The kind of connection that `uvicorn.Config(http=…)` takes, with these limits."""
    return type("GuardedProtocol", (GuardedProtocol,), {"edge": edge})
