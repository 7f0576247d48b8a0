"""A room of touching balls survives kills of its server with every bit unchanged."""

import asyncio
import random
import signal
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from plinko.app.rooms import log as roomlog
from tests.app.persistence.conftest import KILLS, POSTGRESQL, SQLITE
from tests.kit.player import events_of, joining, send, tick_of
from tests.kit.process import ServerProcess
from tests.kit.waiting import eventually, until

PLACED = 2  # balls at least, between two kills


class Told:
    """The events that one player of the room received, over all restarts of the server."""

    def __init__(self) -> None:
        self.tick = 0
        self.placed: list[tuple[int, float]] = []  # tick and x of every ball that players added
        self.balls: list[int] = []

    def hear(self, frame: str | bytes) -> None:
        if isinstance(frame, bytes):
            self.tick = max(self.tick, tick_of(frame))
            return
        for event in events_of(frame):
            if event["type"] == "hello":
                assert event["tick"] >= self.tick, "a tick that was shown was taken back"
                self.balls = event["arena"]["balls"]["ball"]
            elif event["type"] == "placed":
                self.placed.append((event["tick"], event["x"]))
                self.balls.append(event["ball"])
            elif event["type"] == "error":
                assert event["code"] in ("no-such-ball", "rate-limited"), event


async def play(line: ClientConnection, told: Told, chance: random.Random, kill: Any) -> None:
    """Throw, kick and drag balls until the connection breaks."""

    async def act() -> None:
        while True:
            x, ball = chance.uniform(-2, 2), chance.choice(told.balls)
            message: dict[str, Any] = chance.choice(
                [
                    {"type": "add", "x": x, "y": 0.5, "vx": 4 * x, "radius": 0.06},
                    {"type": "kick", "ball": ball, "vx": x, "vy": -3.0},
                    {"type": "drag", "ball": ball, "x": x, "y": 1.0},
                    {"type": "release", "ball": ball},
                    {"type": "settings", "gravity": 5.0 + x},
                ]
            )
            await send(line, **message)
            await asyncio.sleep(0.03)  # no wait: a player's pace

    acting = asyncio.create_task(act())
    killing = asyncio.create_task(kill)
    try:
        async for frame in line:
            told.hear(frame)
    except ConnectionClosed:
        pass
    finally:
        await killing
        acting.cancel()
        await asyncio.gather(acting, return_exceptions=True)


def log_of(server: ServerProcess, room: str) -> dict[str, Any]:
    log: dict[str, Any] = server.get(f"/api/v1/rooms/{room}/log").json()
    return log


def log_from(server: ServerProcess, room: str, tick: int) -> dict[str, Any]:
    """The room's log as soon as the room has reached this tick."""
    until(lambda: log_of(server, room)["tick"] >= tick)
    return log_of(server, room)


@pytest.mark.parametrize("url", [SQLITE, POSTGRESQL], indirect=True)
@pytest.mark.long("a server under load is killed")
@pytest.mark.timeout(3600)
async def test_inputs_of_a_box_survive_every_kill_and_replay(url: str) -> None:
    chance, told = random.Random(3), Told()
    with ServerProcess(url) as server:
        body = {"scene": {"scene": "sandbox", "balls": 15, "restitution": 0.9}}
        async with server.async_client() as http:
            room = (await http.post("/api/v1/rooms", json=body)).json()

        async def kill() -> None:
            enough = len(told.placed) + PLACED
            await asyncio.sleep(chance.uniform(0.5, 2.0))  # no wait: a random moment
            await eventually(lambda: len(told.placed) >= enough)
            await asyncio.to_thread(server.end, signal.SIGKILL)

        for _ in range(KILLS):
            async with joining(server.socket(room["id"]), max_size=None) as line:
                told.hear(await line.recv())
                await send(line, type="claim", token=room["token"])
                await play(line, told, chance, kill())
            await asyncio.to_thread(server.start)
            # From its last input on, the room plays the same motion again.
            log = await asyncio.to_thread(log_from, server, room["id"], told.tick)
            assert roomlog.verify_log(log).ok
            kept = [
                (entry["tick"], entry["input"]["x"])
                for entry in log["inputs"]
                if entry["input"]["type"] == "add"
            ]
            assert set(told.placed) <= set(kept), "what was announced is in the log"
        assert server.end(signal.SIGTERM) == 0
    assert len(told.placed) >= PLACED * KILLS
