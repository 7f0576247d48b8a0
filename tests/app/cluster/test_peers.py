"""WebSockets that lead over a server are ended when it ends, and no others."""

import asyncio

import pytest

from app.cluster.peers import Peers
from tests.waiting import LIMIT


async def test_all_that_are_there_are_ended_and_none_that_has_ended() -> None:
    peers = Peers()
    async with peers.socket():
        pass
    ended = []

    async def lead(number: int) -> None:
        with pytest.raises(TimeoutError):
            async with peers.socket():
                await asyncio.Event().wait()
        ended.append(number)

    leading = [asyncio.create_task(lead(number)) for number in range(3)]
    await asyncio.sleep(0)
    async with asyncio.timeout(LIMIT):
        await peers.end_sockets()
        await asyncio.gather(*leading)
    assert sorted(ended) == [0, 1, 2]
    await peers.end_sockets()
    await peers.close()
