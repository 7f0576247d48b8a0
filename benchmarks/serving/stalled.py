"""What one client that stops reading costs the other clients, when frames are large."""

import asyncio
import json
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.serving.process import OPTIONS, Served, core_for_server, pinned, serving
from plinko.engine import Board

CLIENTS = 20
GRAVITY = 0.2
"""m/s^2: so low that thousands of balls stay in flight during the measurement."""


def watch(section: Section, effort: Effort) -> None:
    """Send frames of 40 KB to twenty clients, one of which stops reading."""

    balls = effort.size(3400, 50)
    seconds = float(effort.size(10, 1))
    effort.step("stalled client")
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "slow.json"
        path.write_text(json.dumps(_slow_board()))
        limits = ("--max-balls", str(balls))
        with serving([*OPTIONS, *limits, "--board", str(path)]) as server:
            pinned(server.process, core_for_server())
            found = asyncio.run(_Watch(server, balls).run(seconds))
    section.data["stalled"] = found
    section.tables.append(
        Table(
            f"One of {CLIENTS} clients stops reading frames of {found['frame']:,.0f} bytes",
            ["least fps before", "after", "longest gap, ms", "closed after, s", "memory grew by"],
            [[
                f"{found['fps_before']:.1f}",
                f"{found['fps_after']:.1f}",
                f"{1e3 * found['gap']:.0f}",
                f"{found['closed_after']:.1f}",
                f"{found['grew'] / 1e6:+.1f} MB",
            ]],
            [
                f"The other {CLIENTS - 1}, over {seconds:.0f} s each before and after it stops. "
                "The server closes it once it has read nothing for its grace of 5 s; 0: it was "
                "not closed while this looked. Aim: 60 fps throughout, memory flat."
            ],
        )
    )  # fmt: skip


def _slow_board() -> dict[str, Any]:
    """A board with little gravity, on which balls fall slowly."""
    form: dict[str, Any] = Board.preset("triangle-8").to_dict()
    return {**form, "name": "slow", "gravity": GRAVITY, "drag": 0.0}


@dataclass(slots=True)
class _Watch:
    """The listener of all clients: what each received since counting began."""

    server: Served
    balls: int
    clients: list[Any] = field(default_factory=list)
    counts: dict[Any, int] = field(default_factory=dict)
    seen: dict[Any, float] = field(default_factory=dict)
    gap: float = 0.0
    size: int = 0
    accepted: int = 0

    async def run(self, seconds: float) -> dict[str, float]:
        """Fill the room, count, stall one client, count again."""
        from benchmarks.load.client import connect, room_url

        url = room_url(self.server.address, "main", "snapshots")
        self.clients = [await connect(url, self, events=not n) for n in range(CLIENTS)]
        for seed in range(self.balls):
            self.clients[0].send(type="drop", seed=seed)
            if seed % 50 == 49:
                await asyncio.sleep(0.02)
        while self.accepted < self.balls:
            await asyncio.sleep(0.05)
        before = await self._count(seconds)
        resident = self.server.resident
        self.clients[-1].stall()
        slow = asyncio.create_task(self._until_closed())
        self.clients.pop()
        self.gap = 0.0
        after = await self._count(seconds)
        grew = self.server.resident - resident
        closed_after = slow.result() if slow.done() else 0.0
        slow.cancel()
        for client in self.clients:
            client.close()
        return {
            "frame": self.size,
            "fps_before": before,
            "fps_after": after,
            "gap": self.gap,
            "closed_after": closed_after,
            "grew": grew,
        }

    async def _count(self, seconds: float) -> float:
        """Count for `seconds`; returns the lowest fps of the clients."""
        self.counts = dict.fromkeys(self.clients, 0)
        self.seen = dict.fromkeys(self.clients, time.monotonic())
        begin = time.monotonic()
        await asyncio.sleep(seconds)
        return min(self.counts.values()) / (time.monotonic() - begin)

    async def _until_closed(self) -> float:
        """Seconds until the server closed a client that was too slow."""
        begin = time.monotonic()
        while not self.server.metrics()["plinko_clients_too_slow_total"]:
            await asyncio.sleep(0.2)
        return time.monotonic() - begin

    def event(self, client: Any, event: dict[str, Any], now: float) -> None:
        """Count the acceptances sent to the first client."""
        if event["type"] == "accepted" and self.clients and client is self.clients[0]:
            self.accepted += 1

    def binary(self, client: Any, data: bytes, now: float) -> None:
        """Count a frame and update the longest gap."""
        self.size = max(self.size, len(data))
        if client in self.counts:
            self.counts[client] += 1
            self.gap = max(self.gap, now - self.seen[client])
            self.seen[client] = now

    def closed(self, client: Any, code: int, reason: str) -> None:
        """Do nothing: the server's metric reports the end."""
