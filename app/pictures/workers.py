"""Frames of live rooms off the event loop: threads, a bounded queue before them, 503 beyond it."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from app.errors import BusyError

T = TypeVar("T")


class Workers:
    """A thread pool that refuses work instead of letting it pile up."""

    def __init__(self, threads: int, max_jobs: int) -> None:
        self.max_jobs = max_jobs
        self.threads = threads
        self.jobs = 0  # running or waiting
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="worker")

    @property
    def full(self) -> bool:
        """Whether more work would be refused."""
        return self.jobs >= self.max_jobs + self.threads

    async def run(self, work: Callable[[], T]) -> T:
        """Result of `work()`, done in a thread; raises BusyError when too much waits."""
        if self.full:
            raise BusyError(f"{self.max_jobs} jobs wait already")
        self.jobs += 1
        future = asyncio.get_running_loop().run_in_executor(self._pool, work)
        # Counted down when the work ends, not when its client goes away: a cancelled wait leaves
        # the thread busy.
        future.add_done_callback(self._done)
        return await asyncio.shield(future)

    def _done(self, future: "asyncio.Future[T]") -> None:
        self.jobs -= 1
        if not future.cancelled():
            future.exception()  # seen, so that a client gone early leaves no warning behind

    def close(self) -> None:
        """Drop what waits and let what runs end by itself."""
        self._pool.shutdown(wait=False, cancel_futures=True)
