"""A player of `main` who notes what others' attacks do to it."""

import asyncio
import contextlib
import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

_SETTLES: Final = 1.0  # s after which a room that slept runs
_AROUND: Final = 60  # ticks, of which some came in time
_RATE: Final = 60.0  # ticks a second
_ALIKE: Final = 10  # ticks that came by the same clock, which one alone does not show
_SPREAD: Final = 0.002  # s within which they came


class Player:
    """A player of `main`: when its snapshots come, and how long its drops wait."""

    def __init__(self) -> None:
        self.seen: list[tuple[int, float]] = []  # ticks, and when they came
        self.accepted: list[float] = []
        self.refused = 0
        self.asked: dict[str, float] = {}
        self._settled = math.inf  # from when on the room has not slept

    def event(self, client: Any, event: dict[str, Any], now: float) -> None:
        """Take an event: an acceptance ends a wait."""
        if event["type"] == "accepted" and event.get("ref") in self.asked:
            self.accepted.append(now - self.asked.pop(event["ref"]))
        elif event["type"] == "error":
            self.refused += 1

    def binary(self, client: Any, data: bytes, now: float) -> None:
        """Take a snapshot."""
        if now > self._settled:
            self.seen.append((int.from_bytes(data[4:8], "little"), now))

    def closed(self, client: Any, code: int, reason: str) -> None:
        """Nothing: what does not come is missed."""

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
    """By how many s each tick of a room that does not sleep came late; ticks with their times.

    The least late of all came in time, unless it is alone with that. Ticks that the server gave up
    are missing from its rate, and those that follow are not late for it: how many it gave up, the
    least late of the second before a tick shows, or of the second after.
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
    """When tick 0 was due, by when each tick says that it was.

    A late tick followed by one that was given up has all others later by less than a tick: they
    are by whole ones, and it is that one tick which came late.
    """
    ordered = sorted(begins)
    least = ordered[0] if ordered else 0.0
    alike = (a for a, b in zip(ordered, ordered[_ALIKE:], strict=False) if b - a <= _SPREAD)
    ticks = (next(alike, least) - least) * rate
    return least if ticks < 0.5 else least + (ticks - math.ceil(ticks)) / rate


@dataclass(frozen=True)
class Seen:
    """What a player noted: by how many s each snapshot came late, how long each drop waited."""

    late: list[float]
    accepted: list[float]
    refused: int


def play(address: str, seconds: float) -> Seen:
    """Play on the server for so long, in a process that waits for no other where that is allowed.

    What is noted is when a snapshot came, not when there was a processor to note it.
    """
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    player = Player()
    asyncio.run(player.play(address, seconds))
    return Seen(lateness(player.seen), player.accepted, player.refused)
