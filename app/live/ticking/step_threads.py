"""The threads that compute the next ticks of dear rooms, while the event loop serves everybody.

Kernels run without the interpreter, so that a step on a thread takes the event loop next to nothing
but the copying around it.
"""

import asyncio
import itertools
import os
import queue
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Final, NamedTuple

from app.ops import cores

_MOST: Final = 2  # threads; the machine is there for others, too


class _Job(NamedTuple):
    """In the order of their turns: by start-time fair queuing, then as they came."""

    start: float  # s of computing that the room had, as a fair share has it
    number: int
    room_id: str
    compute: Callable[[], None]
    done: Callable[[], None]
    loop: asyncio.AbstractEventLoop


class StepThreads:
    """A few threads, and the rooms that wait for one: who has had least time comes first.

    `submit` and `forget` are for the event loop's thread.
    """

    def __init__(self, threads: int | None = None) -> None:
        """`threads`: by default one for each core but the event loop's, and few."""
        count = min(_MOST, max(1, (os.cpu_count() or 1) - 1)) if threads is None else threads
        self._threads = ThreadPoolExecutor(count, "step", cores.leave_one)
        self._waiting: queue.PriorityQueue[_Job] = queue.PriorityQueue()
        self._numbers = itertools.count()
        self._had: dict[str, float] = {}
        self._begun = 0.0  # the start of the job that was begun last
        self._closed = False

    def submit(self, room_id: str, compute: Callable[[], None], done: Callable[[], None]) -> None:
        """Have `compute()` done for a room, then `done()` on the event loop; nothing once closed.

        `compute` raises nothing.
        """
        if self._closed:  # what is still written down at the end may admit a ball to a room
            return
        start = max(self._had.get(room_id, 0.0), self._begun)
        loop = asyncio.get_running_loop()
        self._waiting.put(_Job(start, next(self._numbers), room_id, compute, done, loop))
        self._threads.submit(self._do_next)

    def forget(self, room_id: str) -> None:
        """A room rests."""
        self._had.pop(room_id, None)

    def close(self) -> None:
        """Drop what waits, and wait for what is computed: a tick of a room, at most."""
        self._closed = True
        self._threads.shutdown(cancel_futures=True)

    def _do_next(self) -> None:
        job = self._waiting.get_nowait()
        self._begun = max(self._begun, job.start)
        began = time.thread_time()
        job.compute()
        self._had[job.room_id] = job.start + time.thread_time() - began
        job.loop.call_soon_threadsafe(job.done)
