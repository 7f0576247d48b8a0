"""The worst valid requests of every kind from one address, and what the others notice of it."""

import asyncio
import multiprocessing
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, wait
from typing import Any, Final

from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table
from benchmarks.serving.attackers import KINDS, LOGGED, Attack, hall
from benchmarks.serving.player import Player, play
from benchmarks.serving.process import Served, can_watch, memory, serving

SECONDS: Final = 10.0  # that an attack of one kind lasts
LATE: Final = 0.004  # s; a tick that comes later than this is a late one
_UNBOUND: Final = ("--drop-rate", "100000", "--message-rate", "100000")
"""So that a room gets a long log soon; the attacks have nothing of it that computes."""


def run(effort: Effort) -> Section:
    """One attack after the other on a server with its own limits, then all of them together."""
    if not can_watch():
        raise MissingError("the system does not tell the memory of processes")
    section = Section("attack")
    seconds = float(effort.size(int(SECONDS), 2))
    rows = []
    refusals: dict[str, str] = {}
    with serving(_UNBOUND) as server:
        logged = _room_with_log(server, effort.size(LOGGED, 50))
        kinds = [*KINDS.items(), ("all of these at once", _all)]
        for number, (name, kind) in enumerate(kinds, 2):
            effort.step(name)
            attack = Attack(server, f"127.0.0.{number}", logged)
            found = _suffer(server, attack, kind(attack), seconds)
            section.data[name] = found
            refusals |= found["prices"]
            rows.append(_row(name, found))
    section.tables.append(_table(rows, seconds))
    section.tables.append(
        Table(
            "What was refused for its price",
            ["request", "why"],
            [[path, why] for path, why in refusals.items()],
        )
    )
    return section


def _all(attack: Attack) -> "list[Callable[[int], None]]":
    return [act for kind in KINDS.values() for act in kind(attack)[:4]]


def _room_with_log(server: Served, drops: int) -> str:
    """A room with so many drops in its log: their balls land at once."""
    fast = {**hall(), "name": "fast", "walls": hall()["walls"][:2]}
    room: str = Attack(server).must("/api/v1/rooms", {"board": fast})["id"]

    async def fill() -> None:
        from app.load.client import Clock, connect, room_url

        player = Player(Clock(60.0))
        client = await connect(room_url(server.address, room, "snapshots"), player)
        for number in range(drops):
            while number - len(player.accepted) > 20:
                await asyncio.sleep(0.002)
            player.asked[str(number)] = time.monotonic()
            client.send(type="drop", seed=number, ref=str(number))
        client.close()

    asyncio.run(fill())
    return room


def _suffer(
    server: Served, attack: Attack, acts: "list[Callable[[int], None]]", seconds: float
) -> dict[str, Any]:
    most = 0.0
    # In a process of its own: else it would wait for the attackers' Python, not for the server.
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, spawn) as own, attack.going_on(acts):
        playing = own.submit(play, server.address, seconds)
        while not playing.done():
            most = max(most, memory(server.process.pid))
            wait([playing], 0.5)
        seen = playing.result()
    late, waits = sorted(seen.late), sorted(seen.accepted)
    return {
        "ticks_per_second": len(late) / seconds,
        "within_4_ms": sum(each <= LATE for each in late) / max(len(late), 1),
        "late_99": late[int(0.99 * len(late))] if late else float("nan"),
        "accepted_99": waits[int(0.99 * len(waits))] if waits else float("nan"),
        "refused": seen.refused,
        "memory": most,
        "answers": dict(attack.answers),
        "prices": dict(attack.prices),
    }


def _row(name: str, found: dict[str, Any]) -> list[str]:
    answers = ", ".join(f"{count} x {code}" for code, count in sorted(found["answers"].items()))
    return [
        name,
        f"{found['ticks_per_second']:.1f}",
        f"{100 * found['within_4_ms']:.1f} %",
        f"{1e3 * found['late_99']:.1f}",
        f"{1e3 * found['accepted_99']:.0f}",
        f"{found['memory'] / 1e6:,.0f}",
        answers or "-",
    ]


def _table(rows: list[list[str]], seconds: float) -> Table:
    return Table(
        "`main` while one address sends the worst valid requests",
        ["attack", "ticks a second", "within 4 ms", "99 % within, ms",
         "drops accepted (99 %), ms", "memory, MB", "answers"],
        rows,
        [
            f"For {seconds:g} s each, on a server with its default limits; a player of `main` "
            "drops four balls a second and notes when each snapshot comes after its tick was due. "
            "The attackers and the player share the machine with the server. Memory: of the "
            "server and its workers, what they share counted once. Aims: 60 ticks a second, 99 % "
            "of them within 4 ms, drops accepted in 50 ms, less than 600 MB."
        ],
    )  # fmt: skip
