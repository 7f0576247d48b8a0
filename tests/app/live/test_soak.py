"""The memory of a server does not grow while players come and go for a long time.

`make test-long` runs it for ten minutes and prints the growth.
"""

import asyncio
import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks.load.client import room_url
from benchmarks.load.generator import Load
from benchmarks.serving.process import Served, can_watch, serving
from tests.kit.waiting import eventually

SECONDS = 600.0
WAVE = 4.0  # s; then all clients leave and others join
CLIENTS = 20
CREEP = 1e5
"""Bytes a minute that memory may grow by in the second half of the time.

The players drop some 1,100 balls a minute and connect 260 times: a leak of a hundred bytes a ball,
or of four hundred a connection, would exceed it. The first half is left out because caches fill
then: the database's pages, the workers' memory, the events kept for clients that reconnect.
"""

ROOMS = ("main", "triangle-8", "classic")


async def soak(server: Served, seconds: float) -> list[tuple[float, float]]:
    """Run waves of clients in several rooms; returns samples of time in s and resident bytes.

    In each wave one room has clients of both streams, one of snapshots only, one of paths only.
    """
    memory = []
    end = time.monotonic() + seconds
    wave = 0
    while time.monotonic() < end:
        loads = [
            Load(room_url(server.address, room, stream), CLIENTS // 4, stream, drops=5.0)
            for stream, room in (
                ("snapshots", ROOMS[wave % 3]),
                ("paths", ROOMS[wave % 3]),
                ("snapshots", ROOMS[(wave + 1) % 3]),
                ("paths", ROOMS[(wave + 2) % 3]),
            )
        ]
        reports = await asyncio.gather(*(load.run(WAVE) for load in loads))
        for report in reports:
            assert report.connected == CLIENTS // 4
            assert report.frames > 0
            assert not report.closed
            assert not report.errors
        memory.append((time.monotonic(), server.resident))
        wave += 1
    return memory


def creep(memory: list[tuple[float, float]]) -> float:
    """The growth of the second half of the samples, bytes a minute.

    It is the median of the slopes between all pairs (Theil-Sen), robust against outliers.
    """
    times, sizes = np.array(memory[len(memory) // 2 :]).T
    one, two = np.triu_indices(len(times), 1)
    return 60.0 * float(np.median((sizes[two] - sizes[one]) / (times[two] - times[one])))


@pytest.mark.long("players come and go for ten minutes")
@pytest.mark.timeout(3 * SECONDS + 600.0)
@pytest.mark.skipif(not can_watch(), reason="memory is read from /proc")
async def test_a_server_in_use_keeps_its_size(tmp_path: Path) -> None:
    # On disk, as in production: a ledger in memory grows with every drop.
    ledger = f"sqlite:///{tmp_path / 'plinko.db'}"
    options = ["--drop-rate", "100", "--database-url", ledger]
    with (tmp_path / "log").open("w+") as log, serving(options, log=log) as server:
        memory = await soak(server, SECONDS)
        await eventually(lambda: not server.metrics()["plinko_clients"])
        metrics = server.metrics()
        assert metrics["plinko_clients_too_slow_total"] == 0
        assert metrics["plinko_drops_total"] > len(memory) * WAVE
        log.seek(0)
        assert log.read().strip() == ""
    slope = creep(memory)
    sizes = [round(size / 1e6, 1) for _, size in memory]
    verdict = "flat" if slope < CREEP else "growing"
    print(  # noqa: T201 - the verdict
        f"\nmemory is {verdict}: {slope / 1e3:+.0f} kB a minute in the second half of "
        f"{SECONDS:.0f} s, less than {CREEP / 1e3:.0f} allowed; {sizes[0]} MB at first, "
        f"{sizes[-1]} MB at last"
    )
    assert slope < CREEP, sizes
