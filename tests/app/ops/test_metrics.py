"""The values in /metrics agree with the events that a client sees."""

import re
from pathlib import Path

from prometheus_client.parser import text_string_to_metric_families

from plinko.app.ops.metrics import Metrics
from tests.app.conftest import TINY
from tests.app.ops.rare import rare_readings
from tests.kit.player import playing
from tests.kit.serving import Running, serving
from tests.kit.waiting import eventually


def scrape(server: Running) -> dict[str, float]:
    """Samples without labels by name, and those with a code or result by name and code."""
    response = server.get("/metrics")
    assert response.status_code == 200
    assert response.headers["content-type"].startswith("text/plain")
    samples = {}
    for family in text_string_to_metric_families(response.text):
        assert family.documentation
        for sample in family.samples:
            code = sample.labels.get("code") or sample.labels.get("result", "")
            if not sample.labels.keys() - {"code", "result"}:
                samples[f"{sample.name} {code}".strip()] = sample.value
    return samples


async def test_a_game_shows_in_every_count() -> None:
    with serving() as server:
        before = scrape(server)
        assert before["plinko_clients"] == before["plinko_balls"] == 0
        assert before["plinko_ticker_asleep"] == 1
        with server.client() as http:
            slow = {**TINY, "gravity": 1.0}  # the ball falls for two seconds
            room = http.post("/api/v1/rooms", json={"board": slow}).json()["id"]
        async with playing(server.socket(room)) as player:
            await player.send(type="drop", seed=42)
            for wrong in ({"type": "fly"}, {"type": "drop", "x": 1e3}):
                await player.send(**wrong)
                await player.until("error")
            while not player.binaries:  # until a tick has sent a snapshot
                await player.step()
            during = scrape(server)
            assert during["plinko_clients"] == during["plinko_rooms_awake"] == 1
            assert during["plinko_balls"] == 1
            assert during["plinko_ticker_asleep"] == 0
            await player.until_empty()
            await eventually(lambda: server.services.rooms.ticker.asleep)
            after = scrape(server)
            frames = len(player.texts) + len(player.binaries)
            size = sum(map(len, player.binaries)) + sum(len(t.encode()) for t in player.texts)
        assert after["plinko_drops_total"] == after["plinko_landings_total"] == 1
        assert after["plinko_drops_refused_total refused"] == 1
        assert after["plinko_drops_refused_total undecided"] == 0
        assert after["plinko_rooms"] == 2
        assert after["plinko_frames_sent_total"] == frames
        assert after["plinko_sent_bytes_total"] == size
        assert after["plinko_frames_skipped_total"] == 0
        assert after["plinko_errors_total unknown-message"] == 1
        assert after["plinko_ticks_total"] >= after["plinko_tick_duration_seconds_count"] > 0
        assert after["plinko_ticks_total"] > 60
        assert (
            after["plinko_tick_lateness_seconds_count"]
            == after["plinko_tick_duration_seconds_count"]
        )
        assert after["plinko_ledger_commit_seconds_count"] >= 1
        assert after["process_resident_memory_bytes"] > 1e7


def test_errors_over_http_are_counted_by_code(server: Running) -> None:
    for path, code in (("nope/1", "unknown-board"), ("triangle-8/x", "bad-seed")):
        name = f"plinko_errors_total {code}"
        before = scrape(server).get(name, 0)
        server.get(f"/api/v1/drops/{path}")
        assert scrape(server)[name] == before + 1


def test_openmetrics_is_served_on_request_and_two_servers_in_one_process_count_apart() -> None:
    body, media_type = Metrics().exposition("application/openmetrics-text; version=1.0.0")
    assert media_type.startswith("application/openmetrics-text")
    assert body.endswith(b"# EOF\n")
    one, two = Metrics(), Metrics()
    one.errors.labels("x").inc()
    assert b'code="x"' in one.exposition("")[0]
    assert b'code="x"' not in two.exposition("")[0]


def test_every_metric_is_documented_and_every_documented_exists(server: Running) -> None:
    text = (Path(__file__).parents[3] / "docs" / "server.md").read_text()
    documented = set(re.findall(r"`(plinko_\w+)[`{]", text))
    there = {
        family.name + ("_total" if family.type == "counter" else "")
        for family in text_string_to_metric_families(server.get("/metrics").text)
        if family.name.startswith("plinko_") and not family.name.endswith("_created")
    }
    assert documented == there | {name for name, *_ in rare_readings()}
