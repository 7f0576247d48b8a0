"""A server and a relay over a real Redis: spectators, players, and restarts of each part."""

import contextlib
import re
import signal
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from click.testing import CliRunner

from benchmarks.load.generator import Load
from plinko.app.cli import plinko
from plinko.app.errors import SettingError
from plinko.app.relay.bus import redis_at
from plinko.app.relay.served import create_relay
from plinko.app.settings import Settings
from tests.app.relay.relays import Relayed, relaying
from tests.kit.address import Address
from tests.kit.player import Player, playing
from tests.kit.redis import MISSING, PROGRAM, Redis
from tests.kit.serving import Running, serving
from tests.kit.waiting import LIMIT, eventually

needs_redis = pytest.mark.skipif(PROGRAM is None, reason=MISSING)


@pytest.fixture(scope="module")
def redis() -> Iterator[Redis]:
    with Redis() as found:
        yield found


@pytest.fixture(scope="module")
def both(redis: Redis) -> Iterator[tuple[Running, Relayed]]:
    with serving(relays=redis.url) as server, relaying(redis, server.url) as relay:
        yield server, relay


@needs_redis
async def test_a_relay_s_spectator_sees_other_players_drops(
    both: tuple[Running, Relayed],
) -> None:
    server, relay = both
    async with (
        playing(relay.socket("triangle-8")) as far,
        playing(f"{server.socket('triangle-8')}?stream=seeds") as near,
    ):
        now = dict.fromkeys(("key", "server_time", "seq", "tick"), 0)  # differ from hello to hello
        assert far.hello | now == near.hello | now
        assert far.hello["tick"] <= near.hello["tick"]
        await near.send(type="drop", ref="mine", seed=42)
        landed = await near.until("landed")
        assert await far.until("landed") == landed
        (accepted,) = (event for event in far.events if event["type"] == "accepted")
        assert accepted["seed"] == "42"
        assert "ref" not in accepted, "a note is for its sender"
        await far.send(type="ping", t=1.0)
        pong = await far.until("pong")
        assert pong["t"] == 1.0
        assert pong["tick_time"] <= pong["server_time"]
        assert server.services.hub.count("triangle-8") == 2, "a player, and one for all far away"
        health = httpx.get(f"{relay.url}/healthz", timeout=LIMIT).json()
        assert health == {"status": "ok", "clients": 1, "rooms": 1, "lines": 0}
        assert "plinko_clients 1.0" in httpx.get(f"{relay.url}/metrics", timeout=LIMIT).text


@needs_redis
async def test_a_viewer_that_plays_reconnects_to_the_room_itself(
    both: tuple[Running, Relayed],
) -> None:
    _, relay = both
    async with playing(relay.socket("triangle-12")) as player:
        await player.send(type="drop", ref="mine", seed=7)
        again = await player.until("hello")
        assert again["run"] == player.hello["run"]
        assert again["key"] != player.hello["key"], "by which the room knows it from here on"
        assert (await player.until("accepted"))["ref"] == "mine"
        await player.until("landed")
        assert relay.here.lines == 1
    await eventually(lambda: relay.here.lines == 0)


@needs_redis
@pytest.mark.parametrize("query", ["", "?stream=seeds", "?stream=paths&watch=true"])
async def test_other_streams_than_seeds_go_to_the_room_itself(
    both: tuple[Running, Relayed], query: str
) -> None:
    _, relay = both
    async with playing(relay.socket("main", query)) as player:
        assert player.hello["stream"] == (query[8:].partition("&")[0] or "snapshots")
        assert relay.here.lines == 1
        await player.send(type="drop", ref="mine", seed=3)
        assert (await player.until("accepted"))["ref"] == "mine"
        assert player.kinds().count("hello") == 0, "but the first"
    await eventually(lambda: relay.here.lines == 0)


@needs_redis
@pytest.mark.parametrize("room", ["nowhere", "sandbox"])
async def test_what_a_relay_cannot_show_the_room_s_process_answers(
    both: tuple[Running, Relayed], room: str
) -> None:
    _, relay = both
    async with playing(relay.socket(room)) as player:
        said = player.hello
        assert said["type"] == ("error" if room == "nowhere" else "hello")
        assert said.get("code") == ("unknown-room" if room == "nowhere" else None)


@needs_redis
@pytest.mark.parametrize("said", ["{", '{"type":"ping","t":1,"t":2}', '{"type":"ping","t":NaN}'])
async def test_what_is_no_message_the_room_s_process_refuses(
    both: tuple[Running, Relayed], said: str
) -> None:
    _, relay = both
    async with playing(relay.socket()) as player:
        await player.socket.send(said)
        error = await player.until("error")
        assert error["code"] in ("malformed", "invalid-value")


@needs_redis
async def test_a_load_is_spread_over_all_that_it_is_given(both: tuple[Running, Relayed]) -> None:
    server, relay = both
    seen = []
    load = Load(
        relay.socket("triangle-14"),
        6,
        "seeds",
        drops=0.0,
        more=(f"{server.socket('triangle-14')}?stream=seeds",),
    )
    load.on_count = lambda: seen.append(
        (relay.here.hub.total, server.services.hub.count("triangle-14"))
    )
    report = await load.run(0.01)
    assert report.connected == 6
    assert seen == [(3, 3 + 1)], "and the relay's one subscriber"


async def learns(far: Player, drops: int) -> None:
    """Read until the spectator knows of this many drops, whose seeds are 1, 2, and so on.

    An event says so, or, if Redis has lost it, the hello that follows.
    """

    def says(event: dict[str, Any]) -> bool:
        if event["type"] == "hello":
            return bool(event["stats"]["drops"] == drops)
        return event["type"] == "accepted" and bool(event["seed"] == str(drops))

    while not any(map(says, far.events)):
        await far.step()


def up_at(process: Address) -> float:
    """What its metrics say about Redis."""
    text = process.get("/metrics").text
    (value,) = re.findall(r"^plinko_redis_up (\S+)$", text, re.MULTILINE)
    return float(value)


@needs_redis
async def test_redis_may_end_and_come_back() -> None:
    async with contextlib.AsyncExitStack() as stack:
        own = stack.enter_context(Redis())
        server = stack.enter_context(serving(relays=own.url))
        relay = stack.enter_context(relaying(own, server.url))
        far = await stack.enter_async_context(playing(relay.socket()))
        player = await stack.enter_async_context(playing(server.socket()))
        assert (up_at(server), up_at(relay)) == (1, 1)
        own.end(signal.SIGKILL)
        await eventually(lambda: (up_at(server), up_at(relay)) == (0, 0))
        await player.send(type="drop", seed=1)
        await player.until("accepted")
        own.start()
        await learns(far, 1)
        await player.send(type="drop", seed=2)
        await learns(far, 2)


@pytest.mark.parametrize(
    ("redis_url", "rooms", "said"),
    [
        ("http://a:secret@x", "http://127.0.0.1:1", "is not an address such as redis"),
        ("redis://127.0.0.1:1", "127.0.0.1:1", "is not an address such as http"),
    ],
)
def test_addresses_that_are_none_are_refused(redis_url: str, rooms: str, said: str) -> None:
    with pytest.raises(SettingError, match=said) as refused:
        create_relay(Settings(), redis_at(redis_url), rooms)
    assert "secret" not in str(refused.value)


def test_the_command_says_what_it_needs() -> None:
    done = CliRunner().invoke(plinko, ["relay", "--help"])
    assert done.exit_code == 0
    for option in ("--max-clients", "--trusted-proxies", "REDIS ROOMS"):
        assert option in done.output
    assert "--board" not in done.output
