"""The player whose experience is measured: when snapshots arrive, and how long drops wait."""

import asyncio
import contextlib
import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

_SETTLES: Final = 1.0  # s until a room that slept runs
_AROUND: Final = 60  # ticks, of which at least one is taken to be in time
_RATE: Final = 60.0  # ticks a second
_ALIKE: Final = 10  # ticks that must agree on when tick 0 was due
_SPREAD: Final = 0.002  # s within which they must agree


class Player:
    """A player of `main` that records when snapshots arrive and how long its drops wait."""

    def __init__(self) -> None:
        self.seen: list[tuple[int, float]] = []  # tick, and time of its snapshot's arrival
        self.accepted: list[float] = []
        self.refused = 0
        self.asked: dict[str, float] = {}
        self._settled = math.inf  # time from which the room is surely awake

    def event(self, client: Any, event: dict[str, Any], now: float) -> None:
        """Note how long an accepted drop waited; count errors."""
        if event["type"] == "accepted" and event.get("ref") in self.asked:
            self.accepted.append(now - self.asked.pop(event["ref"]))
        elif event["type"] == "error":
            self.refused += 1

    def binary(self, client: Any, data: bytes, now: float) -> None:
        """Note a snapshot's tick and arrival."""
        if now > self._settled:
            self.seen.append((int.from_bytes(data[4:8], "little"), now))

    def closed(self, client: Any, code: int, reason: str) -> None:
        """Do nothing: missing snapshots show in the figures."""

    async def play(self, address: str, seconds: float) -> None:
        """Drop a ball four times a second, so that the room never sleeps."""
        from benchmarks.load.client import connect, room_url

        client = await connect(room_url(address, "main", "snapshots"), self)
        self._settled = time.monotonic() + _SETTLES
        end = self._settled + seconds
        number = 0
        while (now := time.monotonic()) < end:
            self.asked[str(number)] = now
            client.send(type="drop", ref=str(number))
            number += 1
            await asyncio.sleep(0.25)
        client.close()


def lateness(seen: Sequence[tuple[int, float]], rate: float = _RATE) -> list[float]:
    """The lateness in s of each tick, from ticks and arrival times of a room that never sleeps.

    The least late tick is taken to be in time, unless no other tick agrees with it. If the server
    skips ticks, all later ticks move by whole ticks. They are not late because of that: the least
    late tick of the second before or after a tick shows how many ticks were skipped by then.
    """
    begins = [at - tick / rate for tick, at in seen]
    first = _begin(begins, rate)
    late = []
    for number, begin in enumerate(begins):
        before = max(number + 1 - _AROUND, 0)
        after = max(min(number, len(begins) - _AROUND), 0)
        least = max(min(begins[start : start + _AROUND]) for start in (before, after))
        given_up = math.floor((least - first) * rate + 0.1)
        late.append(begin - first - given_up / rate)
    return late


def _begin(begins: Sequence[float], rate: float) -> float:
    """The time at which tick 0 was due, from the estimate of each tick.

    If the first ticks were late and the server then skipped one, all later estimates are larger by
    less than a tick. Ticks are skipped as a whole, so it is the few early estimates that are wrong:
    the result is the value on which many ticks agree, less whole ticks.
    """
    ordered = sorted(begins)
    least = ordered[0] if ordered else 0.0
    alike = (a for a, b in zip(ordered, ordered[_ALIKE:], strict=False) if b - a <= _SPREAD)
    ticks = (next(alike, least) - least) * rate
    return least if ticks < 0.5 else least + (ticks - math.ceil(ticks)) / rate


@dataclass(frozen=True)
class Seen:
    """A player's records: lateness of each snapshot and waiting time of each drop, in s."""

    late: list[float]
    accepted: list[float]
    refused: int


def play(address: str, seconds: float) -> Seen:
    """Play on the server for `seconds`, with real-time priority if the system allows it.

    The priority makes sure that the player records when a snapshot arrived, and not when a
    processor became free to record it.
    """
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    player = Player()
    asyncio.run(player.play(address, seconds))
    return Seen(lateness(player.seen), player.accepted, player.refused)
