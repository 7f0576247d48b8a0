"""The load generator: joins many clients to one room and counts what they receive."""

import asyncio
import contextlib
import time
from array import array
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.load.client import Clock, RefusedError, RoomClient, connect
from plinko.app.protocol import messages
from plinko.engine.json_text import JsonObject

_TOGETHER = 50  # handshakes at a time
_PING = 0.2  # s between the first client's pings, which estimate the server's clock
_GREETING = 30.0  # s within which even a busy server sends its hello


@dataclass(slots=True)
class Counted:
    """Counts of one client."""

    frames: int = 0  # binary messages
    bytes: int = 0  # of binary and text messages
    texts: int = 0
    missed: int = 0  # ticks without a snapshot
    tick: int = -1
    end: tuple[int, str] | None = None


@dataclass(frozen=True, slots=True)
class Report:
    """Figures of all clients. Latencies: from when a tick was due until its frame was read, s."""

    stream: str
    asked: int
    connected: int
    refused: dict[str, int]
    closed: dict[str, int]
    seconds: float
    frames: int
    bytes: int
    texts: int
    fps: list[float]
    latencies: npt.NDArray[np.float64]
    missed: int
    gappy: int
    tick_rate: float
    trip: float
    drops: int
    errors: dict[str, int]

    def behind(self, share: float) -> int:
        """`latency(share)` in whole ticks."""
        return int(self.latency(share) * self.tick_rate)

    def latency(self, share: float) -> float:
        """The latency in s that this share of all frames did not exceed; 0 without frames."""
        return float(np.quantile(self.latencies, share)) if len(self.latencies) else 0.0

    def to_dict(self) -> JsonObject:
        """JSON form, with quantiles instead of the latencies themselves."""
        fps = self.fps or [0.0]
        return {
            "stream": self.stream,
            "clients": self.asked,
            "connected": self.connected,
            "refused": self.refused,
            "closed": self.closed,
            "seconds": self.seconds,
            "frames": self.frames,
            "bytes": self.bytes,
            "texts": self.texts,
            "fps": {"median": float(np.median(fps)), "least": min(fps), "most": max(fps)},
            "latency": {
                name: self.latency(share)
                for name, share in (("p50", 0.5), ("p99", 0.99), ("worst", 1.0))
            },
            "behind": {"p99": self.behind(0.99), "worst": self.behind(1.0)},
            "gaps": {"frames": self.missed, "clients": self.gappy},
            "trip": self.trip,
            "drops": self.drops,
            "errors": self.errors,
        }


@dataclass(slots=True)
class Load:
    """Joins `clients` clients to a room, drops balls from one of them, and counts.

    The clients are spread evenly over the addresses `url` and `more`.
    """

    url: str
    clients: int
    stream: str = messages.SNAPSHOTS
    drops: float = 5.0  # a second
    more: tuple[str, ...] = ()
    settle: float = 0.5  # s between the hello and the start of counting
    wait: Callable[[float], Awaitable[None]] = asyncio.sleep
    on_count: Callable[[], None] = lambda: None  # called when counting begins
    on_counted: Callable[[], None] = lambda: None  # called when counting has ended
    counting: bool = False
    leaving: bool = False
    answered: asyncio.Event = field(
        default_factory=asyncio.Event
    )  # a client got its hello or ended
    counted: dict[RoomClient, Counted] = field(default_factory=dict)
    refused: Counter[str] = field(default_factory=Counter)
    errors: Counter[str] = field(default_factory=Counter)
    latencies: "array[float]" = field(default_factory=lambda: array("d"))
    clock: Clock | None = None
    hello: JsonObject | None = None
    dropped: int = 0

    async def run(self, seconds: float) -> Report:
        """Count for `seconds`; raises RefusedError if no client can join."""
        first, *_ = await self._join()
        chores = [asyncio.create_task(self._ping(first)), asyncio.create_task(self._drop(first))]
        try:
            await self._greeted()
            await self.wait(self.settle)
            self.on_count()
            self.counting, begin = True, time.monotonic()
            self._count_texts(-1)
            await self.wait(seconds)
            self._count_texts(1)
            self.counting, took = False, time.monotonic() - begin
            self.on_counted()
        finally:
            for chore in chores:
                chore.cancel()
            self.leaving = True
            for client in self.counted:
                client.close()
        return self._report(took)

    async def _join(self) -> list[RoomClient]:
        gate = asyncio.Semaphore(_TOGETHER)
        urls = (self.url, *self.more)

        async def join(number: int) -> RoomClient | None:
            async with gate:
                try:
                    # Only the first decodes events, which takes longer than counting them.
                    client = await connect(urls[number % len(urls)], self, events=number == 0)
                except (RefusedError, OSError) as error:
                    self.refused[str(error)] += 1
                    return None
                self.counted.setdefault(client, Counted())
                return client

        joined = await asyncio.gather(*map(join, range(self.clients)))
        found = [client for client in joined if client is not None]
        if not found:
            why = next(iter(self.refused), "no client was asked for")
            raise RefusedError(f"{self.url}: {why}")
        return found

    def _count_texts(self, sign: int) -> None:
        for client, counted in self.counted.items():
            counted.texts += sign * client.texts
            counted.bytes += sign * client.text_bytes

    async def _greeted(self) -> None:
        """Wait for the first hello; raises RefusedError if all clients ended or time is up."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_GREETING):
                while self.hello is None and any(c.end is None for c in self.counted.values()):
                    self.answered.clear()
                    await self.answered.wait()
        if self.hello is None:
            ends = {c.end for c in self.counted.values() if c.end is not None}
            said = "; ".join(sorted(f"{code} {reason}" for code, reason in ends)) or "nothing"
            raise RefusedError(f"{self.url}: no hello; the server said: {said}")

    async def _ping(self, client: RoomClient) -> None:
        while True:
            client.send(type="ping", t=time.monotonic())
            await asyncio.sleep(_PING)

    async def _drop(self, client: RoomClient) -> None:
        """Drop balls at an even rate, the first at once, so that something always moves."""
        while self.drops > 0:
            client.send(type="drop")
            self.dropped += 1
            await asyncio.sleep(1.0 / self.drops)

    def event(self, client: RoomClient, event: dict[str, Any], now: float) -> None:
        """Update the clock, and count the errors that the server sends."""
        kind = event["type"]
        if kind == "hello" and self.hello is None:
            self.hello = event
            self.clock = Clock(event["tick_rate"])
            self.answered.set()
        elif kind == "pong" and self.clock is not None:
            self.clock.observe(event, now)
        elif kind == "error":
            self.errors[event["code"]] += 1

    def binary(self, client: RoomClient, data: bytes, now: float) -> None:
        """Count a snapshot or paths; a snapshot has the tick in bytes 4 to 8."""
        counted = self.counted.setdefault(client, Counted())
        if self.counting:
            counted.frames += 1
            counted.bytes += len(data)
        if self.stream != messages.SNAPSHOTS:
            return
        tick = int.from_bytes(data[4:8], "little")
        before, counted.tick = counted.tick, tick
        if not self.counting:
            return
        if 0 <= before < tick - 1:
            counted.missed += tick - 1 - before
        if self.clock is not None and self.clock.known:
            self.latencies.append(now - self.clock.due(tick))

    def closed(self, client: RoomClient, code: int, reason: str) -> None:
        """Note a client whose connection the server closed."""
        if not self.leaving:
            self.counted.setdefault(client, Counted()).end = (code, reason)
            self.answered.set()

    def _report(self, seconds: float) -> Report:
        counts = list(self.counted.values())
        ends = Counter(f"{c.end[0]} {c.end[1]}".strip() for c in counts if c.end is not None)
        known = self.clock is not None and self.clock.known
        return Report(
            stream=self.stream,
            asked=self.clients,
            connected=len(counts),
            refused=dict(self.refused),
            closed=dict(ends),
            seconds=seconds,
            frames=sum(c.frames for c in counts),
            bytes=sum(c.bytes for c in counts),
            texts=sum(c.texts for c in counts),
            fps=[c.frames / seconds for c in counts],
            latencies=np.maximum(np.frombuffer(self.latencies, np.float64), 0.0)
            if self.latencies
            else np.zeros(0),
            missed=sum(c.missed for c in counts),
            gappy=sum(c.missed > 0 for c in counts),
            tick_rate=self.hello["tick_rate"] if self.hello else 60.0,
            trip=self.clock.trip if known and self.clock is not None else 0.0,
            drops=self.dropped,
            errors=dict(self.errors),
        )


def run(load: Load, seconds: float) -> Report:
    """Run a load in a new event loop, with uvloop if it is installed."""
    with contextlib.suppress(ImportError):
        import uvloop

        return uvloop.run(load.run(seconds))
    return asyncio.run(load.run(seconds))
