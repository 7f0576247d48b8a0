"""The load generator: its client joins and ends, estimates the server's clock, and counts."""

import json
import time
from typing import Any

import pytest
from click.testing import CliRunner, Result

from benchmarks.load.client import Clock, RefusedError, room_url
from benchmarks.load.command import load as command
from benchmarks.load.generator import Load
from plinko.app.errors import InvalidValueError
from tests.kit.serving import Running, serving
from tests.kit.waiting import eventually


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
