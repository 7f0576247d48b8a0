"""The WebSockets that lead over this server to others, and how they are closed when it ends."""

import asyncio
import contextlib
from collections.abc import Iterator
from typing import Final

_APART: Final = 0.01
"""s between two that are closed: each comes back at once over another server, and of a hundred that
come together the last waits for all."""

_CLOSING: Final = 2.0  # s for all of them


class Passed:
    """For the event loop's thread."""

    def __init__(self) -> None:
        self._lines: set[asyncio.Event] = set()

    @contextlib.contextmanager
    def line(self) -> Iterator[asyncio.Event]:
        """There is one while the block lasts, which is to end once the event is set."""
        closing = asyncio.Event()
        self._lines.add(closing)
        try:
            yield closing
        finally:
            self._lines.discard(closing)

    async def close(self) -> None:
        """Have those who are there now come over another server."""
        lines = list(self._lines)
        for closing in lines:
            closing.set()
            await asyncio.sleep(min(_APART, _CLOSING / len(lines)))
