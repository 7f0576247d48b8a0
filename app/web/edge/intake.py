"""Limits how many received bytes are parsed in one turn of the event loop, clients in turn.

Small messages cost the server most: a kibibyte holds 170 empty WebSocket frames, 170 chunks of one
byte or 50 short requests, and takes a millisecond or two to parse. asyncio would read 256 KiB of
each connection at a time, and every room would stand still meanwhile. So the server reads each
connection in small pieces and parses only a few pieces in a turn; other tasks run in between. The
remaining bytes stay in the kernel, whose full buffers slow the sender down.
"""

import asyncio
from collections import deque
from collections.abc import Callable
from typing import Final, Generic, TypeVar

T = TypeVar("T")

_PIECE: Final = 1024
"""Bytes that are read from a connection at a time."""

_TURN: Final = 2048
"""Bytes that are parsed in one turn of the event loop, for all connections together."""

_LEAST: Final = 512
"""A piece counts as at least this many bytes: even a short request or message takes half a
millisecond to handle."""


class FairQueue(Generic[T]):
    """Serves clients round robin: one with a hundred entries delays another by only one of them."""

    def __init__(self) -> None:
        self._clients: deque[str] = deque()
        self._waiting: dict[str, deque[T]] = {}

    def put(self, client: str, waiting: T) -> None:
        """Append an entry to this client's own queue."""
        if client not in self._waiting:
            self._waiting[client] = deque()
            self._clients.append(client)
        self._waiting[client].append(waiting)

    def take(self) -> T | None:
        """Remove and return the next entry, or None. Its client then queues behind all others."""
        if not self._clients:
            return None
        client = self._clients.popleft()
        waiting = self._waiting[client]
        taken = waiting.popleft()
        if waiting:
            self._clients.append(client)
        else:
            del self._waiting[client]
        return taken


Parse = Callable[[], int]
"""Parses a piece of a connection's bytes, and returns its length; puts itself back for the rest."""


class Intake:
    """Parses the received bytes of all connections, a limited number in each turn.

    `soon` calls a function in the next turn. All connections read into the one `buffer`; each
    copies its bytes out before the next one reads.
    """

    def __init__(self, soon: Callable[[Callable[[], None]], object] | None = None) -> None:
        self.buffer = memoryview(bytearray(_PIECE))
        self._soon = soon or (lambda next_: asyncio.get_running_loop().call_soon(next_))
        self._queue: FairQueue[Parse] = FairQueue()
        self._left = _TURN  # bytes left in this turn
        self._turning = False  # the next turn has been requested

    def put(self, client: str, parse: Parse) -> None:
        self._queue.put(client, parse)
        self._turn()

    def work(self) -> None:
        """Parse queued connections until this turn's bytes are used up."""
        while self._left > 0 and (parse := self._queue.take()) is not None:
            self._left -= max(parse(), _LEAST)
        if self._left < _TURN:
            self._turn()

    def _turn(self) -> None:
        if not self._turning:
            self._turning = True
            self._soon(self._next)

    def _next(self) -> None:
        self._turning, self._left = False, _TURN
        self.work()
