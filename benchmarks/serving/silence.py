"""How long rooms send no frames when the machine pauses the server or is busy."""

import asyncio
import contextlib
import itertools
import json
import os
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from functools import partial
from typing import Any, Final

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.serving.process import Served, serving

ROOMS: Final = 7  # `main` and six new rooms, half of which have touching balls
DROPS: Final = 4  # a second in each room
PAUSES: Final = (0.02, 0.05, 1.0)  # s
TIMES: Final = 10
"""Pauses of each length: enough that some of them hit a room's tick, since ticks take some 15 % of
the time."""
BETWEEN: Final = 1.5  # s between two pauses
BUSY: Final = 4  # processes that compute without a pause
SECONDS: Final = 30.0  # with busy processes, and without any disturbance


def run(effort: Effort) -> Section:
    """Watch seven rooms of one server by snapshots, during pauses and next to busy processes."""
    section = Section("silence")
    seconds = float(effort.size(int(SECONDS), 2))
    times = effort.size(TIMES, 2)
    disturbances: dict[str, Callable[[Watch], Awaitable[None]]] = {
        "nothing else": partial(_undisturbed, seconds=seconds),
        **{
            f"{times} pauses of {1e3 * pause:g} ms": partial(_pauses, pause=pause, times=times)
            for pause in PAUSES
        },
        f"{BUSY} busy processes": partial(_beside_busy, seconds=seconds),
    }
    rows = []
    with serving() as server:
        for name, disturb in disturbances.items():
            effort.step(name)
            found = asyncio.run(_watched(server, disturb))
            section.data[name] = found
            rows.append(
                [
                    name,
                    f"{1e3 * found['main']:.0f}",
                    f"{1e3 * found['longest']:.0f}",
                    f"{found['slowest']:.1f}",
                    f"{found['skipped']:.0f}",
                    f"{found['late']:.0f}",
                ]
            )
    section.tables.append(
        Table(
            f"Silence in {ROOMS} rooms of one server",
            ["disturbed by", "longest in `main`, ms", "longest in any room, ms",
             "frames a second of the slowest room", "ticks skipped", "late ticks"],
            rows,
            [
                f"In each room {DROPS} balls a second are dropped, and a client watches every "
                f"frame; in {ROOMS // 2} of the rooms the balls touch. A pause stops the whole "
                "server (SIGSTOP); its own length is no silence, what follows it is. Skipped and "
                "late ticks are what the server itself counts. Clients and busy processes share "
                "the machine with the server. Aim: no silence longer than a second."
            ],
        )
    )  # fmt: skip
    return section


class Watch:
    """The listener of one client per room: the longest time without a frame since `begin`."""

    def __init__(self, server: Served) -> None:
        self.server = server
        self._last: dict[Any, float] = {}
        self._longest: dict[Any, float] = {}
        self._frames: dict[Any, int] = {}
        self._began = 0.0

    def begin(self, clients: list[Any]) -> None:
        """Start counting."""
        self._began = time.monotonic()
        self._last = dict.fromkeys(clients, self._began)
        self._longest = dict.fromkeys(clients, 0.0)
        self._frames = dict.fromkeys(clients, 0)

    def pause(self, seconds: float) -> None:
        """Stop the server for `seconds`; the pause itself does not count as silence."""
        os.kill(self.server.process.pid, signal.SIGSTOP)
        time.sleep(seconds)
        os.kill(self.server.process.pid, signal.SIGCONT)
        now = time.monotonic()
        self._last = dict.fromkeys(self._last, now)

    def found(self) -> tuple[list[float], list[float]]:
        """For each room, the longest silence in s and the frames per second."""
        now = time.monotonic()
        for client in self._last:
            self._note(client, now)
        seconds = now - self._began
        return list(self._longest.values()), [n / seconds for n in self._frames.values()]

    def _note(self, client: Any, now: float) -> None:
        self._longest[client] = max(self._longest[client], now - self._last[client])

    def event(self, client: Any, event: dict[str, Any], now: float) -> None:
        """Do nothing: only frames count."""

    def binary(self, client: Any, data: bytes, now: float) -> None:
        """Count a frame and update the longest silence."""
        if client in self._last:
            self._note(client, now)
            self._last[client] = now
            self._frames[client] += 1

    def closed(self, client: Any, code: int, reason: str) -> None:
        """Do nothing: the room counts as silent from now on."""


async def _watched(server: Served, disturb: Callable[[Watch], Awaitable[None]]) -> dict[str, float]:
    """The silences and rates of all rooms during a disturbance."""
    watch = Watch(server)
    async with _playing(server, watch) as clients:
        await asyncio.sleep(2.0)  # lets the rooms fill with balls
        before = server.metrics()
        watch.begin(clients)
        await disturb(watch)
        longest, rates = watch.found()
        after = server.metrics()
    counted = {
        name: after.get(f"plinko_room_{metric}_total", 0.0)
        - before.get(f"plinko_room_{metric}_total", 0.0)
        for name, metric in {"skipped": "ticks_skipped", "late": "late_ticks"}.items()
    }
    return {"main": longest[0], "longest": max(longest), "slowest": min(rates), **counted}


@contextlib.asynccontextmanager
async def _playing(server: Served, watch: Watch) -> AsyncIterator[list[Any]]:
    """Connect a client to each room that drops balls all the time; the first is in `main`."""
    from benchmarks.load.client import connect, room_url

    names = ["main"]
    names += [_room(server, ("interacting", "independent")[n % 2]) for n in range(ROOMS - 1)]
    clients = [
        await connect(room_url(server.address, name, "snapshots"), watch, events=False)
        for name in names
    ]
    playing = [asyncio.create_task(_play(client)) for client in clients]
    try:
        yield clients
    finally:
        for task, client in zip(playing, clients, strict=True):
            task.cancel()
            client.close()
        await asyncio.gather(*playing, return_exceptions=True)


async def _play(client: Any) -> None:
    for seed in itertools.count():
        client.send(type="drop", seed=seed)
        await asyncio.sleep(1.0 / DROPS)


def _room(server: Served, mode: str) -> str:
    """Open a room on a board of sixteen rows; returns its id."""
    request = urllib.request.Request(
        f"{server.address}/api/v1/rooms",
        json.dumps({"board": "triangle-16", "mode": mode}).encode(),
        {"content-type": "application/json"},
    )
    with urllib.request.urlopen(request, timeout=30.0) as answer:
        room: str = json.load(answer)["id"]
    return room


async def _undisturbed(watch: Watch, seconds: float) -> None:
    await asyncio.sleep(seconds)


async def _pauses(watch: Watch, pause: float, times: int) -> None:
    for number in range(times):
        await asyncio.sleep(BETWEEN + 0.0037 * number)  # each time at another phase of a tick
        watch.pause(pause)
    await asyncio.sleep(BETWEEN)


async def _beside_busy(watch: Watch, seconds: float) -> None:
    with _busy(BUSY):
        await asyncio.sleep(seconds)


@contextlib.contextmanager
def _busy(count: int) -> Iterator[None]:
    """Run processes that compute without end, each in its own session, like other programs.

    The session matters because Linux shares the cores first among sessions
    (`sched_autogroup_enabled`).
    """
    command = [sys.executable, "-c", "while True: pass"]
    processes = [subprocess.Popen(command, start_new_session=True) for _ in range(count)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()
