"""WebSockets that lead over a server are closed when it ends, and no others."""

import asyncio

from app.cluster.passed import Passed
from tests.waiting import LIMIT


async def test_all_that_are_there_are_told_to_end_and_none_that_has_ended() -> None:
    passed = Passed()
    with passed.line() as over:
        pass
    with passed.line() as first, passed.line() as second:
        async with asyncio.timeout(LIMIT):
            await passed.close()
        assert first.is_set()
        assert second.is_set()
        assert not over.is_set()
