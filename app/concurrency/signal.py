"""Wakes all tasks that wait for the same thing, each time it happens."""

import asyncio


class Signal:
    """For the event loop's thread. Unlike an Event, it never stays set and needs no clearing."""

    def __init__(self) -> None:
        self._next = asyncio.Event()

    def send(self) -> None:
        """Wake all tasks that wait now."""
        sent, self._next = self._next, asyncio.Event()
        sent.set()

    async def wait(self) -> None:
        """Return when the signal is next sent."""
        await self._next.wait()
