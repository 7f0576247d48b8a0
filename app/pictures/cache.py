"""A cache of pictures: concurrent requests for one picture share a single drawing."""

import functools
import hashlib
from collections import OrderedDict
from collections.abc import Callable, Coroutine
from pathlib import Path

from plinko.app.concurrency.single_flight import SingleFlight
from plinko.app.settings import static_directory

PICTURE_BYTES = 1 << 25  # size of the cache


class Pictures:
    """Pictures by name, in an LRU cache bounded in bytes. For the event loop's thread only."""

    def __init__(self, max_bytes: int) -> None:
        self.max_bytes = max_bytes
        self.size = 0  # bytes cached
        self.drawn = 0
        self._kept: OrderedDict[str, bytes] = OrderedDict()
        self._drawing = SingleFlight[bytes](abandons=True)

    async def get(self, name: str, make: Callable[[], Coroutine[None, None, bytes]]) -> bytes:
        """The picture called `name`, from the cache or by `make()`.

        The name must determine the picture completely. Raises what `make` raises; `make` is
        cancelled when all callers that wait for it are.
        """
        if name in self._kept:
            self._kept.move_to_end(name)
            return self._kept[name]
        return await self._drawing.do(name, lambda: self._draw(name, make))

    async def _draw(self, name: str, make: Callable[[], Coroutine[None, None, bytes]]) -> bytes:
        picture = await make()
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


@functools.cache
def drawing_version() -> str:
    """A fingerprint of the drawing code and colours, in eight hex digits: part of ETags."""
    sources = sorted((Path(__file__).parents[1] / "render").rglob("*.py"))
    stamp = hashlib.sha256((static_directory() / "theme.json").read_bytes())
    for path in sources:
        stamp.update(path.read_bytes())
    return stamp.hexdigest()[:8]
