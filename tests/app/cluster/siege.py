"""Players and watchers in many rooms at several servers, and what is done to these meanwhile."""

import asyncio
import contextlib
import itertools
import math
import os
import random
import signal
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Any, Final

import httpx

from engine import Board
from tests.app.cluster.servers import One, Servers
from tests.app.cluster.watchers import Break, Pulse, Watcher, taken_over
from tests.app.persistence import postgres
from tests.app.persistence.oracle import hold
from tests.app.persistence.server import Heard, play
from tests.waiting import LIMIT, eventually

BOARD: Final = "triangle-8"
ROOMS: Final = 30
CLIENTS: Final = 300
KILLS: Final = int(os.environ.get("PLINKO_TEST_KILLS", "100"))
FAULTS: Final = ("end", "freeze", "postgresql")
"""What is done beside kills, in turn: one for every five of them."""

ACKNOWLEDGED: Final = 3  # drops at least in each room, between one fault and the next
FROZEN: Final = 5.0  # s
PAUSE: Final = 1.0  # s between two drops of a player


@dataclass
class Player(Heard):
    """What a player is told, who is sent every tick."""

    last: float = 0.0  # when something came, in s; 0: never
    gaps: list[float] = field(default_factory=list)  # s until the next line greeted

    def frame(self, frame: str | bytes) -> None:
        super().frame(frame)
        self.last = time.monotonic()

    def _event(self, event: dict[str, Any]) -> None:
        if event["type"] == "hello" and self.last:
            self.gaps.append(time.monotonic() - self.last)
        super()._event(event)


@dataclass
class Siege:
    """Players and watchers, who come back to any server whenever their line ends."""

    servers: Servers
    postgresql: postgres.Cluster
    chance: random.Random
    rooms: dict[str, Player] = field(default_factory=dict)
    watchers: list[Watcher] = field(default_factory=list)
    happened: list[tuple[str, float]] = field(default_factory=list)  # what, and when, in s

    def open(self) -> None:
        """Make the rooms, each at some server."""
        for _ in range(ROOMS):
            one = self.chance.choice(self.servers.up)
            made = httpx.post(f"{one.url}/api/v1/rooms", json={"board": BOARD}, timeout=LIMIT)
            room = made.raise_for_status().json()["id"]
            self.rooms[room] = Player(room)
        pulses = [(name, Pulse()) for name in self.rooms]
        self.watchers = [Watcher(*each, stream="snapshots") for each in pulses]
        others = itertools.islice(itertools.cycle(pulses), CLIENTS - 2 * ROOMS)
        self.watchers += [Watcher(*each) for each in others]

    @property
    def acknowledged(self) -> int:
        return sum(len(told.accepted) for told in self.rooms.values())

    @contextlib.asynccontextmanager
    async def going_on(self) -> AsyncIterator[None]:
        """All play and watch until the block ends, or one of them finds something wrong."""
        seeds = itertools.count(self.chance.randrange(1 << 60))
        async with asyncio.TaskGroup() as tasks:
            playing = [tasks.create_task(self._play(told, seeds)) for told in self.rooms.values()]
            watching = [tasks.create_task(each.watch(self._somewhere)) for each in self.watchers]
            yield
            for task in (*playing, *watching):
                task.cancel()

    def _somewhere(self) -> One:
        return self.chance.choice(self.servers.up)

    async def _play(self, told: Heard, seeds: "itertools.count[int]") -> None:
        while True:
            await play(self._somewhere(), told, seeds, PAUSE, stakes=False)
            await asyncio.sleep(0.05)  # no wait: as a page, but for one that was sent on

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
        faults = itertools.cycle(FAULTS)
        for number in range(KILLS):
            await self._fault("kill")
            if number % 5 == 4:
                await self._fault(next(faults))

    async def _fault(self, name: str) -> None:
        await self.until_all_take_drops()
        await asyncio.sleep(self.chance.uniform(0.0, 1.0))  # no wait: left to chance
        one = self._somewhere()
        self.happened.append((name, time.monotonic()))
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
            case "postgresql":
                await asyncio.to_thread(self.postgresql.stop, signal.SIGQUIT)
                await asyncio.to_thread(self.postgresql.start)
        await asyncio.to_thread(self.servers.start)

    async def roll(self) -> None:
        """Every server ends in order and is started again, one after another."""
        for one in self.servers:
            await self.until_all_take_drops()
            self.happened.append(("end", time.monotonic()))
            assert await asyncio.to_thread(one.end, signal.SIGTERM) == 0
            await asyncio.to_thread(self.servers.start)
        await self.until_all_take_drops()

    @property
    def taken_over(self) -> list[float]:
        """How long after each kill each room greeted that had been at the server, in s."""
        times = [when for _, when in self.happened] + [math.inf]
        return [
            seconds
            for number, (name, when) in enumerate(self.happened)
            if name == "kill"
            for seconds in taken_over(self.watchers, when, times[number + 1])
        ]

    @property
    def gaps(self) -> list[float]:
        """For how long nothing moved for a client whose line had ended, in s."""
        playing = (gap for told in self.rooms.values() for gap in told.gaps)
        return [*(each.gap for each in self.breaks), *playing]

    @property
    def breaks(self) -> list[Break]:
        """Every line that ended under a watcher who was greeted again."""
        return [each for watcher in self.watchers for each in watcher.breaks]

    def check(self) -> int:
        """How many drops there were; raises AssertionError where the ledger has lost one."""
        return sum(
            hold(self.servers.database, told, Board.preset(BOARD), killed=True, shared=True)
            for told in self.rooms.values()
        )

    async def until_still(self) -> None:
        async with httpx.AsyncClient(base_url=self._somewhere().url, timeout=LIMIT) as http:
            for name in self.rooms:
                async with asyncio.timeout(LIMIT):
                    while (await http.get(f"/api/v1/rooms/{name}")).json().get("awake", True):
                        await asyncio.sleep(0.05)
