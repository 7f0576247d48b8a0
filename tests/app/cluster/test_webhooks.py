"""Servers that share a ledger send a target every ball in order, whichever is killed."""

import asyncio
import signal
from itertools import count
from pathlib import Path

import httpx
import pytest

from tests.app.cluster.servers import Servers, member
from tests.app.cluster.test_servers import new_room
from tests.app.webhooks.target import FlakyTarget
from tests.kit.postgres import PostgreSQL
from tests.kit.process import ServerProcess
from tests.kit.waiting import LIMIT, eventually

pytestmark = [
    pytest.mark.postgresql,
    pytest.mark.long("two own servers, each killed and started once"),
]

BALLS = 5  # dropped before a server is killed, and as many after that


async def test_a_target_receives_all_balls_in_order_despite_kills(
    postgresql: PostgreSQL, tmp_path: Path
) -> None:
    target = FlakyTarget()
    more = target.options(tmp_path)
    one, two = member("plinko1", *more), member("plinko2", *more)
    seeds = count()
    with Servers(postgresql.new_database(), (one, two)) as servers:
        async with target.served(), httpx.AsyncClient(timeout=LIMIT) as http:

            async def drop_some(ask: ServerProcess) -> None:
                for _ in range(BALLS):
                    await drop_once(http, ask, room, next(seeds))

            async def lose(killed: ServerProcess, other: ServerProcess) -> None:
                told = len(target.heard)
                await drop_some(other)
                await eventually(lambda: len(target.heard) > told)
                await asyncio.to_thread(killed.end, signal.SIGKILL)
                await drop_some(other)
                await asyncio.to_thread(servers.start)

            room = await asyncio.to_thread(new_room, one)
            await lose(one, two)  # one of the two is the sender
            await lose(two, one)
            await target.has_heard_of(next(seeds))


async def drop_once(http: httpx.AsyncClient, ask: ServerProcess, room: str, seed: int) -> None:
    """Drop one ball, with retries while its room changes servers."""
    address = f"{ask.url}/api/v1/rooms/{room}/drops"
    key = {"idempotency-key": str(seed)}

    while True:
        answer = await http.post(address, json={"seed": str(seed)}, headers=key)
        if answer.status_code == 202:
            return
        assert answer.status_code == 503, answer.text
