"""Thousands of spectators of one room over relays: the cost of a spectator to each process."""

import asyncio
import contextlib
import math
from dataclasses import dataclass
from typing import Final

from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table
from benchmarks.load.client import room_url
from benchmarks.load.generator import Load
from benchmarks.serving.process import OPTIONS, Served, can_watch, processor_time, serving, started
from benchmarks.serving.streams import FALL, IN_FLIGHT
from plinko.app.protocol.messages import SEEDS

RELAYS: Final = 3
CROWDS: Final = (1000, 5000)
"""Spectators in two crowds; the difference in cost is the cost of the additional spectators."""

SPECTATORS: Final = 1_000_000

_ENOUGH: Final = 0.8
"""Least ratio of a spectator's messages in the large crowd to those in the small one. Below it, the
room itself was slow, and the measurement is not valid."""

_OWN_FILES: Final = 200  # files that a process opens in addition to its connections

SHARES: Final = f"One room, watched by seeds over {RELAYS} relays"
COST: Final = "What one spectator more costs"
SERVED: Final = "spectators that a core of relays serves"


@dataclass(frozen=True)
class Shares:
    """Measurements while `spectators` watched.

    server, redis, relays: shares of a core. messages, bytes: per second of one spectator. least,
    most: smallest and largest number of messages of a spectator. memory: resident bytes of all
    relays.
    """

    spectators: int
    server: float
    redis: float
    relays: float
    messages: float
    bytes: float
    least: int
    most: int
    memory: float


def run(effort: Effort) -> Section:
    """Measure both crowds on the same processes."""
    section = Section("relays")
    from tests.kit import redis

    if not can_watch():
        section.absent.append("relays: processor time is read from /proc, as on Linux")
        return section
    if redis.PROGRAM is None:
        section.absent.append(f"relays: {redis.MISSING}")
        return section
    small, large = CROWDS if not effort.quick else (6, 12)
    check_files(large)
    seconds = 10.0 if not effort.quick else 1.0
    with contextlib.ExitStack() as stack:
        bus = stack.enter_context(redis.Redis())
        server = stack.enter_context(serving([*OPTIONS, "--relays", bus.url]))
        arguments = ["relay", bus.url, server.address, "--port", "0", "--max-clients", "5000"]
        relays = [stack.enter_context(started(arguments, "/healthz")) for _ in range(RELAYS)]
        watched = (server, bus.running.pid, relays)
        found = []
        for crowd in (small, large):
            effort.step(f"{crowd} spectators")
            found.append(asyncio.run(_crowd(*watched, crowd, seconds)))
    section.data["relays"] = [vars_of(each) for each in found]
    section.tables += [_shares(found), _each(*found)]
    return section


def check_files(spectators: int) -> None:
    """Raise this process's limit of open files as needed; MissingError if it is too low.

    Processes that are started from here inherit the limit. Needs Unix.
    """
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted, endless = spectators + _OWN_FILES, resource.RLIM_INFINITY
    if soft == endless or soft >= wanted:
        return
    if hard != endless and hard < wanted:
        raise MissingError(
            f"{spectators:,} spectators need {wanted:,} open files, and the system allows "
            f"{hard:,}: raise the limit (ulimit -n)"
        )
    resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def vars_of(shares: Shares) -> dict[str, float]:
    return {name: getattr(shares, name) for name in Shares.__dataclass_fields__}


async def _crowd(
    server: Served, redis: int, relays: list[Served], spectators: int, seconds: float
) -> Shares:
    """Let `spectators` watch, evenly over the relays, while a player drops balls at the server."""
    spent: list[list[float]] = []

    def look() -> None:
        spent.append([server.cpu, processor_time(redis), sum(each.cpu for each in relays)])

    player = Load(room_url(server.address, "main", SEEDS), 1, SEEDS, IN_FLIGHT / FALL)
    playing = asyncio.create_task(player.run(math.inf))
    first, *more = (f"{room_url(each.address, 'main', SEEDS)}&watch=true" for each in relays)
    crowd = Load(first, spectators, SEEDS, 0.0, tuple(more), settle=FALL + 1.0)
    crowd.on_count = look
    memory = 0.0

    def end() -> None:
        nonlocal memory
        look()
        memory = sum(each.resident for each in relays)

    crowd.on_counted = end
    report = await crowd.run(seconds)
    playing.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await playing
    if report.connected != spectators or report.closed or report.refused:
        raise AssertionError(
            f"of {spectators} spectators, {report.connected} connected; closed: {report.closed}, "
            f"refused: {report.refused}"
        )
    took = report.seconds
    server_used, redis_used, relays_used = (
        (after - before) / took for before, after in zip(*spent, strict=True)
    )
    texts = [counted.texts for counted in crowd.counted.values()]
    each = took * len(texts)
    return Shares(
        spectators=len(texts),
        server=server_used,
        redis=redis_used,
        relays=relays_used,
        messages=sum(texts) / each,
        bytes=report.bytes / each,
        least=min(texts),
        most=max(texts),
        memory=memory,
    )


def _shares(found: list[Shares]) -> Table:
    return Table(
        SHARES,
        ["spectators", "of a core: the server", "Redis", "all relays", "messages/s a spectator",
         "bytes/s a spectator", "messages, least to most", "all relays' memory"],
        [
            [
                f"{each.spectators:,}",
                f"{each.server:.1%}",
                f"{each.redis:.1%}",
                f"{each.relays:.1%}",
                f"{each.messages:.1f}",
                f"{each.bytes:,.0f}",
                f"{each.least} to {each.most}",
                f"{each.memory / 1e6:,.0f} MB",
            ]
            for each in found
        ],
        [
            f"All on one machine, spectators too. {IN_FLIGHT} balls in flight, dropped by a player "
            "at the server. Processor time; everybody came in and stayed to the end. The first "
            "also pings five times a second, and has the answers for messages."
        ],
    )  # fmt: skip


def _each(small: Shares, large: Shares) -> Table:
    """The cost of each additional spectator to the relays, extrapolated to a million."""
    more = large.spectators - small.spectators
    cost, memory = (large.relays - small.relays) / more, (large.memory - small.memory) / more
    if cost <= 0.0 or large.messages < _ENOUGH * small.messages:
        raise MissingError(
            "the machine is too busy to tell what a spectator costs: one of "
            f"{large.spectators:,} had {large.messages:.1f} messages a second, one of "
            f"{small.spectators:,} {small.messages:.1f}"
        )
    rows = [
        ["of a core for each spectator", f"{cost:.5%}", "measured"],
        [SERVED, f"{1.0 / cost:,.0f}", "measured"],
        ["bytes of a relay's memory for each spectator", f"{memory:,.0f}", "measured"],
        [f"cores for {SPECTATORS:,}", f"{SPECTATORS * cost:,.1f}", "extrapolated"],
        [
            f"bytes a second for {SPECTATORS:,}",
            f"{SPECTATORS * large.bytes / 1e9:,.2f} GB",
            "extrapolated",
        ],
    ]
    return Table(
        COST,
        ["what", "value", "how"],
        rows,
        [
            f"What all relays took more with {large.spectators:,} than with {small.spectators:,}. "
            "The server sends each message once, and Redis once to each relay, whoever watches."
        ],
    )
