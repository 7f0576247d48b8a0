"""The bus over a real Redis goes on whatever happens to one connection or one message."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any

import pytest
from redis.asyncio.client import PubSub

from plinko.app.relay.redis_bus import RedisBus
from tests.kit.redis import MISSING, PROGRAM, Redis
from tests.kit.waiting import eventually

pytestmark = pytest.mark.skipif(PROGRAM is None, reason=MISSING)


@contextlib.asynccontextmanager
async def carried(redis: Redis) -> AsyncIterator[RedisBus]:
    bus = RedisBus(redis.url)
    running = asyncio.create_task(bus.run())
    try:
        yield bus
        assert not running.done()
    finally:
        running.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await running


async def arrives(bus: RedisBus, channel: str, heard: list[bytes]) -> None:
    """Publish until a message is heard: those before the subscription are lost."""

    def tried() -> bool:
        bus.publish(channel, b"well")
        return bool(heard)

    await eventually(tried)


async def test_a_closed_connection_is_opened_again(monkeypatch: pytest.MonkeyPatch) -> None:
    receive = PubSub.get_message
    failed: list[bool] = []

    async def closed_at_first(self: PubSub, *args: Any, **options: Any) -> Any:
        if not failed:
            failed.append(True)
            raise RuntimeError("unable to perform operation on <TCPTransport closed=True>")
        return await receive(self, *args, **options)

    monkeypatch.setattr(PubSub, "get_message", closed_at_first)
    heard: list[bytes] = []
    with Redis() as redis:
        async with carried(redis) as bus:
            bus.subscribe("a", heard.append)
            await arrives(bus, "a", heard)
    assert failed


async def test_a_message_that_fails_ends_no_channel(caplog: pytest.LogCaptureFixture) -> None:
    heard: list[bytes] = []
    refused: list[bytes] = []

    def refuse(message: bytes) -> None:
        refused.append(message)
        raise ValueError("not understood")

    with Redis() as redis:
        async with carried(redis) as bus:
            bus.subscribe("bad", refuse)
            bus.subscribe("good", heard.append)
            await arrives(bus, "bad", refused)
            await arrives(bus, "good", heard)
    assert "a message on the bus was not understood" in caplog.messages
