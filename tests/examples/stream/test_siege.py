"""A stream of hours in minutes: kit, Twitch, OBS and the game are killed at random, many times."""

import asyncio
import random
import signal
import time
from collections import Counter
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.examples.stream.fake_obs import PASSWORD, FakeObs, fake_obs
from tests.examples.stream.fake_twitch import FakeTwitch, fake_twitch
from tests.examples.stream.kit import Kit, running
from tests.kit.process import ServerProcess
from tests.kit.waiting import LIMIT

# The fakes cut connections off, as a killed program does, and close nothing.
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")

EVENTS = 10_000
WAITING = 400  # balls that have not landed: kills go on until the last events
AHEAD = 100  # events on their way to the kit; fewer than Twitch sends again
RULES = """
[jackpot]
[goals.Balls]
target = 1000
[in."!drop"]
every = 60
[in.bits]
per = 100
[in.sub]
balls = 2
[in.gift]
source = "Confetti"
seconds = 0.1
[in.donation]
per = 2.5
[[landing]]
jackpot = 0.5
goals = { Balls = 1 }
"""


class Stream:
    """Viewers, each with one event, and the balls that they should have."""

    def __init__(self, twitch: FakeTwitch, kit: Kit, chance: random.Random) -> None:
        self.twitch, self.kit, self.chance = twitch, kit, chance
        self.expected: dict[str, int] = {}
        self.bridged = 0  # events of another program, of which some were sent twice

    async def happen(self, http: httpx.AsyncClient) -> None:
        for number in range(EVENTS):
            name = f"v{number}"
            kind = self.chance.choices(("chat", "bits", "sub", "gift", "tip"), (80, 6, 2, 2, 10))[0]
            viewer: dict[str, Any] = {"user_id": f"id of {name}", "user_name": name}
            self.expected[name] = {"chat": 1, "bits": 1, "sub": 2, "gift": 3, "tip": 1}[kind]
            if kind == "chat":
                await self.twitch.chat(name, "!drop", number=name)
            elif kind == "bits":
                await self.twitch.send("channel.cheer", name, bits=150, **viewer)
            elif kind == "sub":
                await self.twitch.send("channel.subscribe", name, is_gift=False, **viewer)
            elif kind == "gift":
                await self.twitch.send("channel.subscription.gift", name, total=3, **viewer)
            else:
                await self.tip(http, name)
            while number - AHEAD > self.taken or (number % 20 == 0 and self.kit.waiting > WAITING):
                await asyncio.sleep(0.05)

    @property
    def taken(self) -> int:
        return int(self.kit.rows("SELECT count(*) FROM events")[0][0])

    async def tip(self, http: httpx.AsyncClient, name: str) -> None:
        """A program repeats its request until the kit has confirmed it, sometimes once more."""
        event = {"kind": "donation", "id": name, "name": name, "amount": 3}
        repeats = self.chance.choice((1, 2))
        while repeats:
            try:
                reply = await http.post(self.kit.address, json=event)
                repeats -= reply.status_code == 202
            except (httpx.HTTPError, StopIteration):
                await asyncio.sleep(0.05)


async def kill(chance: random.Random, kit: Kit, twitch: FakeTwitch, obs: FakeObs,
               game: ServerProcess, killed: Counter[str]) -> None:  # fmt: skip
    while True:
        await asyncio.sleep(chance.uniform(5.0, 25.0))
        victim = chance.choice(("kit", "twitch", "obs", "game"))
        pause = chance.uniform(0.0, 2.0)
        killed[victim] += 1
        if victim == "kit":
            await kit.end()
            await asyncio.sleep(pause)
            await kit.start()
        elif victim == "game":
            await asyncio.to_thread(game.end, signal.SIGKILL)
            await asyncio.sleep(pause)
            await asyncio.to_thread(game.start)
        else:
            part = twitch if victim == "twitch" else obs
            await part.kill()
            await asyncio.sleep(pause)
            await part.start()


@pytest.mark.long("ten thousand events, with kills of each part, take minutes")
async def test_no_ball_of_a_long_stream_is_lost_or_doubled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OBS_PASSWORD", PASSWORD)
    seed = random.randrange(1 << 32)
    chance, killed, began = random.Random(seed), Counter[str](), time.monotonic()
    ledger = f"sqlite:///{tmp_path / 'plinko.db'}"
    async with fake_twitch() as twitch, fake_obs() as obs:
        with ServerProcess(ledger=ledger, flags=("--data", str(tmp_path))) as game:
            rules = RULES + twitch.rules + obs.rules
            async with (
                running(tmp_path, game.url, rules, "falling = 100") as kit,
                httpx.AsyncClient(timeout=5.0) as http,
            ):
                stream = Stream(twitch, kit, chance)
                killer = asyncio.create_task(kill(chance, kit, twitch, obs, game, killed))
                happening = asyncio.create_task(stream.happen(http))
                await asyncio.wait((killer, happening), return_when=asyncio.FIRST_COMPLETED)
                killer.cancel()
                await happening
                await asyncio.wait((killer,))
                # Whatever the killer has left dead lives again.
                await kit.end()
                if game.process is None:
                    await asyncio.to_thread(game.start)
                for part in (twitch, obs):
                    await part.kill()
                    await part.start()
                await kit.start()
                while stream.taken < EVENTS or kit.waiting:
                    await asyncio.sleep(0.1)
                balls = sum(stream.expected.values())
                assert kit.balls() == stream.expected, f"seed {seed}"
                show = kit.state("show")
                assert show["goals"]["Balls"] == 2 * show["jackpot"] == balls, f"seed {seed}"
                log = httpx.get(f"{game.url}/api/v1/rooms/{kit.room}/log", timeout=LIMIT).json()
                dropped = Counter(drop["name"] for drop in log["drops"])
                assert dropped == Counter(stream.expected), f"seed {seed}"
        seconds = time.monotonic() - began
    print(  # noqa: T201 - what the siege was
        f"{EVENTS} events, {balls} balls, kills {dict(killed)}, {seconds:.0f} s, seed {seed}"
    )
