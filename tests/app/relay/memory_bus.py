"""A bus within one process, which delivers at once; each call of `join` gives a further end."""

import asyncio

from plinko.app.relay.bus import Heard


class MemoryBus:
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
        await asyncio.Event().wait()  # `publish` delivers without it

    def publish(self, channel: str, message: bytes) -> None:
        self._bus.publish(channel, message)

    def subscribe(self, channel: str, heard: Heard) -> None:
        self._own[channel] = heard
        self._bus.add(channel, heard)

    def unsubscribe(self, channel: str) -> None:
        self._bus.remove(channel, self._own.pop(channel))
