"""What depends on another server ends once that server is gone, and not before."""

import asyncio
from typing import cast

import pytest

from app.cluster.alive import Alive
from app.cluster.beats import Beats
from app.cluster.membership import LEASE, Look, Member, Seen
from app.persistence.lease_book import LeaseBook
from tests.waiting import turns

A, B = Member("a.1", "a", ""), Member("b.1", "b", "http://b")


class Table:
    """The table of members, as a test has it; `now` is a clock."""

    def __init__(self) -> None:
        self.alive = [A, B]
        self.now = 0.0
        self.down = False

    async def beat(self, me: Member) -> Look:
        if self.down:
            raise TimeoutError
        return Look(1, tuple(Seen(each, 0.0, connected=True) for each in self.alive))


async def test_a_block_that_depends_on_a_server_ends_once_it_is_gone() -> None:
    table = Table()
    alive = Alive(cast(Beats, table), LeaseBook("a.1"), "a", clock=lambda: table.now)

    async def depend() -> None:
        async with alive.while_there(B):
            await asyncio.Event().wait()

    for table.now in (0.0, LEASE / 2, LEASE):
        await alive.beat()
    depending = asyncio.create_task(depend())
    await turns()
    table.alive = [A]
    table.down = True
    await alive.beat()
    await turns()
    assert not depending.done(), "nothing is known of it"
    table.down = False
    await alive.beat()
    with pytest.raises(TimeoutError):
        await depending
    async with alive.while_there(A):
        await alive.beat()
        await turns()
