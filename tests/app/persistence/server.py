"""`plinko serve` as a process that can be killed, and players that note what they are told."""

import asyncio
import contextlib
import hashlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

import httpx
import msgspec
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from app.fairness.check import check_session, kernel_digest_of
from app.fairness.export import read_export
from app.settings import page_kernels
from tests.app.persistence.oracle import Told
from tests.ports import free_port
from tests.waiting import LIMIT, eventually, first_line

KILLS = int(os.environ.get("PLINKO_TEST_KILLS", "50"))
"""How often a crash test kills its server: once as it was begun, once as it was found again."""

# Kinds of database to keep a ledger in, see the fixture `url`.
SQLITE = pytest.param("sqlite", id="sqlite")
POSTGRESQL = pytest.param("postgresql", id="postgresql", marks=pytest.mark.postgresql)

_SERVE = ("serve", "--drop-rate", "1000")


@dataclass
class Served:
    """A server process over one ledger, started again at the same port after each end.

    program: what Python runs, as its own arguments.
    """

    url: str  # of the ledger
    flags: tuple[str, ...] = ()
    program: tuple[str, ...] = ("-m", "app.cli")
    port: int = field(default_factory=free_port)
    process: "subprocess.Popen[str] | None" = None
    starts: list[float] = field(default_factory=list)  # s that each took

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def start(self) -> None:
        began = time.monotonic()
        self.process = subprocess.Popen(
            [sys.executable, *self.program, *_SERVE, "--port", str(self.port), *self.flags],
            env=os.environ | {"PLINKO_DATABASE_URL": self.url},
            stdout=subprocess.PIPE,
            text=True,
        )
        line = first_line(self.process)
        assert re.search(r"http://\S+", line), f"the server said {line!r} and no address"
        self.starts.append(time.monotonic() - began)

    def end(self, how: signal.Signals) -> int:
        assert self.process is not None
        self.process.send_signal(how)
        self.process.communicate(timeout=LIMIT)
        code = self.process.returncode
        self.process = None
        return code

    def __enter__(self) -> "Served":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.process is not None:
            self.end(signal.SIGKILL)

    def get(self, path: str) -> Any:
        with httpx.Client(base_url=self.address, timeout=60.0) as client:
            return client.get(path).raise_for_status().json()


CLIENT_SEED = b"\x5a" * 32


class Addressed(Protocol):
    """A server that can be asked."""

    @property
    def address(self) -> str:
        """Where."""


def prove(server: Addressed, told: "Heard") -> int:
    """End each session of a player's and check it, receipts heard included; how many drops."""
    drops = 0
    with httpx.Client(base_url=server.address, timeout=60.0) as client:
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
    """What is told over sockets."""

    tick: int = 0  # the latest one heard of
    full: int = 0  # drops refused because as many balls as may be were in flight
    tokens: dict[str, str] = field(default_factory=dict)  # of own sessions
    session: str | None = None  # the one that is open on this connection

    @property
    def wants_session(self) -> bool:
        """Whether there is none, and none was refused."""
        return self.session is None and "begin" not in self.refused

    def frame(self, frame: str | bytes) -> None:
        if isinstance(frame, bytes):
            self.tick = max(self.tick, int.from_bytes(frame[4:8], "little"))
            return
        value = msgspec.json.decode(frame)
        for event in value if isinstance(value, list) else [value]:
            self._event(event)
            self.tick = max(self.tick, event.get("tick", 0))

    def _event(self, event: dict[str, Any]) -> None:
        match event["type"]:
            case "hello":
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
                # And the line ends: one comes back later, or at once to another server.
                self.refused.update(filter(None, [event.get("ref")]))
            case "error" if event["code"] == "limit-reached":
                self.session = None  # it has had its drops: another is begun
            case "error" if event["code"] == "undecided":
                pass  # what becomes of it is told later
            case "error":
                assert event["code"] in ("too-many-balls", "ledger-unavailable"), event
                self.refused.add(event["ref"])
                self.full += event["code"] == "too-many-balls"


async def play(
    server: Addressed, told: Heard, seeds: Iterator[int], pause: float, *, stakes: bool = True
) -> None:
    """Drop ball after ball, and write down what comes, until the line breaks or it is cancelled."""
    url = f"ws{server.address.removeprefix('http')}/ws/rooms/{told.room}"
    with contextlib.suppress(ConnectionClosed, InvalidHandshake, OSError):
        async with connect(url, compression=None, max_size=None, max_queue=None) as line:

            async def say(**message: Any) -> None:
                await line.send(msgspec.json.encode(message).decode())

            async def begin() -> None:
                before = len(told.tokens)
                committed = hashlib.sha256(CLIENT_SEED).hexdigest()
                await say(type="session", commitment=committed, ref="begin")
                await eventually(lambda: len(told.tokens) > before or "begin" in told.refused)
                if len(told.tokens) > before:
                    await say(type="open", session=[*told.tokens][-1], seed=CLIENT_SEED.hex())

            async def drop() -> None:
                """Practice, and staked drops as soon as there is a session."""
                told.session = None
                told.refused.discard("begin")
                beginning = asyncio.create_task(begin() if stakes else asyncio.sleep(0))
                try:
                    for seed in seeds:
                        if stakes and beginning.done() and told.wants_session:
                            beginning = asyncio.create_task(begin())
                        if told.session is None or seed % 2:
                            await say(type="drop", seed=seed, ref=str(seed))
                        else:
                            stake = seed % 1000 + 1
                            await say(type="drop", session=told.session, stake=stake, ref="staked")
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
