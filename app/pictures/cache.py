"""Pictures that were asked for: drawn once, shared by all who ask, kept a while."""

import asyncio
import functools
import hashlib
from collections import OrderedDict
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.settings import static_directory


@dataclass(slots=True)
class _Job:
    """A picture in the making, and how many wait for it."""

    making: "asyncio.Task[bytes]"
    waiting: int = 0


class Pictures:
    """Pictures by name, the longest unused making way when they take too many bytes.

    For the event loop's thread only; the drawing is done elsewhere.
    """

    def __init__(self, max_bytes: int) -> None:
        self.max_bytes = max_bytes
        self.size = 0  # bytes kept
        self.drawn = 0
        self._kept: OrderedDict[str, bytes] = OrderedDict()
        self._jobs: dict[str, _Job] = {}

    async def get(self, name: str, make: Callable[[], Coroutine[Any, Any, bytes]]) -> bytes:
        """The picture of this name, which says all that decides it; `make()` has it drawn.

        Raises what `make` raises. It is cancelled when all are gone who wait for it.
        """
        if name in self._kept:
            self._kept.move_to_end(name)
            return self._kept[name]
        job = self._jobs.get(name)
        if job is None:
            job = _Job(asyncio.create_task(self._draw(name, make)))
            job.making.add_done_callback(_seen)
            self._jobs[name] = job
        job.waiting += 1
        try:
            # One who goes away must not take the picture from the others who wait for it.
            return await asyncio.shield(job.making)
        finally:
            job.waiting -= 1
            if not job.waiting and not job.making.done():
                job.making.cancel()
                if self._jobs.get(name) is job:
                    del self._jobs[name]  # who asks from now on begins anew

    async def _draw(self, name: str, make: Callable[[], Coroutine[Any, Any, bytes]]) -> bytes:
        try:
            picture = await make()
        finally:
            job = self._jobs.get(name)
            if job is not None and job.making is asyncio.current_task():
                del self._jobs[name]
        self.drawn += 1
        self._keep(name, picture)
        return picture

    def _keep(self, name: str, picture: bytes) -> None:
        if len(picture) > self.max_bytes:
            return
        self._kept[name] = picture
        self.size += len(picture)
        while self.size > self.max_bytes:
            self.size -= len(self._kept.popitem(last=False)[1])


def _seen(job: "asyncio.Task[bytes]") -> None:
    """Look at a failure, so that one whose askers are all gone leaves no warning behind."""
    if not job.cancelled():
        job.exception()


@functools.cache
def look() -> str:
    """Eight hex digits that change whenever pictures may look otherwise: part of their ETags."""
    sources = sorted((Path(__file__).parents[1] / "render").rglob("*.py"))
    stamp = hashlib.sha256((static_directory() / "theme.json").read_bytes())
    for path in sources:
        stamp.update(path.read_bytes())
    return stamp.hexdigest()[:8]
