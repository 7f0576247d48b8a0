"""The server's processor time per frame delivered, compared with a bare loop of sends."""

import asyncio
import contextlib
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from benchmarks.harness.clock import Job, in_turns
from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table, spread
from benchmarks.serving.process import OPTIONS, Served, core_for_server, pinned, serving

BALLS = 50
HZ = 60.0
SETTLE = 0.3
"""s between the last acceptance and the start of counting."""

SERVER = "the server"
BARE = "send(2) in a C loop"


def compare(section: Section, effort: Effort) -> None:
    """Measure the server and the bare loop in turns."""
    clients = effort.size(400, 10)
    window = 3.0 if not effort.quick else 0.5
    core = core_for_server()
    with contextlib.ExitStack() as stack:
        loop = stack.enter_context(contextlib.closing(asyncio.new_event_loop()))
        server = stack.enter_context(serving(OPTIONS))
        pinned(server.process, core)
        crowd = _Crowd(server, loop, window)
        loop.run_until_complete(crowd.join(clients))
        bare = stack.enter_context(_bare(clients))
        pinned(bare.process, core)
        loop.run_until_complete(_connect(bare, clients))
        crowd.measure()  # finds the size of the messages that the bare loop has to send
        jobs: dict[str, Job] = {
            SERVER: crowd.measure,
            BARE: lambda: loop.run_until_complete(_send(bare, crowd.size, window)),
        }
        times = in_turns(jobs, effort.rounds, lambda: effort.step("fan-out"))
        loop.run_until_complete(_leave(crowd))
    base = times[BARE]
    section.data["fan_out"] = {name: sample.to_dict() for name, sample in times.items()}
    section.tables.append(
        Table(
            f"Processor time for a frame delivered to one of {clients:,} clients",
            ["who", "µs a frame", "to the bare loop"],
            [
                [name, spread(sample, "{:.2f}"), spread(sample.over(base), "{:.2f}")]
                for name, sample in times.items()
            ],
            [
                f"A frame is all that a client gets in a tick: the snapshot of {BALLS} balls and "
                f"the events before it, {crowd.size:,} bytes on average, {HZ:.0f} times a "
                "second. The server's time includes physics, encoding and everything else it does; "
                "the bare loop sends as many bytes as often and does nothing else. Both run on the "
                "same core in turns, the clients on another. Aim: at most 2.2."
            ],
        )
    )


@dataclass(slots=True)
class _Crowd:
    """The clients of one server."""

    server: Served
    loop: asyncio.AbstractEventLoop
    window: float  # s
    size: int = 1  # bytes a client gets in a tick
    pictures: int = 0
    balls: int = 0  # in flight, by the events of the first client
    clients: list[Any] = field(default_factory=list)

    async def join(self, count: int) -> None:
        from benchmarks.load.client import connect, room_url

        url = room_url(self.server.address, "main", "snapshots")
        for number in range(count):
            self.clients.append(await connect(url, self, events=number == 0))

    def measure(self) -> float:
        """µs of the server's processor time per frame delivered."""
        return self.loop.run_until_complete(self._measure())

    async def _measure(self) -> float:
        for seed in range(BALLS):
            self.clients[0].send(type="drop", seed=seed)
        while self.balls < BALLS:
            await asyncio.sleep(0.01)
        await asyncio.sleep(SETTLE)
        sent = self.server.metrics()["plinko_sent_bytes_total"]
        cpu, pictures = self.server.cpu, self.pictures
        await asyncio.sleep(self.window)
        cpu, pictures = self.server.cpu - cpu, self.pictures - pictures
        if not pictures:
            raise MissingError("the server delivered no frame")
        sent = self.server.metrics()["plinko_sent_bytes_total"] - sent
        self.size = round(sent / pictures)
        while self.balls:
            await asyncio.sleep(0.05)
        return cpu * 1e6 / pictures

    def event(self, client: Any, event: dict[str, Any], now: float) -> None:
        """Count the balls in flight."""
        if self.clients and client is self.clients[0]:
            self.balls += (event["type"] == "accepted") - (event["type"] == "landed")

    def binary(self, client: Any, data: bytes, now: float) -> None:
        """Count a frame."""
        self.pictures += 1

    def closed(self, client: Any, code: int, reason: str) -> None:
        """Do nothing: missing frames show in the count."""


async def _leave(crowd: _Crowd) -> None:
    for client in crowd.clients:
        client.close()
    await asyncio.sleep(0.1)


@contextlib.contextmanager
def _bare(clients: int) -> Iterator[Served]:
    """The bare sender's process and address."""
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.serving.bare", str(clients)],
        cwd=Path(__file__).parents[2],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        yield Served(process, process.stdout.readline().split()[-1])
    finally:
        assert process.stdin is not None
        process.stdin.close()  # ends the process
        process.wait()
        process.stdout.close()


class _Drain(asyncio.Protocol):
    """Reads and discards."""


async def _connect(bare: Served, clients: int) -> None:
    host, _, port = bare.address.rpartition(":")
    for _ in range(clients):
        await asyncio.get_running_loop().create_connection(_Drain, host, int(port))


async def _send(bare: Served, size: int, window: float) -> float:
    """µs of the bare sender's processor time per send."""
    stdin, stdout = cast(Any, bare.process.stdin), cast(Any, bare.process.stdout)
    cpu = bare.cpu
    stdin.write(f"{size} {HZ} {window}\n")
    stdin.flush()
    line = await asyncio.to_thread(stdout.readline)
    return (bare.cpu - cpu) * 1e6 / int(line)
