"""Players of a server that strangers attack, and that is killed and stalled meanwhile."""

import asyncio
import contextlib
import itertools
import random
import signal
import sqlite3
import time
from collections import Counter
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import httpx

from benchmarks.harness.effort import MissingError
from benchmarks.serving.attack.attackers import KINDS, Attack
from benchmarks.serving.process import worked
from engine import Board
from tests.app.persistence.server import Heard, Served, play
from tests.waiting import LIMIT

SHARE: Final = 0.5
"""Cores that all of it takes on average, attackers included: it lasts hours, and others work."""

REST: Final = 30.0
"""s after which the next attack begins in any case: rooms that attackers left may take as much."""

STALLS: Final = (0.5, 1.0, 2.0, 2.5, 4.0, 10.0)  # s
FAULTS: Final = ("kill", "stop", "stall", "lock", "nothing")


@dataclass
class Siege:
    """Players who come back whenever the server does, and what happens to it meanwhile.

    `rooms` has what players were told, `boards` those of rooms whose balls land one by one; the
    log of the room `logged` is what attackers read.
    """

    server: Served
    file: Path  # SQLite's
    chance: random.Random
    logged: str = ""
    boards: dict[str, Board] = field(default_factory=dict)
    rooms: dict[str, Heard] = field(default_factory=dict)
    happened: Counter[str] = field(default_factory=Counter)
    answers: Counter[str] = field(default_factory=Counter)
    gone: float = 0.0  # s of processor time of servers that have ended

    def join(self, room: str, board: Board | None) -> Heard:
        """Note what is told of a room; without a board, its balls touch each other."""
        if board is not None:
            self.boards[room] = board
        return self.rooms.setdefault(room, Heard(room))

    def open(self, board: Board) -> Heard:
        """Make a room of a player's own."""
        with httpx.Client(base_url=self.server.address, timeout=LIMIT) as http:
            form = {"board": board.to_dict()}
            found = http.post("/api/v1/rooms", json=form).raise_for_status().json()
        return self.join(found["id"], board)

    @property
    def effort(self) -> float:
        """Processor time of server and attackers so far, in s."""
        assert self.server.process is not None
        return time.process_time() + self.gone + worked(self.server.process.pid)

    async def keep_playing(self, told: Heard, seeds: Iterator[int], pause: float) -> None:
        """Drop balls for ever, and come back whenever the line breaks."""
        while True:
            await play(self.server, told, seeds, pause, stakes=told.room in self.boards)
            await asyncio.sleep(0.3)  # no wait: a page's pause before it comes back

    async def stand(self, seconds: float) -> None:
        """Attack after attack, with a fault amid each, and rest between them."""
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
                await asyncio.sleep(1.0)  # no wait: others work here

    def _works_much(self, before: float, began: float) -> bool:
        return self.effort - before > SHARE * (time.monotonic() - began)

    @contextlib.asynccontextmanager
    async def attacked(self, name: str, address: str) -> AsyncIterator[None]:
        """Strangers of one kind and address at work until the block ends."""
        attack = Attack(self.server, address, self.logged)
        try:
            acts = await asyncio.to_thread(KINDS[name], attack)
        except MissingError:  # the server is not up to what they need to begin with
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
        process, seconds = self.server.process, self.chance.choice(STALLS)
        assert process is not None
        match name:
            case "kill":
                await self.again(signal.SIGKILL)
            case "stop":
                await self.again(signal.SIGTERM)
            case "stall":
                process.send_signal(signal.SIGSTOP)
                await asyncio.sleep(seconds)  # no wait: how long it stalls
                process.send_signal(signal.SIGCONT)
            case "lock":
                other = sqlite3.connect(self.file, isolation_level=None, timeout=LIMIT)
                with contextlib.closing(other):
                    other.execute("BEGIN IMMEDIATE")
                    await asyncio.sleep(seconds)  # no wait: how long it is locked
                    other.execute("ROLLBACK")

    async def again(self, how: signal.Signals) -> None:
        """End the server, and start it over the same ledger."""
        assert self.server.process is not None
        self.gone += worked(self.server.process.pid)
        code = await asyncio.to_thread(self.server.end, how)
        assert how is signal.SIGKILL or code == 0, f"the server ended with exit code {code}"
        await asyncio.to_thread(self.server.start)

    async def until_all_take_drops(self) -> None:
        """The server is there, and in every room a drop comes through that was asked for now.

        Or it finds the room full: on a machine that others keep busy, balls fall slowly.
        """
        before = {name: told.full + len(told.accepted) for name, told in self.rooms.items()}
        async with asyncio.timeout(LIMIT):
            while any(
                told.full + len(told.accepted) == before[name] for name, told in self.rooms.items()
            ):
                await asyncio.sleep(0.05)
        assert self.server.process is not None
        assert self.server.process.poll() is None, "the server ended by itself"

    async def until_still(self) -> None:
        """Nothing moves in the players' rooms any more, and the ledger has all that landed."""
        async with httpx.AsyncClient(base_url=self.server.address, timeout=LIMIT) as http:
            for name in self.rooms:
                async with asyncio.timeout(LIMIT):
                    while (await http.get(f"/api/v1/rooms/{name}")).json().get("awake", True):
                        await asyncio.sleep(0.05)
                    while (await http.get(f"/api/v1/rooms/{name}/log?limit=1")).status_code == 503:
                        await asyncio.sleep(0.05)
