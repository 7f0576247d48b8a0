"""Publish and subscribe between processes: the interface, and the bus over Redis by its address."""

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, Protocol

from plinko.app.ops.metrics import Reading
from plinko.engine.errors import MissingPartError

Heard = Callable[[bytes], None]
"""A listener: called with each message of a channel, on the event loop's thread."""


class Bus(Protocol):
    """Delivers messages in order but may lose some, so listeners must detect a gap themselves.

    It works while `run` is running. up: whether it delivers now.
    """

    up: bool

    async def run(self) -> None:
        """Deliver messages until cancelled."""

    def publish(self, channel: str, message: bytes) -> None:
        """Send a message to the channel's current listeners; never waits."""

    def subscribe(self, channel: str, heard: Heard) -> None:
        """Listen to a channel; this replaces the bus's former listener to it."""

    def unsubscribe(self, channel: str) -> None: ...


def readings(bus: Bus) -> Iterator[Reading]:
    yield "plinko_redis_up", "1 while the connection to Redis works.", bus.up, {}


def redis_at(url: str) -> Bus:
    """The bus at `url`; raises MissingPartError if the client is not installed, SettingError."""
    try:
        module: Any = import_module("plinko.app.relay.redis_bus")
    except ModuleNotFoundError as error:
        if error.name != "redis":
            raise
        raise MissingPartError(
            "relays need the Redis client: pip install 'plinko-sim[redis]'"
        ) from None
    bus: Bus = module.RedisBus(url)
    return bus
