"""Publish and subscribe between processes: the interface, and a bus in memory for tests."""

import asyncio
from collections.abc import Callable, Iterator
from typing import Protocol

from plinko.app.ops.metrics import Reading

Heard = Callable[[bytes], None]
"""A listener: called with each message of a channel, on the event loop's thread."""


class Bus(Protocol):
    """Delivers messages in order but may lose some, so listeners must detect a gap themselves."""

    def publish(self, channel: str, message: bytes) -> None:
        """Send a message to the channel's current listeners; never waits."""

    def subscribe(self, channel: str, heard: Heard) -> None:
        """Listen to a channel; this replaces the bus's former listener to it."""

    def unsubscribe(self, channel: str) -> None: ...


class Carried(Bus, Protocol):
    """A bus that delivers messages only while `run` is running. up: whether it does so now."""

    up: bool

    async def run(self) -> None:
        """Deliver messages until cancelled."""


def readings(bus: Carried) -> Iterator[Reading]:
    yield "plinko_redis_up", "1 while the connection to Redis works.", bus.up, {}


class MemoryBus:
    """A bus within one process; each call of `join` returns a further end of it."""

    def __init__(self) -> None:
        self._listeners: dict[str, list[Heard]] = {}

    def publish(self, channel: str, message: bytes) -> None:
        for heard in list(self._listeners.get(channel, ())):
            heard(message)

    def join(self) -> "MemoryEnd":
        return MemoryEnd(self)

    def add(self, channel: str, heard: Heard) -> None:
        self._listeners.setdefault(channel, []).append(heard)

    def remove(self, channel: str, heard: Heard) -> None:
        self._listeners[channel].remove(heard)


class MemoryEnd:
    """One end of a `MemoryBus`, which stands for one process."""

    up = True

    def __init__(self, bus: MemoryBus) -> None:
        self._bus = bus
        self._own: dict[str, Heard] = {}

    async def run(self) -> None:
        """Wait until cancelled: `publish` already delivers."""
        await asyncio.Event().wait()

    def publish(self, channel: str, message: bytes) -> None:
        self._bus.publish(channel, message)

    def subscribe(self, channel: str, heard: Heard) -> None:
        self._own[channel] = heard
        self._bus.add(channel, heard)

    def unsubscribe(self, channel: str) -> None:
        self._bus.remove(channel, self._own.pop(channel))
