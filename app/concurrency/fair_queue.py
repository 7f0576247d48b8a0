"""Whose turn it is where many clients wait: the first of each client, clients in turn."""

import asyncio
import contextlib
from collections import deque
from collections.abc import AsyncIterator
from typing import Generic, TypeVar

T = TypeVar("T")


class FairQueue(Generic[T]):
    """A client that waits a hundred times delays each of the others by one of these. Pure."""

    def __init__(self) -> None:
        self._clients: deque[str] = deque()
        self._waiting: dict[str, deque[T]] = {}

    def put(self, client: str, waiting: T) -> None:
        """Let one more of this client wait."""
        if client not in self._waiting:
            self._waiting[client] = deque()
            self._clients.append(client)
        self._waiting[client].append(waiting)

    def take(self) -> T | None:
        """The one whose turn it is, or None; its client's next one comes after all others'."""
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


class FairLock:
    """One turn at a time, clients in turn; for the event loop's thread."""

    def __init__(self) -> None:
        self._held = False
        self._queue: FairQueue[asyncio.Future[None]] = FairQueue()

    @contextlib.asynccontextmanager
    async def turn(self, client: str) -> AsyncIterator[None]:
        """Wait for a turn of this client, and have it until the block ends."""
        if self._held:
            waiting: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._queue.put(client, waiting)
            try:
                await waiting
            except asyncio.CancelledError:
                if not waiting.cancelled():  # the turn had come
                    self._pass_on()
                raise
        self._held = True
        try:
            yield
        finally:
            self._pass_on()

    def _pass_on(self) -> None:
        """Give the turn to the next one that still waits."""
        while (waiting := self._queue.take()) is not None:
            if not waiting.done():
                waiting.set_result(None)
                return
        self._held = False
