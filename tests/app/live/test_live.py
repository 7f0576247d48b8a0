"""A live room over a real WebSocket: exact drops, equal bytes for all, silence when idle."""

import asyncio
import contextlib
import itertools
import re
import socket
import time
from collections.abc import Iterator
from typing import Any

import pytest

from plinko.engine import Board, drop
from tests.app.conftest import TINY
from tests.kit.player import Player, playing
from tests.kit.serving import Running, constants, serving
from tests.kit.waiting import eventually

BOARD = Board.from_json(TINY)


async def new_room(server: Running, board: Any = TINY) -> str:
    async with server.async_client() as http:
        response = await http.post("/api/v1/rooms", json={"board": board})
        room: str = response.json()["id"]
        return room


async def test_the_ball_is_shown_where_the_drop_says_it_is(server: Running) -> None:
    alone = drop(BOARD, 7)
    shown = 0
    async with playing(server.socket(await new_room(server))) as player:
        extent = player.hello["extent"]
        step = max(extent["x_max"] - extent["x_min"], extent["y_max"] - extent["y_min"]) / 65535
        while shown < 10:  # a slow client receives only the newest snapshot
            player.binaries.clear()
            await player.send(type="drop", seed=7)
            start = (await player.until("accepted"))["tick"]
            await player.until_empty()
            for frame in map(player.decode, player.binaries[:-1]):
                (ball,) = frame.balls
                (state,) = alone.states([(frame.tick - start) / 60])
                assert abs(ball["x"] - state["x"]) <= step
                assert abs(ball["y"] - state["y"]) <= step
                shown += 1


async def test_everyone_in_the_room_gets_the_same_bytes(server: Running) -> None:
    url = server.socket(await new_room(server))
    seeds = itertools.count()
    async with playing(url) as one, playing(url) as two:
        shared = 0
        while shared < 10:  # a slow client receives only the newest snapshot
            for each in (one, two):
                each.binaries.clear()
            for seed in itertools.islice(seeds, 5):
                await one.send(type="drop", seed=seed, ref=seed)
            await asyncio.gather(one.until_empty(), two.until_empty())
            first, second = (
                {one.decode(frame).tick: frame for frame in each.binaries} for each in (one, two)
            )
            assert all(first[tick] == second[tick] for tick in first.keys() & second.keys())
            shared += len(first.keys() & second.keys())
    # Event frames differ only in the sender's `ref`.
    told = [[text for text in each.texts[1:] if '"accepted"' not in text] for each in (one, two)]
    assert told[0] == told[1]
    accepted = [[e for e in each.events if e["type"] == "accepted"] for each in (one, two)]
    count = next(seeds)
    assert [event["ref"] for event in accepted[0]] == list(range(count))
    assert [event["ref"] for event in accepted[1]] == [None] * count
    assert accepted[1] == [{**event, "ref": None} for event in accepted[0]]


async def test_events_come_before_the_snapshot_that_counts_them(server: Running) -> None:
    async with playing(server.socket(await new_room(server))) as player:
        for seed in range(5):
            await player.send(type="drop", seed=seed)
        while True:
            frame = await player.step()
            if isinstance(frame, bytes):
                snapshot = player.decode(frame)
                assert snapshot.seq <= player.hello["seq"] + len(player.events)
                if not len(snapshot.balls):
                    break
        assert snapshot.seq == player.hello["seq"] + len(player.events)
    assert [event["type"] for event in player.events].count("landed") == 5


async def ticks(server: Running, count: int) -> None:
    """Wait for `count` ticks of this server, by a falling ball: a reference for another clock."""
    async with server.async_client() as http:
        room = await new_room(server)
        (await http.post(f"/api/v1/rooms/{room}/drops")).raise_for_status()
    world = server.services.rooms.find(room).room.world
    await eventually(lambda: world.tick >= count)


async def test_at_rest_nothing_is_sent_ticked_or_woken(
    server: Running,
) -> None:
    with serving() as still:
        ticker = still.services.rooms.ticker
        assert (ticker.ticks, ticker.wakeups, ticker.asleep) == (0, 0, True)
        room = await new_room(still)
        async with playing(still.socket(room)) as player:
            await ticks(server, 12)
            assert (ticker.ticks, ticker.wakeups) == (0, 0)
            await player.send(type="drop", seed=1)
            await player.until_empty()
            await eventually(lambda: ticker.asleep)
            counts = (ticker.ticks, ticker.wakeups)
            assert counts[1] == 1
            traffic = still.services.hub.traffic
            sent = traffic.frames
            assert sent > 0
            hearing = asyncio.create_task(player.step())
            await ticks(server, 18)
            assert not hearing.done(), "it was announced to nobody"
            assert (ticker.ticks, ticker.wakeups, traffic.frames) == (*counts, sent)
            await player.send(type="drop", seed=2)
            await hearing
            await player.until("landed")
            assert ticker.wakeups == 2


async def test_a_client_that_comes_back_mid_flight_gets_the_full_state(server: Running) -> None:
    url = server.socket(await new_room(server))
    alone = drop(BOARD, 2**64 - 1)
    for drops in itertools.count(1):
        async with playing(url) as player:
            await player.send(type="drop", seed="18446744073709551615")
            accepted = await player.until("accepted")
            while not player.binaries:
                await player.step()
        async with playing(url) as again:
            assert again.hello["tick"] > player.hello["tick"]
            assert again.hello["stats"]["drops"] == drops
            if not again.hello["balls"]:  # the ball landed before the client reconnected
                continue
            (ball,) = again.hello["balls"]
            start = ("ball", "seed", "x", "tick", "practice")
            assert ball == {name: accepted[name] for name in start}
            landed = await again.until("landed", ball=ball["ball"])
            break
    assert landed["digest"] == alone.digest
    async with playing(url) as third:
        assert third.hello["balls"] == []
        histogram = [0, 0]
        histogram[landed["bin"]] = drops
        assert third.hello["stats"]["histogram"] == histogram
        assert third.hello["seq"] >= 2


async def test_hello_says_all_that_a_page_needs_and_a_ping_comes_back(server: Running) -> None:
    async with playing(server.socket("triangle-12-high")) as player:
        hello = player.hello
        await player.send(type="ping", t=12.5)
        pong = await player.until("pong")
    assert pong["t"] == 12.5
    assert pong["server_time"] >= hello["server_time"]
    board = Board.preset("triangle-12-high")
    assert Board.from_json(hello["board"]) == board
    assert hello["board_digest"] == board.digest
    assert (hello["type"], hello["protocol"], hello["room"]) == ("hello", 2, "triangle-12-high")
    assert (hello["mode"], hello["solver"], hello["tick_rate"]) == ("independent", "exact", 60)
    assert hello["slots"] == list(board.slots)
    assert hello["limits"]["balls"] == 200
    assert 0 < hello["velocity_scale"] < 1


BAD = [
    ("{", "malformed", "JSON"),
    ("", "malformed", "JSON"),
    ("[]", "malformed", "object"),
    ("null", "malformed", "object"),
    ('{"type":"drop","ref":' + "[" * 4000, "malformed", "deeply"),
    (b"\x50\x01", "malformed", "binary"),
    ('{"type":"fly"}', "unknown-message", "'fly' is not one of: drop, ping"),
    ('{"type":"drop","sede":1}', "malformed", "sede"),
    ('{"type":"drop","seed":-1}', "bad-seed", "-1"),
    ('{"type":"drop","seed":18446744073709551616}', "bad-seed", "18446744073709551616"),
    ('{"type":"drop","seed":"abc"}', "bad-seed", "abc"),
    ('{"type":"drop","seed":1.5}', "bad-seed", "1.5"),
    ('{"type":"drop","seed":true}', "bad-seed", "True"),
    ('{"type":"drop","seed":{}}', "bad-seed", "{}"),
    ('{"type":"drop","seed":"1","seed":"2"}', "invalid-value", "seed: the key is given twice"),
    ('{"type":"drop","ref":{"a":1,"a":1}}', "invalid-value", "ref.a: the key is given twice"),
    ('{"type":"drop","seed":"1","who":"\\ud800"}', "invalid-value", "who: "),
    ('{"type":"drop","stake":-5}', "invalid-value", "-5"),
    ('{"type":"drop","aim":"left"}', "invalid-value", "aim 'left' is not a number of metres"),
    ('{"type":"drop","x":"left"}', "invalid-value", "left"),
    ('{"type":"drop","x":NaN}', "invalid-value", "x: NaN is not a JSON number"),
    ('{"type":"ping","t":1e999}', "invalid-value", "t: 1e999 is out of range"),
    ('{"type":"drop","x":1e9}', "bad-parameter", "1000000000"),
    ('{"type":"ping","t":null}', "malformed", "t"),
]


@pytest.mark.parametrize(("message", "code", "named"), BAD, ids=lambda value: repr(value)[:40])
async def test_a_bad_message_is_answered_and_the_game_goes_on(
    server: Running, message: str | bytes, code: str, named: str
) -> None:
    async with playing(server.socket("triangle-8")) as player:
        await player.socket.send(message)
        error = await player.until("error")
        assert error["code"] == code
        assert named in error["detail"]
        await player.send(type="drop", seed="abc", ref={"n": 7})
        assert (await player.until("error"))["ref"] == {"n": 7}
        await player.send(type="ping", t=1)
        await player.until("pong")


async def test_a_flood_of_bad_messages_is_closed_with_the_reason(server: Running) -> None:
    async with playing(server.socket("triangle-8")) as player:
        for _ in range(1000):
            await player.socket.send("{")
        code, reason = await player.closed()
    assert (code, "too many bad messages" in reason) == (1008, True)
    assert 10 < len(player.events) < 1000


async def test_a_flood_of_good_messages_is_closed_eager_play_is_not() -> None:
    few = {"plinko.app.settings.OTHER_MESSAGES": 0.9}
    with constants(**few), serving(drop_rate=0.1) as server:
        room = await new_room(server)
        # 60 frames are within the burst of 64 frames, but too many messages. Of 1,000, the server
        # reads many at once: these are too many frames before the first is read as a message.
        for count, limits in ((60, "messages"), (1000, "(messages|frames)")):
            async with playing(server.socket(room)) as player:
                for t in range(count):
                    await player.send(type="ping", t=t)
                code, reason = await player.closed()
                assert code == 1008
                assert re.search(rf"more than \d {limits} a second", reason)
    many = {"plinko.app.settings.OTHER_MESSAGES": 1000.0}
    with constants(**many), serving(drop_rate=2.0) as server:
        async with playing(server.socket(await new_room(server))) as player:
            began = time.monotonic()
            for seed in range(100):
                await player.send(type="drop", seed=seed, ref=seed)
            error = await player.until("error")
            seconds = time.monotonic() - began
            await player.send(type="ping", t=1)
            await player.until("pong")
            refused = [each for each in player.events if each["type"] == "error"]
    assert {each["code"] for each in refused} == {"rate-limited"}
    assert 4 <= error["ref"] <= 4 + 2.0 * seconds, "four at once, and two more a second"
    assert "2 drops a second" in error["detail"]
    assert len(refused) > 90 - 2.0 * (time.monotonic() - began)


async def test_text_that_is_not_utf8_closes_with_1007(server: Running) -> None:
    async with playing(server.socket("triangle-8")) as player:
        await player.socket.send(b"\xff\xfe", text=True)
        assert (await player.closed())[0] == 1007


async def test_a_full_room_refuses_balls_and_clients() -> None:
    with serving(max_balls=2, max_clients=1) as server:
        async with playing(server.socket("triangle-8")) as player:
            for seed in range(3):
                await player.send(type="drop", seed=seed, ref=seed)
            error = await player.until("error")
            assert (error["code"], error["ref"]) == ("too-many-balls", 2)
            async with playing(server.socket("triangle-8")) as late:
                assert (late.hello["type"], late.hello["code"]) == ("error", "room-full")
                assert (await late.closed())[0] == 1013
        async with playing(server.socket("triangle-8")) as next_one:
            assert next_one.hello["type"] == "hello"


@pytest.mark.parametrize(
    ("address", "code", "closes", "named"),
    [
        ("nope", "unknown-room", 4004, "nope"),
        ("main?steam=paths", "invalid-value", 1008, "'steam' is not a query parameter here; the"),
        ("main?stream=paths&stream=snapshots", "invalid-value", 1008, "stream is given 2 times"),
        ("main?stream=films", "invalid-value", 1008, "'films' is not one of: snapshots, paths"),
        ("main?stream=segments", "invalid-value", 1008, "use 'paths'"),
        ("main?protocol=1", "invalid-value", 1008, "protocol '1' is not 2"),
    ],
)
async def test_an_unknown_address_closes_with_the_reason(
    server: Running, address: str, code: str, closes: int, named: str
) -> None:
    async with playing(server.socket(address)) as player:
        assert (player.hello["type"], player.hello["code"]) == ("error", code)
        assert named in player.hello["detail"]
        closed, reason = await player.closed()
    assert (closed, player.hello["detail"].startswith(reason[:50])) == (closes, True)


def deaf_socket(server: Running) -> socket.socket:
    """A socket with the smallest receive buffer that the system allows."""
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    host, port = server.url.removeprefix("http://").split(":")
    connection.connect((host, int(port)))
    return connection


@contextlib.contextmanager
def slow_reading(grace: float, linger: float) -> Iterator[Running]:
    """A server with a small send buffer, which soon disconnects clients that do not read."""
    changed = {
        "plinko.app.listening.SEND_BUFFER": 4096,
        "plinko.app.web.routes.rooms.ws.READING_GRACE": grace,
        "plinko.app.web.routes.rooms.ws.LINGER": linger,
    }
    with constants(**changed), serving(drop_rate=1e4) as server:
        yield server


async def test_a_stalled_client_delays_no_other_and_gets_a_reason() -> None:
    """One client stops reading while balls fall; the other receives every event."""
    with slow_reading(grace=3.0, linger=60.0) as server:
        room = await new_room(server)
        deaf = {"sock": deaf_socket(server), "max_queue": 1}
        async with (
            playing(server.socket(room), **deaf) as stalled,
            playing(server.socket(room)) as player,
        ):
            await drop_until_given_up(server, room, player)
            count = player.kinds().count("accepted")
            while player.kinds().count("landed") < count:
                await player.step()
            for event in player.events:
                if event["type"] == "landed":
                    assert event["digest"] == drop(BOARD, event["seed"]).digest
            code, reason = await stalled.closed()
        assert (code, bool(reason)) == (4008, True)
        seen = [event["ball"] for event in stalled.events if event["type"] == "accepted"]
        assert seen == list(range(len(seen))), "what it did get was in order, with no gap"


async def test_a_stalled_client_that_never_reads_again_is_dropped() -> None:
    with slow_reading(grace=3.0, linger=0.1) as server:
        room = await new_room(server)
        deaf = {"sock": deaf_socket(server), "max_queue": 1}
        async with (
            playing(server.socket(room), **deaf) as stalled,
            playing(server.socket(room)) as player,
        ):
            await drop_until_given_up(server, room, player)
            # The client reads nothing, so only an abort can free the connection.
            await eventually(lambda: server.connections == 1)
            assert (await stalled.closing()).rcvd is None


async def drop_until_given_up(server: Running, room: str, player: Player) -> None:
    """Keep the room full of balls until `player` is its only client."""
    seed = 0
    while server.services.hub.count(room) == 2:
        for _ in range(40):
            await player.send(type="drop", seed=seed)
            seed += 1
        await player.until("landed")
