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


async def test_a_client_that_leaves_ends_its_work() -> None:
    client, ended, begun = Client(), asyncio.Event(), asyncio.Event()

    async def work() -> None:
        begun.set()
        try:
            await asyncio.Event().wait()
        finally:
            ended.set()

    asking = asyncio.create_task(attended(client.request, work()))
    await begun.wait()
    assert not ended.is_set()
    client.left.set()
    with pytest.raises(GoneError) as gone:
        await asking
    assert ended.is_set()
    assert response_for(gone.value).status < 500


async def test_a_request_that_is_cancelled_ends_its_work() -> None:
    ended, begun = asyncio.Event(), asyncio.Event()

    async def work() -> None:
        begun.set()
        try:
            await asyncio.Event().wait()
        finally:
            ended.set()

    asking = asyncio.create_task(attended(Client().request, work()))
    await begun.wait()
    asking.cancel()
    await asyncio.wait([asking])
    assert ended.is_set()
