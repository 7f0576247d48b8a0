"""A player of `main` who notes what others' attacks do to it."""

import asyncio
import time
from dataclasses import dataclass
from typing import Any, Final

_SETTLES: Final = 1.0  # s after which a room that slept runs, and the player's clock is set


class Player:
    """A player of `main`: when its snapshots come, and how long its drops wait.

    `clock` estimates when each tick was due; see app.load.client.
    """

    def __init__(self, clock: Any) -> None:
        self.late: list[float] = []
        self.accepted: list[float] = []
        self.refused = 0
        self.asked: dict[str, float] = {}
        self._clock = clock
        self._settled = float("inf")  # from when on the room has not slept

    def event(self, client: Any, event: dict[str, Any], now: float) -> None:
        """Take an event: a pong sets the clock, an acceptance ends a wait."""
        if event["type"] == "pong":
            self._clock.observe(event, now)
        elif event["type"] == "accepted" and event.get("ref") in self.asked:
            self.accepted.append(now - self.asked.pop(event["ref"]))
        elif event["type"] == "error":
            self.refused += 1

    def binary(self, client: Any, data: bytes, now: float) -> None:
        """Take a snapshot: it is due when its tick is."""
        tick = int.from_bytes(data[4:8], "little")
        if self._clock.known and now > self._settled:
            self.late.append(now - self._clock.due(tick))

    def closed(self, client: Any, code: int, reason: str) -> None:
        """Nothing: what does not come is missed."""

    async def play(self, address: str, seconds: float) -> None:
        """Drop a ball four times a second, so that the room never sleeps."""
        from app.load.client import connect, room_url

        client = await connect(room_url(address, "main", "snapshots"), self)
        self._settled = time.monotonic() + _SETTLES
        end = self._settled + seconds
        number = 0
        while (now := time.monotonic()) < end:
            client.send(type="ping", t=now)
            self.asked[str(number)] = now
            client.send(type="drop", ref=str(number))
            number += 1
            await asyncio.sleep(0.25)
        client.close()


@dataclass(frozen=True)
class Seen:
    """What a player noted: by how many s each snapshot came late, how long each drop waited."""

    late: list[float]
    accepted: list[float]
    refused: int


def play(address: str, seconds: float) -> Seen:
    """Play on the server for so long."""
    from app.load.client import Clock

    player = Player(Clock(60.0))
    asyncio.run(player.play(address, seconds))
    return Seen(player.late, player.accepted, player.refused)
