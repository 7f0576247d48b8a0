"""A server that says nothing more: has its process ended, or does it only stand still?"""

import asyncio
import contextlib
import socket
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import msgspec

from app.cluster.leases import Leases
from app.cluster.line import Line
from app.cluster.membership import BEAT, LEASE, Look, Member
from app.cluster.node import Node
from app.live.holding import Holding
from app.persistence.ledger.writer import Ledger
from tests.ports import free_port
from tests.waiting import LIMIT, eventually

ME = Member("a.1", "a", "http://127.0.0.1:1")


class Store:
    """Leases of which one never runs out, whether its server lives or not."""

    def __init__(self, other: Member) -> None:
        self.other = other
        self.beats = 0

    async def beat(self, me: Member) -> Look:
        self.beats += 1
        return Look("s", (msgspec.structs.replace(ME, beats=self.beats), self.other))


class Clock:
    """Goes on when it is told to."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@contextlib.contextmanager
def listening() -> Iterator[str]:
    """An address at which connections are taken, and nothing is ever said."""
    with socket.create_server(("127.0.0.1", 0)) as frozen:
        yield f"http://127.0.0.1:{frozen.getsockname()[1]}"


@contextlib.asynccontextmanager
async def beside(address: str) -> Any:
    """A node beside another of this address, which has been silent for longer than its lease."""
    clock = Clock()
    holds = SimpleNamespace(holder=ME.holder, address=ME.address)
    line = Line()
    node = Node(
        cast(Leases, Store(Member("b.1", "b", address))),
        cast(Holding, SimpleNamespace(holds=holds, claim=None)),
        cast(Ledger, SimpleNamespace()),
        line,
        "a",
        has=lambda _: True,
        watched=lambda _: 0,
        clock=clock,
    )
    while clock.now <= LEASE + BEAT:
        clock.now += BEAT
        await node.beat()
    try:
        yield node
    finally:
        await line.close()


async def test_where_nobody_listens_any_more_a_server_has_ended_whatever_its_lease_says() -> None:
    async with beside(f"http://127.0.0.1:{free_port()}") as node:
        other = Member("b.1", "b", "")
        async with asyncio.timeout(LIMIT):
            await node.until_gone(other)
        assert set(node.view.members) == {ME.holder}
        await node.beat()
        assert node.view.is_gone(other.holder)


async def test_a_server_that_takes_connections_and_says_nothing_may_be_frozen() -> None:
    with listening() as address:
        async with beside(address) as node:
            await eventually(lambda: not node._knocking)
            assert set(node.view.members) == {ME.holder, "b.1"}


async def test_an_address_that_cannot_be_found_now_has_not_refused() -> None:
    async with beside("http://nowhere.invalid:80") as node:
        await eventually(lambda: not node._knocking)
        assert "b.1" in node.view.members
