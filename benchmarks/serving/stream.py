"""The cost of streaming a room to many clients: processor time, lateness, memory, bytes."""

import asyncio

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.serving import fan_out, idle, stalled, streams, wire
from benchmarks.serving.process import OPTIONS, Served, can_watch, core_for_server, pinned, serving

LATE = 0.004
"""s; a tick that begins this much after it was due is visibly late."""

DROPS = 8.0
"""Balls dropped per second in the watched room; some 50 are then in flight."""


def run(effort: Effort) -> Section:
    section = Section("stream")
    wire.compare(section, effort)
    if not can_watch():
        section.absent.append("the server: processor time and memory are read from /proc")
        return section
    streams.compare(section, effort)
    fan_out.compare(section, effort)
    _crowds(section, effort)
    _memory(section, effort)
    stalled.watch(section, effort)
    idle.server(section, effort)
    return section


def _crowds(section: Section, effort: Effort) -> None:
    """Rising numbers of clients in a room at 60 Hz: lateness, frames, processor time."""
    rows = []
    data = {}
    for clients in (100, 400, 800) if not effort.quick else (10,):
        effort.step(f"{clients} clients")
        found = _crowd(clients, effort)
        name = f"{clients:,}"
        data[name] = found
        rows.append([
            name,
            f"{found['fps']:.1f}",
            f"{1e3 * found['late_p99']:.2f}",
            f"{found['in_time']:.2%}",
            f"{1e3 * found['latency_p50']:.2f}",
            f"{1e3 * found['latency_p99']:.2f}",
            f"{found['missed']:,.0f}",
            f"{found['core']:.0%}",
        ])  # fmt: skip
    section.data["crowds"] = data
    section.tables.append(
        Table(
            "One room at 60 Hz, some 50 balls in flight",
            ["clients", "least fps", "late p99, ms", "ticks within 4 ms", "latency p50, ms",
             "latency p99, ms", "frames missed", "of a core"],
            rows,
            [
                "Late: from when a tick was due until it began, by the server's own histogram. "
                "Latency: until a client has read the frame, clients and server on the same "
                "machine, the server on a core of its own. Aim: 400 clients with 99 % of the "
                "ticks within 4 ms; 800 as the goal."
            ],
        )
    )  # fmt: skip


def _crowd(clients: int, effort: Effort) -> dict[str, float]:
    from benchmarks.load.client import room_url
    from benchmarks.load.generator import Load, run

    seconds = float(effort.size(10, 1))
    with serving(OPTIONS) as server:
        pinned(server.process, core_for_server())
        watch = Window(server)
        load = Load(room_url(server.address, "main", "snapshots"), clients, drops=DROPS)
        load.on_count = watch.begin
        report = run(load, seconds)
        watch.end()
    late = watch.lateness()
    return {
        "fps": min(report.fps),
        "late_p99": quantile(late, 0.99),
        "in_time": share_within(late, LATE),
        "latency_p50": report.latency(0.5),
        "latency_p99": report.latency(0.99),
        "missed": report.missed,
        "core": watch.cpu / report.seconds,
    }


class Window:
    """A server's processor time and metrics between `begin` and `end`."""

    def __init__(self, server: Served) -> None:
        self.server = server
        self.cpu = 0.0
        self._before: dict[str, float] = {}
        self._after: dict[str, float] = {}

    def begin(self) -> None:
        self._before = self.server.metrics()
        self.cpu = -self.server.cpu

    def end(self) -> None:
        self.cpu += self.server.cpu
        self._after = self.server.metrics()

    def lateness(self) -> list[tuple[float, float]]:
        """The upper bound in s and the cumulative number of ticks of each bucket."""
        name = "plinko_tick_lateness_seconds_bucket"
        buckets = [key for key in self._after if key.startswith(name)]
        pairs = [
            (float(key.split('"')[1]), self._after[key] - self._before.get(key, 0.0))
            for key in buckets
        ]
        return sorted(pairs)


def share_within(buckets: list[tuple[float, float]], bound: float) -> float:
    """Share of the ticks with a lateness up to `bound`, which is a bucket's bound."""
    total = buckets[-1][1]
    return max((n for b, n in buckets if b <= bound), default=0.0) / total if total else 0.0


def quantile(buckets: list[tuple[float, float]], share: float) -> float:
    """The lateness that this share of the ticks did not exceed, interpolated in a bucket."""
    wanted = share * buckets[-1][1]
    low = below = 0.0
    for bound, count in buckets:
        if count >= wanted and count > below:
            return low + (bound - low) * (wanted - below) / (count - below)
        low, below = bound, count
    return low


def _memory(section: Section, effort: Effort) -> None:
    """Resident memory with the physics compiled, and the memory that each client adds."""
    clients = effort.size(400, 10)
    effort.step("memory")
    with serving(OPTIONS) as server:
        alone = server.resident
        with_clients = asyncio.run(_with_clients(server, clients, 2.0))
    each = (with_clients - alone) / clients
    section.data["memory"] = {"alone": alone, "clients": clients, "each": each}
    section.tables.append(
        Table(
            "Resident memory",
            ["what", "bytes"],
            [
                ["the server, physics loaded, ready", f"{alone:,.0f}"],
                [f"each of {clients:,} clients who watch 50 balls", f"{each:,.0f}"],
            ],
            ["Aim: at most 300 MB, and 64 KB a client."],
        )
    )


async def _with_clients(server: Served, clients: int, seconds: float) -> float:
    """Resident memory in bytes while `clients` clients watch balls fall."""
    from benchmarks.load.client import room_url
    from benchmarks.load.generator import Load

    load = Load(room_url(server.address, "main", "snapshots"), clients, drops=DROPS)
    task = asyncio.create_task(load.run(seconds))
    while not load.counting and not task.done():
        await asyncio.sleep(0.05)
    await asyncio.sleep(0.8 * seconds)
    resident = server.resident
    await task
    return resident
