"""Threads that compute long ticks of rooms, so that the event loop can serve other rooms.

Kernels run without the interpreter's lock, so a step on a thread costs the event loop little more
than copying the world.
"""

import asyncio
import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Final

_MOST: Final = 2  # threads; other processes need the machine too


class StepThreads:
    """Computes one tick at a time for each room, in the order of the requests.

    A room asks for its next tick when it has the previous one, so all rooms get equally many.
    `submit` and `forget` are for the event loop's thread.
    """

    def __init__(self, threads: int | None = None) -> None:
        """By default one thread fewer than cores, but at least one and at most `_MOST`."""
        count = min(_MOST, max(1, (os.cpu_count() or 1) - 1)) if threads is None else threads
        self._threads = ThreadPoolExecutor(count, "step")
        self._asked: dict[str, Future[None]] = {}
        self._closed = False

    def submit(self, room_id: str, compute: Callable[[], None], done: Callable[[], None]) -> None:
        """Call `compute()` on a thread and then `done()` on the event loop.

        This replaces the room's previous request, whose result an input has made obsolete.
        `compute` must not raise.
        """
        if self._closed:  # the last commits at the server's stop may still admit a ball
            return
        self.forget(room_id)
        loop = asyncio.get_running_loop()

        def computed(asked: Future[None]) -> None:
            if not asked.cancelled():
                loop.call_soon_threadsafe(done)

        self._asked[room_id] = self._threads.submit(compute)
        self._asked[room_id].add_done_callback(computed)

    def forget(self, room_id: str) -> None:
        asked = self._asked.pop(room_id, None)
        if asked is not None:
            asked.cancel()

    def close(self) -> None:
        """Cancel the waiting requests, and wait for the running ones, a tick each."""
        self._closed = True
        self._threads.shutdown(cancel_futures=True)
