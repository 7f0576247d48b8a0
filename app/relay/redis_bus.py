"""The bus over Redis: publish and subscribe, connected anew whenever the connection is lost."""

import asyncio
import logging
from collections import deque
from typing import Any, Final

from redis.asyncio import Redis
from redis.exceptions import RedisError

from app.errors import SettingError
from app.relay.bus import Heard

_ALWAYS: Final = "plinko:nothing"
"""A channel that nobody writes to: one that listens to nothing at all is no listener to Redis."""

_QUEUE: Final = 10_000
"""Messages that may wait for Redis; beyond that they are lost, and listeners begin anew."""

_TOGETHER: Final = 256
"""Messages that go to Redis in one round trip."""

_AGAIN: Final = 0.25
"""s between two attempts to connect."""

_log = logging.getLogger("plinko")


class RedisBus:
    """One process's end of the bus; `run` carries, until it is cancelled."""

    def __init__(self, url: str) -> None:
        try:
            self._redis = Redis.from_url(url, socket_keepalive=True)
        except ValueError as error:
            raise SettingError(f"relays={url!r} is no address of a Redis: {error}") from None
        self._listeners: dict[str, Heard] = {}
        self._queue: deque[tuple[str, bytes]] = deque(maxlen=_QUEUE)
        self._filled = asyncio.Event()
        self._changed = asyncio.Event()
        self.up = False
        """Whether Redis answered when it was last asked."""

    def publish(self, channel: str, message: bytes) -> None:
        """Send a message as soon as Redis takes it."""
        self._queue.append((channel, message))
        self._filled.set()

    def subscribe(self, channel: str, heard: Heard) -> None:
        """Listen to a channel."""
        self._listeners[channel] = heard
        self._changed.set()

    def unsubscribe(self, channel: str) -> None:
        """Listen no more."""
        self._listeners.pop(channel, None)
        self._changed.set()

    async def run(self) -> None:
        """Send and listen."""
        try:
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(self._again(self._write))
                tasks.create_task(self._again(self._listen))
        finally:
            await self._redis.aclose()

    async def _again(self, work: Any) -> None:
        """Do this for ever, also when the connection is lost."""
        while True:
            try:
                await work()
            except (RedisError, OSError) as error:
                if self.up:
                    _log.warning("the bus is lost: %s", error)
                self.up = False
            await asyncio.sleep(_AGAIN)

    async def _write(self) -> None:
        while True:
            await self._filled.wait()
            self._filled.clear()
            while self._queue:
                batch = [self._queue.popleft() for _ in range(min(_TOGETHER, len(self._queue)))]
                async with self._redis.pipeline(transaction=False) as pipeline:
                    for channel, message in batch:
                        pipeline.publish(channel, message)
                    await pipeline.execute()
                self.up = True

    async def _listen(self) -> None:
        """Hear what comes, on the channels that are listened to as they change."""
        async with self._redis.pubsub(ignore_subscribe_messages=True) as pubsub:
            await pubsub.subscribe(_ALWAYS)
            try:
                async with asyncio.TaskGroup() as tasks:
                    tasks.create_task(self._hear(pubsub))
                    tasks.create_task(self._settle(pubsub))
            except* (RedisError, OSError) as lost:
                raise lost.exceptions[0] from None

    async def _settle(self, pubsub: Any) -> None:
        """Listen to what is to be listened to, and to nothing else, whenever that changes."""
        there: set[str] = set()
        while True:
            self._changed.clear()
            wanted = set(self._listeners)
            if wanted - there:
                await pubsub.subscribe(*(wanted - there))
            if there - wanted:
                await pubsub.unsubscribe(*(there - wanted))
            there, self.up = wanted, True
            await self._changed.wait()

    async def _hear(self, pubsub: Any) -> None:
        while True:
            message = await pubsub.get_message(timeout=None)
            heard = message and self._listeners.get(message["channel"].decode())
            if heard:
                heard(message["data"])
