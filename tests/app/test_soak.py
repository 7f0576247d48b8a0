"""A server used for long, by players who come and go: its memory stays what it was."""

import asyncio
import os
import statistics
import time
from pathlib import Path

import pytest

from app.client import room_url
from app.load import Load
from app.main import COMPILING
from benchmarks.serving import Served, can_watch, serving

LONG = bool(os.environ.get("LONG"))
"""Set by `make test-long`."""

SECONDS = 600.0 if LONG else 8.0
WAVE = 4.0  # s; then everybody leaves and others come
CLIENTS = 20
GROWTH = 6e6
"""Bytes that the last quarter of the time may need beyond the second quarter."""

ROOMS = ("main", "triangle-8", "classic")


async def soak(server: Served, seconds: float) -> list[float]:
    """Waves of clients of both streams in several rooms; resident memory in bytes along the way."""
    memory = []
    end = time.monotonic() + seconds
    wave = 0
    while time.monotonic() < end:
        loads = [
            Load(room_url(server.address, room, stream), CLIENTS // 4, stream, drops=5.0)
            for stream, room in (
                ("snapshots", ROOMS[wave % 3]),
                ("segments", ROOMS[wave % 3]),
                ("snapshots", ROOMS[(wave + 1) % 3]),
                ("segments", ROOMS[(wave + 2) % 3]),
            )
        ]
        reports = await asyncio.gather(*(load.run(WAVE) for load in loads))
        for report in reports:
            assert report.connected == CLIENTS // 4
            assert report.frames > 0
            assert not report.closed
            assert not report.errors
        memory.append(server.resident)
        wave += 1
    return memory


@pytest.mark.skipif(not can_watch(), reason="memory is read from /proc")
async def test_a_server_in_use_keeps_its_size(tmp_path: Path) -> None:
    with (tmp_path / "log").open("w+") as log, serving(["--drop-rate", "100"], log=log) as server:
        memory = await soak(server, SECONDS)
        for _ in range(100):
            if not server.metrics()["plinko_clients"]:
                break
            await asyncio.sleep(0.1)
        metrics = server.metrics()
        assert metrics["plinko_clients"] == 0
        assert metrics["plinko_clients_too_slow_total"] == 0
        assert metrics["plinko_drops_total"] > len(memory) * WAVE
        log.seek(0)
        assert log.read().replace(COMPILING, "").strip() == ""
    if len(memory) >= 8:
        quarter = len(memory) // 4
        early = statistics.median(memory[quarter : 2 * quarter])
        late = statistics.median(memory[-quarter:])
        assert late - early < GROWTH, [round(size / 1e6, 1) for size in memory]
