"""HAProxy, as `deploy/` has it, before three servers: clients know one address."""

import asyncio
import contextlib
import signal
from collections.abc import Iterator

import httpx
import pytest
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from tests.app.cluster.servers import Servers
from tests.app.conftest import playing
from tests.deploy.proxies import DEPLOY, before
from tests.deploy.test_proxy import needs_haproxy
from tests.waiting import LIMIT

ROOMS = 6

pytestmark = [needs_haproxy, pytest.mark.postgresql]


@pytest.fixture
def proxy(servers: Servers) -> Iterator[str]:
    """HAProxy's address, without the scheme."""
    places = {f"PLINKO_{k + 1}": f"127.0.0.1:{one.port}" for k, one in enumerate(servers)}
    with before("haproxy", places, DEPLOY) as port:
        yield f"127.0.0.1:{port}"


async def test_who_asks_the_proxy_notices_nothing_of_a_server_that_was_killed(
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
        await player.send(type="drop", seed=62)  # the ones before may have landed by now
        await player.until("landed", ball=2)


async def test_whoever_plays_at_a_server_that_stands_still_is_sent_to_another(
    proxy: str, servers: Servers
) -> None:
    made = httpx.post(f"http://{proxy}/api/v1/rooms", json={"board": "triangle-8"}, timeout=LIMIT)
    room = f"ws://{proxy}/ws/rooms/{made.json()['id']}"
    async with playing(room) as player:
        frozen = await asyncio.to_thread(servers.holder, player.hello["room"])
        frozen.send(signal.SIGSTOP)
        try:
            with contextlib.suppress(ConnectionClosed):
                while True:
                    await player.step()
            await lands_for_whoever_comes_again(room)
        finally:
            frozen.send(signal.SIGCONT)


async def lands_for_whoever_comes_again(room: str) -> None:
    """Drop a ball as a page does, which comes again where its line ends."""
    async with asyncio.timeout(LIMIT):
        while True:
            with contextlib.suppress(ConnectionClosed, InvalidHandshake):
                async with playing(room, open_timeout=LIMIT) as again:
                    await again.send(type="drop", seed=63)
                    await again.until("landed")
                    return
