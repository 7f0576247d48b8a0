"""Servers over one ledger are killed, ended, frozen and cut off at random, while many play.

What was acknowledged is in the ledger at the end, and lands where it would have with nobody around;
nothing lands twice, and no client sees a tick that is taken back.
"""

import asyncio
import contextlib
import itertools
import os
import random
import signal
import time
from collections import Counter
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Final

import httpx
import msgspec
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from engine import Board
from tests.app.cluster.servers import One, Servers
from tests.app.persistence import postgres
from tests.app.persistence.oracle import hold
from tests.app.persistence.server import Heard, play
from tests.long import tries
from tests.waiting import LIMIT, eventually

BOARD: Final = "triangle-8"
ROOMS: Final = tries(3, 30)
CLIENTS: Final = tries(9, 300)
KILLS: Final = tries(2, int(os.environ.get("PLINKO_TEST_KILLS", "100")))
FAULTS: Final = tries((), ("end", "freeze", "redis", "postgresql"))
"""What is done beside kills, in turn: one for every five of them."""

ACKNOWLEDGED: Final = 3  # drops at least in each room, between one fault and the next
FROZEN: Final = 5.0  # s
PAUSE: Final = tries(0.1, 1.0)  # s between two drops of a player

Line = (ConnectionClosed, InvalidHandshake, OSError)


@dataclass
class Watcher:
    """A client that only watches, and notes how long it saw nothing while something moved."""

    room: str
    tick: int = 0
    last: float = 0.0  # when something came
    gaps: list[float] = field(default_factory=list)  # s

    def frame(self, frame: str | bytes) -> None:
        if isinstance(frame, bytes):
            tick = int.from_bytes(frame[4:8], "little")
            assert tick >= self.tick, "a tick that was shown was taken back"
            self._seen(tick)
            return
        value = msgspec.json.decode(frame)
        for event in value if isinstance(value, list) else [value]:
            if event["type"] == "hello":
                assert event["tick"] >= self.tick, "a tick that was shown was taken back"
                self._seen(event["tick"])

    def _seen(self, tick: int) -> None:
        now = time.monotonic()
        if self.last:
            self.gaps.append(now - self.last)
        self.tick, self.last = tick, now


@dataclass
class Siege:
    """Players and watchers, who come back to any server whenever their line ends."""

    servers: Servers
    postgresql: postgres.Cluster
    chance: random.Random
    rooms: dict[str, Heard] = field(default_factory=dict)
    watchers: list[Watcher] = field(default_factory=list)
    happened: Counter[str] = field(default_factory=Counter)

    def open(self) -> None:
        """Make the rooms, each at some server."""
        for _ in range(ROOMS):
            one = self.chance.choice(self.servers.up)
            made = httpx.post(f"{one.url}/api/v1/rooms", json={"board": BOARD}, timeout=LIMIT)
            room = made.raise_for_status().json()["id"]
            self.rooms[room] = Heard(room)
        names = list(self.rooms)
        self.watchers = [Watcher(names[k % ROOMS]) for k in range(CLIENTS - ROOMS)]

    @property
    def acknowledged(self) -> int:
        return sum(len(told.accepted) for told in self.rooms.values())

    @contextlib.asynccontextmanager
    async def going_on(self) -> AsyncIterator[None]:
        """All play and watch until the block ends, or one of them finds something wrong."""
        seeds = itertools.count(self.chance.randrange(1 << 60))
        async with asyncio.TaskGroup() as tasks:
            playing = [tasks.create_task(self._play(told, seeds)) for told in self.rooms.values()]
            watching = [tasks.create_task(self._watch(each)) for each in self.watchers]
            yield
            for task in (*playing, *watching):
                task.cancel()

    def _somewhere(self) -> One:
        return self.chance.choice(self.servers.up)

    async def _play(self, told: Heard, seeds: "itertools.count[int]") -> None:
        while True:
            await play(self._somewhere(), told, seeds, PAUSE, stakes=False)
            await asyncio.sleep(0.05)  # no wait: as a page, but for one that was sent on

    async def _watch(self, watcher: Watcher) -> None:
        while True:
            with contextlib.suppress(*Line):
                async with connect(
                    self._somewhere().socket(watcher.room), compression=None, max_queue=None
                ) as line:
                    async for frame in line:
                        watcher.frame(frame)
            await asyncio.sleep(0.05)  # no wait: as above

    async def until_all_take_drops(self) -> None:
        """In every room some drops come through that were asked for now."""
        before = {name: told.full + len(told.accepted) for name, told in self.rooms.items()}

        def more() -> bool:
            return all(
                told.full + len(told.accepted) >= before[name] + ACKNOWLEDGED
                for name, told in self.rooms.items()
            )

        await eventually(more)

    async def stand(self) -> None:
        """Fault after fault; all rooms take drops between them."""
        faults = itertools.cycle(FAULTS or ("kill",))
        for number in range(KILLS):
            await self._fault("kill")
            if FAULTS and number % 5 == 4:
                await self._fault(next(faults))

    async def _fault(self, name: str) -> None:
        await self.until_all_take_drops()
        await asyncio.sleep(self.chance.uniform(0.0, 1.0))  # no wait: left to chance
        self.happened[name] += 1
        one = self._somewhere()
        match name:
            case "kill":
                await asyncio.to_thread(one.end, signal.SIGKILL)
                await self.until_all_take_drops()
            case "end":
                assert await asyncio.to_thread(one.end, signal.SIGTERM) == 0
            case "freeze":
                one.send(signal.SIGSTOP)
                await asyncio.sleep(FROZEN)  # no wait: how long it is frozen
                one.send(signal.SIGCONT)
            case "redis":
                self.servers.redis.stop()
                await self.until_all_take_drops()
                self.servers.redis.start()
            case "postgresql":
                await asyncio.to_thread(self.postgresql.stop, signal.SIGQUIT)
                await asyncio.to_thread(self.postgresql.start)
        await asyncio.to_thread(self.servers.start)

    async def until_still(self) -> None:
        async with httpx.AsyncClient(base_url=self._somewhere().url, timeout=LIMIT) as http:
            for name in self.rooms:
                async with asyncio.timeout(LIMIT):
                    while (await http.get(f"/api/v1/rooms/{name}")).json().get("awake", True):
                        await asyncio.sleep(0.05)


@pytest.mark.postgresql
@pytest.mark.long
@pytest.mark.timeout(4 * 3600)
async def test_whatever_ends_no_acknowledged_ball_is_lost_and_none_lands_twice(
    servers: Servers, postgresql: postgres.Cluster
) -> None:
    chance = random.Random(int(os.environ.get("PLINKO_TEST_SEED", "1")))
    siege = Siege(servers, postgresql, chance)
    siege.open()
    async with siege.going_on():
        await siege.stand()
    await siege.until_still()
    drops = sum(
        hold(servers.database, told, Board.preset(BOARD), killed=True, shared=True)
        for told in siege.rooms.values()
    )
    assert siege.acknowledged >= ACKNOWLEDGED * KILLS * ROOMS
    assert drops >= siege.acknowledged
    longest = max(max(each.gaps, default=0.0) for each in siege.watchers)
    print(  # noqa: T201
        f"{dict(siege.happened)}: {siege.acknowledged} acknowledged drops of {drops}, none lost; "
        f"the longest that a watcher saw nothing: {longest:.1f} s"
    )
