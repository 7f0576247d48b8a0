"""The one module that knows uvicorn's HTTP connection from inside: the limits that it lacks.

uvicorn's parser in C takes heads without end and waits for them for ever. `GuardedProtocol` counts
what comes and looks at a clock: a head has a size and a time, a body has a time, an answer must be
read, and a client has so many connections. `choose.py` tries it out at start-up.
"""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from http import HTTPStatus
from typing import ClassVar

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from app.errors import (
    AppError,
    HeadError,
    HeadTooLargeError,
    TooLateError,
    answer,
)
from app.web.edge.addresses import Connections
from app.web.problems import problem_response

_MOST_FIELDS = 100  # headers of one request; browsers send some twenty


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """What one connection may take, and those that are open.

    `head_bytes` of a request's line and headers; seconds for a head, for a body after it, and
    without reading anything of an answer. `refused` hears the code of each refusal.
    """

    head_bytes: int
    head_seconds: float
    body_seconds: float
    unread_seconds: float
    connections: Connections
    refused: Callable[[str], None] = lambda code: None


class GuardedProtocol(HttpToolsProtocol):
    """uvicorn's HTTP connection with limits; made by `guarded`."""

    edge: ClassVar[Edge]

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a head, unless this client has connections enough."""
        super().connection_made(transport)
        self._in_head, self._in_body = True, False
        self._head = 0  # bytes of it that were parsed
        self._raw = 0  # and that came, as far as no request began in their midst
        self._fields = 0
        self._refusal: AppError | None = None
        self._deadline: float | None = None
        self._late = ""
        self._timer: asyncio.TimerHandle | None = None
        self._unread = 0
        self._drained = False
        self._host = self.client[0] if self.client else ""
        refusal = self.edge.connections.refusal(self._host)
        self._counted = refusal is None and self.edge.connections.enter(self._host)
        self._reader = self.loop.call_later(self.edge.unread_seconds, self._watch_reader)
        if refusal is None:
            self._expect(self.edge.head_seconds, "head")
        else:
            self._refuse(refusal)

    def connection_lost(self, exc: Exception | None) -> None:
        """Count it no more."""
        self._stop_watching()
        if self._counted:
            self._counted = False
            self.edge.connections.leave(self._host)
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
        """From here on it is a WebSocket, whose protocol counts it and has its own limits."""
        self._stop_watching()
        super().handle_websocket_upgrade()

    def resume_writing(self) -> None:
        """The client has read nearly all there was."""
        self._drained = True
        super().resume_writing()

    def send_400_response(self, msg: str) -> None:
        """Refuse what could not be parsed, in this server's own words."""
        self._refuse(self._refusal or HeadError("what was received is no HTTP request"))

    # What the parser tells.

    def on_message_begin(self) -> None:
        """A request begins."""
        super().on_message_begin()
        self._in_head, self._head, self._raw, self._fields = True, 0, 0, 0
        if self._deadline is None:
            self._expect(self.edge.head_seconds, "head")

    def on_url(self, url: bytes) -> None:
        """Some of its line."""
        self._head += len(url)
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        """One whole header, with its colon and line end."""
        self._head += len(name) + len(value) + 4
        self._fields += 1
        super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """The head is whole. Raises its refusal, which the parser hands to `send_400_response`."""
        self._in_head, self._in_body = False, True
        if self._head > self.edge.head_bytes or self._fields > _MOST_FIELDS:
            self._refusal = self._too_large()
            raise self._refusal
        self._expect(self.edge.body_seconds, "body")
        super().on_headers_complete()

    def on_message_complete(self) -> None:
        """The request is whole; for its answer the client may wait."""
        self._in_body = False
        self._deadline = None
        super().on_message_complete()

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
        elif self._late == "head" and self._answering:
            self._expect(self.edge.head_seconds, "head")
        elif self._late == "head" and not self._raw and not self._head:
            self.transport.close()  # who has said nothing is told nothing
        else:
            edge = self.edge
            seconds = edge.head_seconds if self._late == "head" else edge.body_seconds
            self._refuse(TooLateError(f"the {self._late} was not whole after {seconds:g} seconds"))

    @property
    def _answering(self) -> bool:
        """Whether an earlier request on this connection still has no whole answer."""
        return not getattr(self.cycle, "response_complete", True)

    def _watch_reader(self) -> None:
        """Cut off a client that has read nothing of what waits for it since the last look."""
        waiting = self.transport.get_write_buffer_size()
        if waiting and waiting >= self._unread > 0 and not self._drained:
            self.edge.refused("unread")
            self.transport.abort()
            return
        self._unread, self._drained = waiting, False
        self._reader = self.loop.call_later(self.edge.unread_seconds, self._watch_reader)

    def _stop_watching(self) -> None:
        self._deadline = None
        self._reader.cancel()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    # Refusals.

    def _too_large(self) -> HeadTooLargeError:
        return HeadTooLargeError(
            f"a head of more than {self.edge.head_bytes} bytes or {_MOST_FIELDS} headers"
        )

    def _refuse(self, error: AppError) -> None:
        """Say why, unless an answer has begun, and close."""
        if self.transport.is_closing():
            return
        self.edge.refused(answer(error).code)
        if not (self._answering and self.cycle.response_started):
            self.transport.write(_response(error))
        if self.cycle is not None:
            self.cycle.disconnected = True  # an answer that comes now would follow the refusal
        self._deadline = None
        self.transport.close()


def _response(error: AppError) -> bytes:
    """An error as a whole HTTP response that ends its connection."""
    made = problem_response(error)
    made.headers["connection"] = "close"
    head = f"HTTP/1.1 {made.status_code} {HTTPStatus(made.status_code).phrase}\r\n".encode()
    fields = b"".join(b"%s: %s\r\n" % field for field in made.raw_headers)
    return head + fields + b"\r\n" + bytes(made.body)


def guarded(edge: Edge) -> type[GuardedProtocol]:
    """The kind of connection that `uvicorn.Config(http=…)` takes, with these limits."""
    return type("GuardedProtocol", (GuardedProtocol,), {"edge": edge})
