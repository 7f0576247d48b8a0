"""How much of what clients send is parsed in one turn of the event loop, and whose.

Cheap bytes cost the server most: 170 empty WebSocket frames, 170 chunks of one byte or 50 short
requests fit into a kibibyte, and take a millisecond or two to parse. The event loop would read
256 KiB of each connection at a time, and every room would stand still meanwhile. So a connection is
read in pieces, some pieces are parsed in a turn, clients in turn, and what else is due comes in
between. What must wait stays in the kernel, whose buffers slow down whoever fills them.
"""

import asyncio
from collections.abc import Callable
from typing import Final, Protocol

from app.concurrency.fair_queue import FairQueue

_PIECE: Final = 1024
"""Bytes that are read of a connection at a time."""

_TURN: Final = 2048
"""Bytes that are parsed in one turn of the event loop, of all connections together."""

_LEAST: Final = 512
"""Bytes that a piece counts as at least: a short request or message takes half a millisecond to
carry out, however short it is."""


class Source(Protocol):
    """A connection of which something was read."""

    def parse(self) -> int:
        """Parse a piece, and return its bytes; put the connection back if that was not all."""


class Intake:
    """Parses what was read, so much in a turn of the event loop.

    `soon` calls a function in the next turn. Into `buffer` all connections read: one after the
    other, and each takes what it has read at once.
    """

    def __init__(self, soon: Callable[[Callable[[], None]], object] | None = None) -> None:
        self.buffer = memoryview(bytearray(_PIECE))
        self._soon = soon or (lambda next_: asyncio.get_running_loop().call_soon(next_))
        self._queue: FairQueue[Source] = FairQueue()
        self._left = _TURN  # bytes, in this turn
        self._turning = False  # the next turn is asked for

    def put(self, client: str, source: Source) -> None:
        """Let a connection wait for its turn."""
        self._queue.put(client, source)
        self._turn()

    def work(self) -> None:
        """Parse what waits, as far as this turn goes."""
        while self._left > 0 and (source := self._queue.take()) is not None:
            self._left -= max(source.parse(), _LEAST)
        if self._left < _TURN:
            self._turn()

    def _turn(self) -> None:
        if not self._turning:
            self._turning = True
            self._soon(self._next)

    def _next(self) -> None:
        self._turning, self._left = False, _TURN
        self.work()
