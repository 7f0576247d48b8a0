"""Wakes all who wait for the same thing, as often as it happens."""

import asyncio


class Bell:
    """For the event loop's thread."""

    def __init__(self) -> None:
        self._next = asyncio.Event()

    def ring(self) -> None:
        """Wake all who wait now."""
        rung, self._next = self._next, asyncio.Event()
        rung.set()

    async def wait(self) -> None:
        """Return when it is rung next."""
        await self._next.wait()
