"""Three servers behind HAProxy with the configuration in `deploy/`."""

import asyncio
import contextlib
import signal
import time
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from typing import Any, Final

import httpx
import pytest
from websockets.asyncio.client import ClientConnection

from plinko.app.cluster.membership import LEASE
from tests.app.cluster.servers import Servers
from tests.app.cluster.watchers import spread
from tests.deploy.proxies import DEPLOY, before
from tests.deploy.test_proxy import needs_haproxy
from tests.kit.player import events_of, joining, playing, send
from tests.kit.presets import SAMPLE
from tests.kit.process import ServerProcess
from tests.kit.siege import Broken
from tests.kit.waiting import LIMIT, eventually

ROOMS = 6
AGAIN: Final = 0.05  # s

pytestmark = [needs_haproxy, pytest.mark.postgresql]


@pytest.fixture
def proxy(servers: Servers) -> Iterator[str]:
    """HAProxy's address, without the scheme."""
    places = {f"PLINKO_{k + 1}": f"127.0.0.1:{one.port}" for k, one in enumerate(servers)}
    with before("haproxy", places, DEPLOY) as port:
        yield f"127.0.0.1:{port}"


async def test_clients_of_the_proxy_do_not_notice_a_killed_server(
    proxy: str, servers: Servers
) -> None:
    with httpx.Client(base_url=f"http://{proxy}/api/v1", timeout=LIMIT) as http:
        made = [http.post("/rooms", json={"board": "triangle-8"}) for _ in range(ROOMS)]
        rooms = [answer.raise_for_status().json()["id"] for answer in made]
        for room in rooms:
            assert http.post(f"/rooms/{room}/drops", json={"seed": "60"}).status_code == 202
        servers.all[1].end(signal.SIGKILL)
        for room in rooms:
            found = http.get(f"/rooms/{room}")
            assert found.status_code == 200, found.text
            second = http.post(f"/rooms/{room}/drops", json={"seed": "61"})
            assert second.status_code == 202, second.text
            assert second.json()["ball"] == 1, "the first is not forgotten"
        listed = {room["id"] for room in http.get("/rooms").json()["rooms"]}
        assert set(rooms) <= listed
    async with playing(f"ws://{proxy}/ws/rooms/{rooms[0]}") as player:
        assert player.hello["room"] == rooms[0]
        await player.send(type="drop", seed=62)  # the two earlier balls may have landed by now
        await player.until("landed", ball=2)


@dataclass
class Guest:
    """A client that pings its room all the time, and reconnects as a page does.

    asked, answered: when the last answered ping was sent and when its answer came, s.
    """

    room: str
    asked: float = 0.0
    answered: float = 0.0

    async def stay(self, proxy: str) -> None:
        while True:
            with contextlib.suppress(*Broken):
                url = f"ws://{proxy}/ws/rooms/{self.room}?stream=seeds"
                async with joining(url) as line:
                    asking = asyncio.create_task(self._ask(line))
                    try:
                        async for frame in line:
                            assert isinstance(frame, str)
                            self._hear(events_of(frame))
                    finally:
                        asking.cancel()
            await asyncio.sleep(AGAIN)  # no wait: a page's pause before it reconnects

    async def _ask(self, line: ClientConnection) -> None:
        while True:
            await send(line, type="ping", t=time.monotonic())
            await asyncio.sleep(AGAIN)  # no wait: the pause between two pings

    def _hear(self, events: list[dict[str, Any]]) -> None:
        for event in events:
            if event["type"] == "pong":
                self.asked, self.answered = event["t"], time.monotonic()


@contextlib.asynccontextmanager
async def guests(proxy: str) -> AsyncIterator[list[Guest]]:
    """One guest in each public room; between them the rooms are on all servers."""
    staying = [Guest(room) for room in ("main", *SAMPLE)]
    async with asyncio.TaskGroup() as tasks:
        running = [tasks.create_task(each.stay(proxy)) for each in staying]
        await eventually(lambda: all(each.answered for each in staying))
        yield staying
        for task in running:
            task.cancel()


async def seconds_away(staying: list[Guest], frozen: ServerProcess) -> list[float]:
    """Freeze a server until each guest has an answer again; returns their seconds without one."""
    away: dict[str, float] = {}

    def all_back() -> bool:
        for each in staying:
            if each.asked > since:
                away.setdefault(each.room, each.answered - since)
        return len(away) == len(staying)

    frozen.send(signal.SIGSTOP)
    since = time.monotonic()
    try:
        await eventually(all_back)
    finally:
        frozen.send(signal.SIGCONT)
    return list(away.values())


@pytest.mark.long("a server is frozen until its guests are at another")
async def test_clients_of_a_frozen_server_move_before_it_goes_on(
    proxy: str, servers: Servers
) -> None:
    async with guests(proxy) as staying:
        for frozen in servers:
            assert len(await seconds_away(staying, frozen)) == len(staying)
            await asyncio.to_thread(servers.start)  # returns once each knows all


@pytest.mark.long("how long clients of a frozen server are away, five times for each server")
async def test_for_how_long_clients_of_a_frozen_server_are_away(
    proxy: str, servers: Servers
) -> None:
    away: list[float] = []
    async with guests(proxy) as staying:
        for frozen in [*servers] * 5:
            # A server that was frozen waits for a lease before it considers another one failed.
            await asyncio.sleep(2 * LEASE)  # no wait: the servers watch each other for two leases
            away += await seconds_away(staying, frozen)
            await asyncio.to_thread(servers.start)  # returns once each knows all
    # The guests of the other servers were answered all the time: they are left out.
    print(f"clients of a frozen server: {spread([each for each in away if each > 0.5])}")  # noqa: T201
