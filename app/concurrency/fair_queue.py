"""A queue that serves clients round robin, so that no client delays the others for long."""

import asyncio
import contextlib
from collections import deque
from collections.abc import AsyncIterator
from typing import Generic, TypeVar

T = TypeVar("T")


class FairQueue(Generic[T]):
    """A client with a hundred entries delays every other client by only one of them. Pure."""

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


class FairLock:
    """A lock that waiting clients get round robin. For the event loop's thread."""

    def __init__(self) -> None:
        self._held = False
        self._queue: FairQueue[asyncio.Future[None]] = FairQueue()

    @contextlib.asynccontextmanager
    async def turn(self, client: str) -> AsyncIterator[None]:
        """Acquire the lock on behalf of this client, and release it when the block ends."""
        if self._held:
            waiting: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._queue.put(client, waiting)
            try:
                await waiting
            except asyncio.CancelledError:
                if not waiting.cancelled():  # it got the lock just before it was cancelled
                    self._pass_on()
                raise
        self._held = True
        try:
            yield
        finally:
            self._pass_on()

    def _pass_on(self) -> None:
        """Give the lock to the next task that still waits, or free it."""
        while (waiting := self._queue.take()) is not None:
            if not waiting.done():
                waiting.set_result(None)
                return
        self._held = False
