"""When a client leaves, its computation is cancelled."""

import asyncio
from typing import Any

import pytest
from starlette.requests import Request

from plinko.app.errors import GoneError, response_for
from plinko.app.web.routes.common import attended


class Client:
    """A connection that is open until `leave`."""

    def __init__(self) -> None:
        self.left = asyncio.Event()
        self.asked = False

    async def receive(self) -> dict[str, Any]:
        if not self.asked:
            self.asked = True
            return {"type": "http.request", "body": b"", "more_body": False}
        await self.left.wait()
        return {"type": "http.disconnect"}

    @property
    def request(self) -> Request:
        return Request({"type": "http", "headers": []}, self.receive)


async def test_a_client_that_stays_gets_the_answer_or_the_error() -> None:
    async def seven() -> int:
        return 7

    async def fail() -> int:
        raise ZeroDivisionError

    assert await attended(Client().request, seven()) == 7
    with pytest.raises(ZeroDivisionError):
        await attended(Client().request, fail())


class Work:
    """Work without an end, and whether it has begun and was ended."""

    def __init__(self) -> None:
        self.begun, self.ended = asyncio.Event(), asyncio.Event()

    async def done(self) -> None:
        self.begun.set()
        try:
            await asyncio.Event().wait()
        finally:
            self.ended.set()


async def test_a_client_that_leaves_ends_its_work() -> None:
    client, work = Client(), Work()
    asking = asyncio.create_task(attended(client.request, work.done()))
    await work.begun.wait()
    assert not work.ended.is_set()
    client.left.set()
    with pytest.raises(GoneError) as gone:
        await asking
    assert work.ended.is_set()
    assert response_for(gone.value).status < 500
    # So does a request that is cancelled.
    work = Work()
    asking = asyncio.create_task(attended(Client().request, work.done()))
    await work.begun.wait()
    asking.cancel()
    await asyncio.wait([asking])
    assert work.ended.is_set()
