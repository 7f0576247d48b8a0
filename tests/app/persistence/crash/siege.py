"""Players of a server that other clients attack, and that is killed and stalled meanwhile."""

import asyncio
import contextlib
import itertools
import signal
import sqlite3
import time
from collections import Counter
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from benchmarks.harness.effort import MissingError
from benchmarks.serving.attack.attackers import KINDS, Attack
from benchmarks.serving.process import worked
from tests.kit import siege
from tests.kit.process import ServerProcess
from tests.kit.waiting import LIMIT

SHARE: Final = 0.5
"""Average number of cores for server and attackers, so that others can use the machine."""

REST: Final = 30.0
"""Seconds after which the next attack begins anyway: left rooms may use as much time."""

STALLS: Final = (0.5, 1.0, 2.0, 2.5, 4.0, 10.0)  # s
FAULTS: Final = ("kill", "stop", "stall", "lock", "nothing")


@dataclass(kw_only=True)
class Siege(siege.Siege):
    """Players of a server, and its attacks and faults.

    logged: the room whose log attackers read; happened: how often each attack and fault came.
    """

    server: ServerProcess
    file: Path  # SQLite's
    logged: str = ""
    happened: Counter[str] = field(default_factory=Counter)
    answers: Counter[str] = field(default_factory=Counter)
    gone: float = 0.0  # processor time of servers that have ended, s

    def somewhere(self) -> ServerProcess:
        return self.server

    @property
    def effort(self) -> float:
        """Processor time of server and attackers until now, s."""
        return time.process_time() + self.gone + worked(self.server.running.pid)

    async def stand(self, seconds: float) -> None:
        """Run attack after attack, each with a fault in the middle and a rest afterwards."""
        began, before = time.monotonic(), self.effort
        kinds = [name for name in KINDS if name != "nothing"]
        for number in itertools.count():
            if number % len(kinds) == 0:
                self.chance.shuffle(kinds)
            async with self.attacked(kinds[number % len(kinds)], f"127.0.0.{2 + number % 20}"):
                await asyncio.sleep(self.chance.uniform(1.0, 10.0))  # no wait: left to chance
                await self._fault(FAULTS[number % len(FAULTS)])
                await asyncio.sleep(self.chance.uniform(0.0, 2.0))  # no wait: left to chance
            await self.until_all_take_drops()
            if time.monotonic() > began + seconds:
                return
            rested = time.monotonic() + REST
            while time.monotonic() < rested and self._works_much(before, began):
                await asyncio.sleep(1.0)  # no wait: leaves the machine to others

    def _works_much(self, before: float, began: float) -> bool:
        return self.effort - before > SHARE * (time.monotonic() - began)

    @contextlib.asynccontextmanager
    async def attacked(self, name: str, address: str) -> AsyncIterator[None]:
        """Run an attack of this kind from this address until the block ends."""
        attack = Attack(self.server.url, address, self.logged)
        try:
            acts = await asyncio.to_thread(KINDS[name], attack)
        except MissingError:  # the server lacks something that the attack needs
            acts = []
        self.happened[name if acts else f"{name}: not begun"] += 1
        with contextlib.ExitStack() as going_on:
            going_on.enter_context(attack.going_on(acts))
            try:
                yield
            finally:
                await asyncio.to_thread(going_on.close)
                self.answers += attack.answers

    async def _fault(self, name: str) -> None:
        self.happened[name] += 1
        seconds = self.chance.choice(STALLS)
        match name:
            case "kill":
                await self.again(signal.SIGKILL)
            case "stop":
                await self.again(signal.SIGTERM)
            case "stall":
                self.server.send(signal.SIGSTOP)
                await asyncio.sleep(seconds)  # no wait: the duration of the stall
                self.server.send(signal.SIGCONT)
            case "lock":
                other = sqlite3.connect(self.file, isolation_level=None, timeout=LIMIT)
                with contextlib.closing(other):
                    other.execute("BEGIN IMMEDIATE")
                    await asyncio.sleep(seconds)  # no wait: the duration of the lock
                    other.execute("ROLLBACK")

    async def again(self, how: signal.Signals) -> None:
        """End the server, and start it again with the same ledger."""
        self.gone += worked(self.server.running.pid)
        code = await asyncio.to_thread(self.server.end, how)
        assert how is signal.SIGKILL or code == 0, f"the server ended with exit code {code}"
        await asyncio.to_thread(self.server.start)

    async def until_all_take_drops(self, count: int = 1) -> None:
        await super().until_all_take_drops(count)
        assert self.server.running.poll() is None, "the server ended by itself"
