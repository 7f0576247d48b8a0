"""Players and spectators in many rooms of several servers, and faults of these servers."""

import asyncio
import contextlib
import itertools
import math
import os
import signal
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Any, ClassVar, Final

from plinko.engine import Board
from tests.app.cluster.servers import Servers
from tests.app.cluster.watchers import Break, Pulse, Watcher, failed_over
from tests.kit import siege
from tests.kit.postgres import PostgreSQL
from tests.kit.process import ServerProcess
from tests.kit.siege import Heard

BOARD: Final = "triangle-8"
ROOMS: Final = 30
CLIENTS: Final = 300
KILLS: Final = int(os.environ.get("PLINKO_TEST_KILLS", "100"))
FAULTS: Final = ("end", "freeze", "postgresql")
"""Faults other than kills, in turn: one after every five kills."""

ACKNOWLEDGED: Final = 3  # drops at least, in each room between two faults
FROZEN: Final = 5.0  # s
PAUSE: Final = 1.0  # s between two drops of a player


@dataclass
class Player(Heard):
    """The events and snapshots that a player of one room received."""

    last: float = 0.0  # time of the last frame, s; 0: none yet
    breaks: list[Break] = field(default_factory=list)  # from the last frame to the next hello

    def frame(self, frame: str | bytes) -> None:
        super().frame(frame)
        self.last = time.monotonic()

    def _event(self, event: dict[str, Any]) -> None:
        if event["type"] == "hello" and self.last:
            self.breaks.append(Break(self.last, time.monotonic()))
        super()._event(event)


@dataclass(kw_only=True)
class Siege(siege.Siege):
    """Players and spectators, which reconnect to any server when their connection ends."""

    BACK: ClassVar = 0.05

    servers: Servers
    postgresql: PostgreSQL
    pauses: tuple[float, float] = (PAUSE, PAUSE)
    stakes: bool = False
    players: dict[str, Player] = field(default_factory=dict)
    watchers: list[Watcher] = field(default_factory=list)
    happened: list[tuple[str, float]] = field(default_factory=list)  # faults and their times, s

    def somewhere(self) -> ServerProcess:
        return self.chance.choice(self.servers.up)

    def join(self, room: str, board: Board | None) -> Heard:
        self.rooms[room] = self.players[room] = Player(room)
        return super().join(room, board)

    def begin(self) -> None:
        """Create the rooms, each at a random server."""
        for _ in range(ROOMS):
            self.open(Board.preset(BOARD))
        pulses = [(name, Pulse()) for name in self.rooms]
        self.watchers = [Watcher(*each, stream="snapshots") for each in pulses]
        others = itertools.islice(itertools.cycle(pulses), CLIENTS - 2 * ROOMS)
        self.watchers += [Watcher(*each) for each in others]

    @contextlib.asynccontextmanager
    async def going_on(self) -> AsyncIterator[None]:
        """All play and watch until the block ends or an assertion of one of them fails."""
        async with asyncio.TaskGroup() as tasks, self.playing():
            watching = [tasks.create_task(each.watch(self.somewhere)) for each in self.watchers]
            yield
            for task in watching:
                task.cancel()

    async def until_all_take_drops(self, count: int = ACKNOWLEDGED) -> None:
        await super().until_all_take_drops(count)

    async def stand(self) -> None:
        """Inject fault after fault; between two faults every room accepts drops."""
        faults = itertools.cycle(FAULTS)
        for number in range(KILLS):
            await self._fault("kill")
            if number % 5 == 4:
                await self._fault(next(faults))

    async def _fault(self, name: str) -> None:
        await self.until_all_take_drops()
        await asyncio.sleep(self.chance.uniform(0.0, 1.0))  # no wait: left to chance
        one = self.somewhere()
        self.happened.append((name, time.monotonic()))
        match name:
            case "kill":
                await asyncio.to_thread(one.end, signal.SIGKILL)
                await self.until_all_take_drops()
            case "end":
                assert await asyncio.to_thread(one.end, signal.SIGTERM) == 0
            case "freeze":
                one.send(signal.SIGSTOP)
                await asyncio.sleep(FROZEN)  # no wait: the duration of the freeze
                one.send(signal.SIGCONT)
            case "postgresql":
                await asyncio.to_thread(self.postgresql.end, signal.SIGQUIT)
                await asyncio.to_thread(self.postgresql.start)
        await asyncio.to_thread(self.servers.start)

    async def roll(self) -> None:
        """Stop and restart every server, one after the other."""
        for one in self.servers:
            await self.until_all_take_drops()
            self.happened.append(("end", time.monotonic()))
            assert await asyncio.to_thread(one.end, signal.SIGTERM) == 0
            await asyncio.to_thread(self.servers.start)
        await self.until_all_take_drops()

    @property
    def failed_over(self) -> list[float]:
        """Seconds from each kill to the next hello of each room that the server had."""
        times = [when for _, when in self.happened] + [math.inf]
        return [
            seconds
            for number, (name, when) in enumerate(self.happened)
            if name == "kill"
            for seconds in failed_over(self.watchers, when, times[number + 1])
        ]

    @property
    def gaps(self) -> dict[str, list[float]]:
        """Seconds without a frame, for each client whose connection ended, by the last fault."""
        found: dict[str, list[float]] = {}
        playing = [each for told in self.players.values() for each in told.breaks]
        for each in (*self.breaks, *playing):
            (*_, fault) = (name for name, when in self.happened if when <= each.back)
            found.setdefault(fault, []).append(each.gap)
        return found

    @property
    def breaks(self) -> list[Break]:
        """Every interruption after which a spectator received a hello again."""
        return [each for watcher in self.watchers for each in watcher.breaks]

    def check(self) -> int:
        """Check the ledger against all recorded events; returns how many drops it has."""
        return self.hold(self.servers.ledger, killed=True, shared=True)
