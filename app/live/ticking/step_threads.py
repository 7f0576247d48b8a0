"""The threads that compute long ticks of rooms while the event loop serves everybody.

Kernels run without the interpreter, so a step on a thread costs the event loop little more than the
copying around it.
"""

import asyncio
import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Final

_MOST: Final = 2  # threads; the machine is there for others, too


class StepThreads:
    """A few threads that compute one tick at a time for each room, in the order of asking.

    A room asks for its next tick once the one before is there, so all rooms get equally many.
    `submit` and `forget` are for the event loop's thread.
    """

    def __init__(self, threads: int | None = None) -> None:
        """`threads`: by default one for each core but the event loop's, and few."""
        count = min(_MOST, max(1, (os.cpu_count() or 1) - 1)) if threads is None else threads
        self._threads = ThreadPoolExecutor(count, "step")
        self._asked: dict[str, Future[None]] = {}
        self._closed = False

    def submit(self, room_id: str, compute: Callable[[], None], done: Callable[[], None]) -> None:
        """Have `compute()` done for a room, then `done()` on the event loop; nothing once closed.

        Takes the place of what the room asked for before: an input made that worthless. `compute`
        raises nothing.
        """
        if self._closed:  # what is still written down at the end may admit a ball to a room
            return
        self.forget(room_id)
        loop = asyncio.get_running_loop()

        def computed(asked: Future[None]) -> None:
            if not asked.cancelled():
                loop.call_soon_threadsafe(done)

        self._asked[room_id] = self._threads.submit(compute)
        self._asked[room_id].add_done_callback(computed)

    def forget(self, room_id: str) -> None:
        """A room needs nothing any more that it asked for."""
        asked = self._asked.pop(room_id, None)
        if asked is not None:
            asked.cancel()

    def close(self) -> None:
        """Drop what waits, and wait for what is computed: a tick of a room, at most."""
        self._closed = True
        self._threads.shutdown(cancel_futures=True)
