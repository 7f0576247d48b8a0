"""The server is killed at random moments under load: nothing that was told is lost or changed."""

import asyncio
import itertools
import os
import random
import signal
from dataclasses import dataclass, field
from statistics import median

import pytest

from engine import Board
from tests.app.persistence.oracle import hold
from tests.app.persistence.server import KILLS, POSTGRESQL, SQLITE, Heard, Served, play, prove
from tests.waiting import eventually

ACKNOWLEDGED = 10  # drops at least, between one kill and the next
ROOMS = {"main": "triangle-16", "triangle-8": "triangle-8", "classic": "classic"}


@dataclass
class Load:
    """Players in several rooms, who come back whenever the server does."""

    server: Served
    chance: random.Random
    rooms: dict[str, Heard] = field(default_factory=lambda: {name: Heard(name) for name in ROOMS})

    @property
    def acknowledged(self) -> int:
        """Drops that the players were told of as accepted."""
        return sum(len(told.accepted) for told in self.rooms.values())

    @property
    def receipts(self) -> int:
        """Staked drops that the players hold a receipt of."""
        return sum(len(each) for told in self.rooms.values() for each in told.receipts.values())

    async def until_killed(self, seconds: float) -> None:
        """Play for a while, until some drops are acknowledged, one of them staked, then kill."""
        enough = self.acknowledged + ACKNOWLEDGED
        receipts = self.receipts
        seeds = itertools.count(self.chance.randrange(1 << 60))
        players = [
            asyncio.create_task(play(self.server, told, seeds, self.chance.uniform(0.01, 0.1)))
            for told in self.rooms.values()
        ]
        await asyncio.sleep(seconds)  # no wait: the moment of the kill, left to chance
        await eventually(lambda: self.acknowledged >= enough and self.receipts > receipts)
        self.server.end(signal.SIGKILL)
        await asyncio.gather(*players)

    @property
    def _awake(self) -> bool:
        return any(room["awake"] for room in self.server.get("/api/v1/rooms")["rooms"])

    async def until_still(self) -> None:
        """Listen, without another drop, until nothing moves in any room."""
        players = [
            asyncio.create_task(play(self.server, told, iter(()), 0.0))
            for told in self.rooms.values()
        ]
        await eventually(lambda: not self._awake)
        for player in players:
            player.cancel()
        await asyncio.gather(*players, return_exceptions=True)


@pytest.mark.parametrize("url", [SQLITE, POSTGRESQL], indirect=True)
@pytest.mark.long("a server under load is killed")
@pytest.mark.timeout(3600)
async def test_no_acknowledged_drop_is_lost_and_no_digest_changes(url: str) -> None:
    seed = int(os.environ.get("PLINKO_TEST_SEED", "1"))
    load = Load(Served(url), random.Random(seed))
    with load.server as server:
        for _ in range(KILLS):
            await load.until_killed(load.chance.uniform(0.05, 3.0))
            await asyncio.to_thread(server.start)
        await load.until_still()
        staked = 0
        for told in load.rooms.values():
            staked += await asyncio.to_thread(prove, server, told)
        assert staked, "no drop was staked"
        assert server.end(signal.SIGTERM) == 0
    for told in load.rooms.values():
        hold(url, told, Board.preset(ROOMS[told.room]), killed=True)
    starts = load.server.starts
    print(  # noqa: T201
        f"{KILLS} kills, {load.acknowledged} acknowledged drops, none lost, no digest changed; "
        f"starts took {median(starts):.1f} s in the median, at most {max(starts):.1f} s"
    )
    assert load.acknowledged >= ACKNOWLEDGED * KILLS
