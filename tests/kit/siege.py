"""Players that continue while servers fail, and record every event they receive."""

import asyncio
import contextlib
import hashlib
import itertools
import random
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar

import httpx
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from plinko.app.fairness.check import check_session, kernel_digest_of
from plinko.app.fairness.export import read_export
from plinko.app.settings import page_kernels
from plinko.engine import Board
from tests.kit.address import Address
from tests.kit.player import events_of, joining, send, tick_of
from tests.kit.told import Told, hold
from tests.kit.waiting import LIMIT, eventually

CLIENT_SEED = b"\x5a" * 32
Broken = (ConnectionClosed, InvalidHandshake, OSError)


def prove(server: Address, told: "Heard") -> int:
    """End and check all sessions of a player, with their receipts; returns how many drops."""
    drops = 0
    with server.client() as client:
        for session, token in told.tokens.items():
            address, shown = f"/api/v1/sessions/{session}", {"authorization": f"Bearer {token}"}
            opening = {"seed": CLIENT_SEED.hex()}
            client.post(f"{address}/opening", json=opening, headers=shown)
            client.post(f"{address}/end", headers=shown).raise_for_status()
            export = client.get(f"{address}/export", headers=shown).raise_for_status().json()
            export["heard"] = told.receipts.get(session, [])
            kernel = kernel_digest_of(page_kernels().read_bytes())
            verdict = check_session(read_export(export), kernel_digest=kernel)
            assert verdict.failed == []
            drops += verdict.drops
    return drops


@dataclass
class Heard(Told):
    """The events that one player received over its WebSockets."""

    tick: int = 0  # the latest one received
    full: int = 0  # drops refused because the room had its maximum of balls in flight
    tokens: dict[str, str] = field(default_factory=dict)  # by the player's sessions
    session: str | None = None  # the session open on this connection

    @property
    def wants_session(self) -> bool:
        """Whether no session is open and the server has not refused one."""
        return self.session is None and "begin" not in self.refused

    def frame(self, frame: str | bytes) -> None:
        if isinstance(frame, bytes):
            self.tick = max(self.tick, tick_of(frame))
            return
        for event in events_of(frame):
            self._event(event)
            self.tick = max(self.tick, event.get("tick", 0))

    def _event(self, event: dict[str, Any]) -> None:
        match event["type"]:
            case "hello":
                # Touching balls go on from their last checkpoint, and play the same motion again.
                if event["mode"] == "independent":
                    assert event["tick"] >= self.tick, "a tick that was shown was taken back"
                for ball in event["balls"]:
                    told = self.accepted.get(ball["ball"])
                    assert told is None or all(told[key] == ball[key] for key in ball)
            case "accepted" | "landed":
                self.hear(event)
            case "session" if event["token"]:
                self.tokens[event["session"]] = event["token"]
            case "session":
                self.session = event["session"]
            case "error" if event["code"] in ("room-rebuilding", "room-moved"):
                # The server then closes the connection. The player reconnects to any server.
                self.refused.update(filter(None, [event.get("ref")]))
            case "error" if event["code"] == "limit-reached":
                self.session = None  # it has no drops left: the player begins another
            case "error" if event["code"] == "undecided":
                pass  # a later event says whether it was accepted
            case "error":
                assert event["code"] in ("too-many-balls", "ledger-unavailable"), event
                self.refused.add(event["ref"])
                self.full += event["code"] == "too-many-balls"


async def play(
    server: Address, told: Heard, seeds: Iterator[int], pause: float, *, stakes: bool = True
) -> None:
    """Drop ball after ball and record events until the connection breaks or it is cancelled."""
    with contextlib.suppress(*Broken):
        async with joining(server.socket(told.room), max_size=None) as line:

            async def begin() -> None:
                before = len(told.tokens)
                committed = hashlib.sha256(CLIENT_SEED).hexdigest()
                await send(line, type="session", commitment=committed, ref="begin")
                await eventually(lambda: len(told.tokens) > before or "begin" in told.refused)
                if len(told.tokens) > before:
                    opened = [*told.tokens][-1]
                    await send(line, type="open", session=opened, seed=CLIENT_SEED.hex())

            async def drop() -> None:
                """Drop for practice, and with stakes as soon as a session is open."""
                told.session = None
                told.refused.discard("begin")
                beginning = asyncio.create_task(begin() if stakes else asyncio.sleep(0))
                try:
                    for seed in seeds:
                        if stakes and beginning.done() and told.wants_session:
                            beginning = asyncio.create_task(begin())
                        if told.session is None or seed % 2:
                            await send(line, type="drop", seed=seed, ref=str(seed))
                        else:
                            staked = {"session": told.session, "stake": seed % 1000 + 1}
                            await send(line, type="drop", ref=f"staked {seed}", **staked)
                        await asyncio.sleep(pause)  # no wait: a player's pace
                finally:
                    beginning.cancel()
                    await asyncio.gather(beginning, return_exceptions=True)

            dropping = asyncio.create_task(drop())
            try:
                async for frame in line:
                    told.frame(frame)
            finally:
                dropping.cancel()
                await asyncio.gather(dropping, return_exceptions=True)


@dataclass(kw_only=True)
class Siege:
    """One player in each room, which reconnects whenever its connection breaks.

    boards: those of rooms with independent balls, where players stake.
    """

    BACK: ClassVar = 0.3
    """Seconds until a player reconnects, as a page does."""

    chance: random.Random
    rooms: dict[str, Heard] = field(default_factory=dict)
    boards: dict[str, Board] = field(default_factory=dict)
    pauses: tuple[float, float] = (0.3, 1.0)
    """Seconds between two drops of a player: shortest, longest."""
    stakes: bool = True

    def somewhere(self) -> Address:
        """The server that a player connects to next."""
        raise NotImplementedError

    def join(self, room: str, board: Board | None) -> Heard:
        """Record a room's events; a room without a board has touching balls."""
        if board is not None:
            self.boards[room] = board
        return self.rooms.setdefault(room, Heard(room))

    def open(self, board: Board) -> Heard:
        """Create a private room with this board."""
        with self.somewhere().client() as http:
            made = http.post("/api/v1/rooms", json={"board": board.to_dict()})
        return self.join(made.raise_for_status().json()["id"], board)

    @property
    def acknowledged(self) -> int:
        """The number of drops that players received as accepted."""
        return sum(len(told.accepted) for told in self.rooms.values())

    @contextlib.asynccontextmanager
    async def playing(self) -> AsyncIterator[list["asyncio.Task[None]"]]:
        """All players drop until the block ends, and then listen until nothing moves.

        A player's failed assertion ends the block.
        """
        seeds, stopped = itertools.count(self.chance.randrange(1 << 60)), False
        asked = itertools.takewhile(lambda _: not stopped, seeds)
        async with asyncio.TaskGroup() as tasks:
            players = [tasks.create_task(self.play(t, asked)) for t in self.rooms.values()]
            yield players
            stopped = True
            await self.until_still()
            for task in players:
                task.cancel()

    async def play(self, told: Heard, seeds: Iterator[int], pause: float | None = None) -> None:
        """Drop balls, and reconnect whenever the connection breaks."""
        stakes = self.stakes and told.room in self.boards
        while True:
            chosen = self.chance.uniform(*self.pauses) if pause is None else pause
            await play(self.somewhere(), told, seeds, chosen, stakes=stakes)
            await asyncio.sleep(self.BACK)  # no wait: a page's pause before it reconnects

    def came_through(self, told: Heard) -> int:
        """Drops that the room accepted, or refused as full: on a busy machine balls fall slowly."""
        return told.full + len(told.accepted)

    async def until_all_take_drops(self, count: int = 1) -> None:
        """Wait until this many further drops have come through in every room."""
        before = {name: self.came_through(told) for name, told in self.rooms.items()}
        await eventually(
            lambda: all(
                self.came_through(told) >= before[name] + count for name, told in self.rooms.items()
            )
        )

    async def until_still(self) -> None:
        """Wait until nothing moves in the rooms and the ledger has every landing."""
        async with self.somewhere().async_client() as http:
            for name in self.rooms:
                async with asyncio.timeout(LIMIT):
                    while await self._moves(http, name):
                        await asyncio.sleep(0.05)

    async def _moves(self, http: httpx.AsyncClient, room: str) -> bool:
        found = (await http.get(f"/api/v1/rooms/{room}")).json()
        if found.get("awake", True):
            return True
        return (await http.get(f"/api/v1/rooms/{room}/log?limit=1")).status_code == 503

    def hold(self, ledger: str, *, killed: bool = False, shared: bool = False) -> int:
        """Check the ledger against all recorded events; returns how many drops it has."""
        return sum(
            hold(ledger, self.rooms[name], board, killed=killed, shared=shared)
            for name, board in self.boards.items()
        )
