"""Pictures that were asked for: drawn once in a worker, shared by all who ask, kept a while."""

import asyncio
import functools
import hashlib
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path

from app.pictures.workers import Workers
from app.settings import static_directory


class Pictures:
    """Pictures by name, the longest unused making way when they take too many bytes.

    For the event loop's thread only; the drawing is done by the workers.
    """

    def __init__(self, workers: Workers, max_bytes: int) -> None:
        self.max_bytes = max_bytes
        self.size = 0  # bytes kept
        self.drawn = 0
        self._workers = workers
        self._kept: OrderedDict[str, bytes] = OrderedDict()
        self._jobs: dict[str, asyncio.Task[bytes]] = {}

    async def get(self, name: str, draw: Callable[[], bytes]) -> bytes:
        """The picture of this name, which says all that decides it; `draw()` makes it.

        Raises BusyError when too much work waits, and what `draw` raises.
        """
        if name in self._kept:
            self._kept.move_to_end(name)
            return self._kept[name]
        job = self._jobs.get(name)
        if job is None:
            job = asyncio.create_task(self._draw(name, draw))
            job.add_done_callback(_seen)
            self._jobs[name] = job
        # One who goes away must not take the picture from the others who wait for it.
        return await asyncio.shield(job)

    async def _draw(self, name: str, draw: Callable[[], bytes]) -> bytes:
        try:
            picture = await self._workers.run(draw)
        finally:
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
