"""Servers that share a ledger tell a target of every ball in order, whichever of them is killed."""

import asyncio
import signal
from itertools import count
from pathlib import Path
from typing import Any

import httpx
import msgspec
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from tests.app.cluster.servers import One, Servers, kept
from tests.app.cluster.test_servers import new_room
from tests.app.persistence import postgres
from tests.app.webhooks.target import SECRET, check_signature
from tests.app.webhooks.target import served as serving
from tests.ports import free_port
from tests.waiting import LIMIT, eventually

pytestmark = [
    pytest.mark.postgresql,
    pytest.mark.long("two servers of its own, each killed and started once"),
]

BALLS = 5  # dropped before a server is killed, and as many after that


async def test_a_target_hears_of_all_balls_in_order_whichever_server_is_killed(
    postgresql: postgres.Cluster, tmp_path: Path
) -> None:
    heard: list[dict[str, Any]] = []
    tries = count()

    async def hook(request: Request) -> Response:
        body = await request.body()
        check_signature(dict(request.headers), body)
        if next(tries) % 2:
            return Response(status_code=500)
        heard.extend(msgspec.json.decode(body)["events"])
        return Response(status_code=204)

    port = free_port()
    listed = tmp_path / "webhooks.json"
    address = f"http://127.0.0.1:{port}/hook"
    listed.write_bytes(msgspec.json.encode([{"url": address, "secret": SECRET}]))
    more = ("--webhooks", str(listed))
    one, two = One("plinko1", more=more), One("plinko2", more=more)
    servers = Servers(postgresql.new_database(), (one, two))
    seeds = count()
    with kept(servers):
        async with (
            serving(Starlette(routes=[Route("/hook", hook, methods=["POST"])]), port),
            httpx.AsyncClient(timeout=LIMIT) as http,
        ):

            async def drop_some(ask: One, room: str) -> None:
                for _ in range(BALLS):
                    await drop_once(http, ask, room, next(seeds))

            room = await asyncio.to_thread(new_room, one)
            for killed, other in ((one, two), (two, one)):  # one of them is the one that sends
                told = len(heard)
                await drop_some(other, room)
                await eventually(lambda told=told: len(heard) > told)
                await asyncio.to_thread(killed.end, signal.SIGKILL)
                await drop_some(other, room)
                await asyncio.to_thread(servers.start)
            dropped = next(seeds)
            await eventually(lambda: len({event["id"] for event in heard}) == 2 * dropped)
    first = list({event["id"]: event for event in heard}.values())
    accepted = [event for event in first if event["type"] == "accepted"]
    assert [event["seed"] for event in accepted] == [str(seed) for seed in range(dropped)]
    place = {event["id"]: number for number, event in enumerate(first)}
    for event in accepted:
        ball = f"{event['run']}.{event['ball']}"
        assert place[f"{ball}.accepted"] < place[f"{ball}.landed"]


async def drop_once(http: httpx.AsyncClient, ask: One, room: str, seed: int) -> None:
    """A ball, asked for until it is taken, also while its room changes servers."""
    address = f"{ask.url}/api/v1/rooms/{room}/drops"
    key = {"idempotency-key": str(seed)}

    while True:
        answer = await http.post(address, json={"seed": str(seed)}, headers=key)
        if answer.status_code == 202:
            return
        assert answer.status_code == 503, answer.text
