"""Channels over which processes hear of each other: what is needed of them, and one in memory."""

import asyncio
from collections.abc import Callable
from typing import Protocol

Heard = Callable[[bytes], None]
"""Called with each message of a channel, on the event loop's thread."""


class Bus(Protocol):
    """Carries messages in order and may lose some: whoever listens must be able to tell."""

    def publish(self, channel: str, message: bytes) -> None:
        """Send a message to all who listen to this channel now; never waits."""

    def subscribe(self, channel: str, heard: Heard) -> None:
        """Listen to a channel, with one listener for each of this bus."""

    def unsubscribe(self, channel: str) -> None:
        """Listen no more."""


class Carried(Bus, Protocol):
    """A bus that works while it is carried."""

    async def run(self) -> None:
        """Carry messages, until this is cancelled."""


class MemoryBus:
    """A bus within one process."""

    def __init__(self) -> None:
        self._listeners: dict[str, list[Heard]] = {}

    def publish(self, channel: str, message: bytes) -> None:
        """Send a message, at once."""
        for heard in list(self._listeners.get(channel, ())):
            heard(message)

    def join(self) -> "MemoryEnd":
        """Another process's end of it."""
        return MemoryEnd(self)

    def add(self, channel: str, heard: Heard) -> None:
        """Have a channel listened to."""
        self._listeners.setdefault(channel, []).append(heard)

    def remove(self, channel: str, heard: Heard) -> None:
        """And no more."""
        self._listeners[channel].remove(heard)


class MemoryEnd:
    """What one process has of a `MemoryBus`."""

    def __init__(self, bus: MemoryBus) -> None:
        self._bus = bus
        self._own: dict[str, Heard] = {}

    async def run(self) -> None:
        """Nothing needs to be carried."""
        await asyncio.Event().wait()

    def publish(self, channel: str, message: bytes) -> None:
        """Send a message."""
        self._bus.publish(channel, message)

    def subscribe(self, channel: str, heard: Heard) -> None:
        """Listen to a channel."""
        self._own[channel] = heard
        self._bus.add(channel, heard)

    def unsubscribe(self, channel: str) -> None:
        """Listen no more."""
        self._bus.remove(channel, self._own.pop(channel))
