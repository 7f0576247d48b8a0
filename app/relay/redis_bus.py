"""The bus over Redis's publish and subscribe. It reconnects whenever the connection is lost."""

import asyncio
import logging
from collections import deque
from typing import Any, Final

from redis.asyncio import Redis
from redis.exceptions import RedisError

from plinko.app.errors import SettingError
from plinko.app.relay.bus import Heard

_ALWAYS: Final = "plinko:nothing"
"""A channel without messages: Redis's client can only read while it has a subscription."""

_QUEUE: Final = 10_000
"""Messages that may wait for Redis. Beyond that the oldest are lost, and relays need a hello."""

_TOGETHER: Final = 256
"""The most messages sent to Redis in one round trip."""

_AGAIN: Final = 0.25
"""Seconds between two attempts to connect."""

_LOST: Final = (RedisError, OSError, RuntimeError)
"""What a call raises when its connection ends; uvloop raises RuntimeError if it writes to a closed
one."""

_log = logging.getLogger("plinko")


class RedisBus:
    """One process's end of the bus; it works while `run` is running."""

    def __init__(self, url: str) -> None:
        try:
            self._redis = Redis.from_url(url, socket_keepalive=True)
        except ValueError as error:
            # Without the value, which may contain a password.
            text = f"relays is not an address such as redis://127.0.0.1:6379: {error}"
            raise SettingError(text) from None
        self._listeners: dict[str, Heard] = {}
        self._queue: deque[tuple[str, bytes]] = deque(maxlen=_QUEUE)
        self._filled = asyncio.Event()
        self._changed = asyncio.Event()
        self.up = False
        """Whether the last call to Redis succeeded."""

    def publish(self, channel: str, message: bytes) -> None:
        """Queue a message; `run` sends it."""
        self._queue.append((channel, message))
        self._filled.set()

    def subscribe(self, channel: str, heard: Heard) -> None:
        self._listeners[channel] = heard
        self._changed.set()

    def unsubscribe(self, channel: str) -> None:
        self._listeners.pop(channel, None)
        self._changed.set()

    async def run(self) -> None:
        try:
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(self._again(self._write))
                tasks.create_task(self._again(self._listen))
        finally:
            await self._redis.aclose()

    async def _again(self, work: Any) -> None:
        """Repeat `work` for ever, also after the connection was lost."""
        while True:
            try:
                await work()
            except _LOST as error:
                if self.up:
                    _log.warning("the connection to Redis is lost, reconnecting: %s", error)
                self.up = False
            _end_if_cancelled()
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
                _end_if_cancelled()
                self.up = True

    async def _listen(self) -> None:
        """Receive messages, and follow changes of the subscribed channels."""
        async with self._redis.pubsub(ignore_subscribe_messages=True) as pubsub:
            await pubsub.subscribe(_ALWAYS)
            hearing = asyncio.create_task(self._hear(pubsub))
            # `_settle` must notice that the hearing has ended.
            hearing.add_done_callback(lambda _: self._changed.set())
            try:
                await self._settle(pubsub, hearing)
                await hearing
            finally:
                hearing.cancel()
                await asyncio.gather(hearing, return_exceptions=True)

    async def _settle(self, pubsub: Any, hearing: "asyncio.Task[None]") -> None:
        """Subscribe and unsubscribe at Redis when the listeners change, until `hearing` ends."""
        there: set[str] = set()
        while not hearing.done():
            self._changed.clear()
            wanted = set(self._listeners)
            if wanted - there:
                await pubsub.subscribe(*(wanted - there))
            if there - wanted:
                await pubsub.unsubscribe(*(there - wanted))
            _end_if_cancelled()
            there, self.up = wanted, True
            await self._changed.wait()

    async def _hear(self, pubsub: Any) -> None:
        while True:
            message = await pubsub.get_message(timeout=None)
            heard = message and self._listeners.get(message["channel"].decode())
            if heard:
                try:
                    heard(message["data"])
                except Exception:  # noqa: BLE001 - the other channels go on
                    _log.exception("a message on the bus was not understood")


def _end_if_cancelled() -> None:
    """Raise the cancellation that a call to Redis has swallowed.

    Before Python 3.12 `asyncio.wait_for` does so if what it waits for ends at the same moment.
    """
    task = asyncio.current_task()
    if task is not None and task.cancelling():
        raise asyncio.CancelledError
