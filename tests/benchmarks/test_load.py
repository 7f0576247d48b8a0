"""The load generator: its client joins and ends, estimates the server's clock, and counts."""

import asyncio
import json
import time
from typing import Any

import pytest
from click.testing import CliRunner, Result
from websockets.frames import Frame
from websockets.http11 import Request
from websockets.protocol import State
from websockets.server import ServerProtocol

from benchmarks.load.client import Clock, RefusedError, RoomClient, connect, room_url
from benchmarks.load.command import load as command
from benchmarks.load.generator import Load
from plinko.app.errors import InvalidValueError
from tests.kit.serving import Running, serving
from tests.kit.waiting import eventually, turns


@pytest.mark.parametrize(
    ("given_url", "whole"),
    [
        ("http://127.0.0.1:8000", "ws://127.0.0.1:8000/ws/rooms/main?stream=paths"),
        ("127.0.0.1:8000/", "ws://127.0.0.1:8000/ws/rooms/main?stream=paths"),
        ("https://h/plinko/", "wss://h/plinko/ws/rooms/main?stream=paths"),
        ("ws://h/ws/rooms/classic", "ws://h/ws/rooms/classic?stream=paths"),
    ],
)
def test_a_servers_address_leads_to_its_room(given_url: str, whole: str) -> None:
    assert room_url(given_url, "main", "paths") == whole


@pytest.mark.parametrize("bad", ["ftp://h", "http://", ""])
def test_an_invalid_address_is_named(bad: str) -> None:
    with pytest.raises(InvalidValueError, match="is not an address"):
        room_url(bad, "main", "snapshots")


def pong(sent: float, ahead: float, there: float, tick: int, late: float) -> dict[str, Any]:
    """A pong from a room whose tick k is due at server time 500 + k / 60."""
    made = 500.0 + tick / 60.0 + late
    return {"t": sent, "server_time": sent + there + ahead, "tick": tick, "tick_time": made}


def test_the_clock_follows_the_quickest_pong_and_earliest_tick() -> None:
    clock = Clock(60.0)
    assert not clock.known
    clock.observe(pong(10.0, 490.0, 0.010, 0, 0.005), 10.050)  # slow on the way back
    clock.observe(pong(10.2, 490.0, 0.001, 12, 0.0), 10.202)
    clock.observe(pong(10.4, 490.0, 0.030, 24, 0.004), 10.440)
    assert clock.offset == pytest.approx(490.0)
    assert clock.trip == pytest.approx(0.002)
    assert clock.due(60) == pytest.approx(11.0)


def test_the_clock_drifts_with_the_server_s_and_forgets_a_sleep() -> None:
    clock = Clock(60.0, kept=5)
    for k in range(100):
        ahead = 490.0 + 1e-4 * k
        clock.observe(pong(10.0 + k, ahead, 0.001, 60 * k, 0.0), 10.002 + k)
    assert clock.offset == pytest.approx(490.0 + 1e-4 * 97, abs=3e-4)
    late = pong(200.0, 490.01, 0.001, 6000, 100.0)  # the room slept for 100 s
    clock.observe(late, 200.002)
    assert clock.due(6000) == pytest.approx(late["tick_time"] - 490.01, abs=1e-3)


class Ears:
    """A listener that stores everything."""

    def __init__(self) -> None:
        self.events: list[dict[str, Any]] = []
        self.binaries: list[bytes] = []
        self.end: asyncio.Future[tuple[int, str]] = asyncio.get_running_loop().create_future()

    def event(self, client: RoomClient, event: dict[str, Any], now: float) -> None:
        self.events.append(event)

    def binary(self, client: RoomClient, data: bytes, now: float) -> None:
        self.binaries.append(data)

    def closed(self, client: RoomClient, code: int, reason: str) -> None:
        self.end.set_result((code, reason))


async def test_it_joins_plays_and_leaves(server: Running) -> None:
    ears = Ears()
    joined = await connect(room_url(server.url, "triangle-8", "snapshots"), ears)
    joined.send(type="drop", seed="42", ref="x" * 200)
    # Balls of other tests may fall in the same room.
    await eventually(lambda: any(event.get("ref") for event in ears.events))
    (mine,) = [event for event in ears.events if event.get("ref")]
    assert (mine["type"], mine["seed"], mine["ref"]) == ("accepted", "42", "x" * 200)
    landed = ("landed", mine["ball"])
    await eventually(lambda: landed in [(e["type"], e.get("ball")) for e in ears.events])
    assert ears.events[0]["type"] == "hello"
    ticks = [int.from_bytes(data[4:8], "little") for data in ears.binaries]
    assert ticks == sorted(set(ticks)) != []
    joined.close()
    await ears.end


async def test_it_hears_why_it_was_sent_away(server: Running) -> None:
    ears = Ears()
    await connect(room_url(server.url, "nope", "snapshots"), ears)
    code, reason = await ears.end
    assert code == 4004
    assert "nope" in reason


async def test_a_connection_that_breaks_ends_without_a_word() -> None:
    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        server = ServerProtocol()
        while server.state is State.CONNECTING:
            server.receive_data(await reader.read(4096))
            for event in server.events_received():
                if isinstance(event, Request):
                    server.send_response(server.accept(event))
        server.send_ping(b"are you there")
        server.send_binary(b"\0" * 70_000)
        writer.write(b"".join(server.data_to_send()))
        while not any(isinstance(e, Frame) for e in server.events_received()):
            server.receive_data(await reader.read(4096))
        writer.transport.abort()

    ears = Ears()
    async with await asyncio.start_server(answer, "127.0.0.1", 0) as listening:
        port = listening.sockets[0].getsockname()[1]
        joined = await connect(f"ws://127.0.0.1:{port}/", ears)
        assert await ears.end == (1006, "")
    assert [len(data) for data in ears.binaries] == [70_000]
    joined.send(type="ping", t=0.0)  # the connection is closed; sending raises no error


async def test_what_is_no_websocket_is_refused(server: Running) -> None:
    with pytest.raises(RefusedError, match="HTTP 403"):
        await connect(f"ws{server.url.removeprefix('http')}/healthz/ws?", Ears())


@pytest.mark.parametrize("stream", ["snapshots", "paths"])
async def test_a_load_counts_what_its_clients_got(stream: str) -> None:
    began = time.monotonic()

    async def enough(_: float) -> None:
        """Wait until every client has received something and the clock is set."""
        frames = [each.frames for each in load.counted.values()]
        await eventually(
            lambda: (
                load.clock
                and load.clock.known
                and load.dropped >= 3
                # A pong from before the room moved does not count, since its ticks have no time.
                and (
                    stream != "snapshots"
                    or load.clock.due(max(c.tick for c in load.counted.values())) > began
                )
                and (
                    not load.counting
                    or all(c.frames > f for c, f in zip(load.counted.values(), frames, strict=True))
                )
            )
        )

    with serving() as server:
        url = room_url(server.url, "triangle-8", stream)
        load = Load(url, 5, stream, drops=10.0, wait=enough)
        report = await load.run(2.0)
        found = report.to_dict()
    assert (found["connected"], found["refused"], found["closed"]) == (5, {}, {})
    assert found["frames"] == sum(c.frames for c in load.counted.values()) > 0
    assert found["drops"] == load.dropped >= 3
    assert 0.0 <= found["latency"]["p50"] <= found["latency"]["p99"] <= found["latency"]["worst"]
    age = time.monotonic() - began
    assert found["latency"]["worst"] < age, "the clocks were compared: no frame is that old"
    assert found["fps"]["least"] > 0.0


async def test_a_server_that_takes_long_to_greet_is_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    load = Load("ws://slow", 1, wait=lambda _: turns())
    client: Any = Silent()

    async def joined(*_: object, **__: object) -> Any:
        return client

    monkeypatch.setattr("benchmarks.load.generator.connect", joined)
    running = asyncio.create_task(load.run(1.0))
    await turns()
    assert not running.done()
    load.event(client, {"type": "hello", "tick_rate": 60.0}, 0.0)
    assert (await running).connected == 1


class Silent:
    """A client that sends nothing."""

    texts = text_bytes = 0

    def send(self, **message: Any) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing: there is no connection."""


async def test_a_load_counts_gaps_and_ends() -> None:
    load = Load("ws://nowhere", 1)
    client: Any = object()
    load.counting = True
    for tick in (7, 8, 11, 12):
        load.binary(client, b"\x50\x01\0\0" + tick.to_bytes(4, "little") + bytes(4), 0.0)
    load.closed(client, 4008, "too slow")
    report = load._report(1.0)
    assert (report.frames, report.missed, report.gappy) == (4, 2, 1)
    assert report.closed == {"4008 too slow": 1}


async def test_a_load_that_nobody_greets_says_why() -> None:
    with serving() as server:
        with pytest.raises(RefusedError, match="4004 room 'nope'"):
            await Load(room_url(server.url, "nope", "snapshots"), 2).run(1.0)
        with pytest.raises(RefusedError, match=r"refused|Connect"):
            await Load("ws://127.0.0.1:9/ws/rooms/main?stream=snapshots", 2).run(1.0)


def asked(*arguments: str) -> Result:
    return CliRunner().invoke(command, list(arguments))


def test_a_load_prints_what_it_found(server: Running) -> None:
    options = (server.url, "--clients", "3", "--seconds", "1", "--room", "triangle-9")
    found = json.loads(asked(*options, "--json").stdout)
    assert (found["connected"], found["stream"]) == (3, "snapshots")
    assert {"fps", "latency", "behind", "gaps"} <= found.keys()
    out = asked(*options).stdout
    for word in ("fps", "latency", "p99", "behind", "gaps", "3 of 3"):
        assert word in out


@pytest.mark.parametrize(
    ("url", "why"), [("ftp://nowhere", "is not an address"), ("127.0.0.1:9", "Error: ")]
)
def test_a_load_that_cannot_begin_says_why_in_one_line(url: str, why: str) -> None:
    done = asked(url, "--clients", "1")
    assert done.exit_code == 1
    assert why in done.stderr
    assert done.stderr.count("\n") == 1
