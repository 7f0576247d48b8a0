"""Kills at random moments under load lose and change nothing that clients received."""

import asyncio
import os
import random
import signal
from dataclasses import dataclass
from statistics import median

import pytest

from plinko.engine import Board
from tests.app.persistence.conftest import KILLS, POSTGRESQL, SQLITE
from tests.kit.process import ServerProcess
from tests.kit.siege import Siege, prove
from tests.kit.waiting import eventually

ACKNOWLEDGED = 10  # drops at least, between two kills
ROOMS = {"main": "triangle-16", "triangle-8": "triangle-8", "classic": "classic"}


@dataclass(kw_only=True)
class Load(Siege):
    """Players in several rooms, which reconnect after each restart."""

    server: ServerProcess
    pauses: tuple[float, float] = (0.01, 0.1)

    def somewhere(self) -> ServerProcess:
        return self.server

    @property
    def receipts(self) -> int:
        """The number of receipts that the players received."""
        return sum(len(each) for told in self.rooms.values() for each in told.receipts.values())

    async def until_killed(self, seconds: float) -> None:
        """Wait, also for some acknowledged drops, one of them staked, and kill the server."""
        enough = self.acknowledged + ACKNOWLEDGED
        receipts = self.receipts
        await asyncio.sleep(seconds)  # no wait: a random moment
        await eventually(lambda: self.acknowledged >= enough and self.receipts > receipts)
        self.server.end(signal.SIGKILL)


@pytest.mark.parametrize("url", [SQLITE, POSTGRESQL], indirect=True)
@pytest.mark.long("a server under load is killed")
@pytest.mark.timeout(3600)
async def test_no_acknowledged_drop_is_lost_and_no_digest_changes(url: str) -> None:
    seed = int(os.environ.get("PLINKO_TEST_SEED", "1"))
    load = Load(server=ServerProcess(url), chance=random.Random(seed))
    for room, board in ROOMS.items():
        load.join(room, Board.preset(board))
    with load.server as server:
        async with load.playing():
            for _ in range(KILLS):
                await load.until_killed(load.chance.uniform(0.05, 3.0))
                await asyncio.to_thread(server.start)
        staked = 0
        for told in load.rooms.values():
            staked += await asyncio.to_thread(prove, server, told)
        assert staked, "no drop was staked"
        assert server.end(signal.SIGTERM) == 0
    load.hold(url, killed=True)
    starts = load.server.starts
    print(  # noqa: T201
        f"{KILLS} kills, {load.acknowledged} acknowledged drops, none lost, no digest changed; "
        f"starts took {median(starts):.1f} s in the median, at most {max(starts):.1f} s"
    )
    assert load.acknowledged >= ACKNOWLEDGED * KILLS
