"""A server that is frozen while another takes its room does no damage when it wakes up."""

import asyncio
import json
import os
import signal
import subprocess
import sys
from typing import Any

import pytest

from plinko.app.persistence.statements import store
from tests.app.persistence.crash.life import living, look
from tests.app.persistence.test_sharing import sound
from tests.kit.postgres import PostgreSQL
from tests.kit.waiting import first_line
from tests.long import tries


@pytest.fixture
def address(postgresql: PostgreSQL) -> str:
    return postgresql.new_database()


async def play_on(url: str) -> list[dict[str, Any]]:
    """Another server takes the room over and plays; returns the drops it accepted."""
    async with living(url, holder="newer") as newer:
        room = await newer.stored.arriving.take("main")
        assert room is not None
        told = [await newer.drop(room, seed) for seed in (11, 12)]
        await newer.run(room, 30)
        await newer.leave()
    return [{"ball": each.ball, "seed": each.seed, "tick": each.tick} for each in told]


def kept(connection: Any) -> list[dict[str, Any]]:
    row = store.open_room(connection, "main")
    assert row is not None
    drops = store.drops(connection, row.number, 0)
    return [{"ball": d.ball, "seed": str(d.seed), "tick": d.tick} for d, _ in drops]


async def frozen_at(url: str, step: int) -> tuple[str, list[str]]:
    """Freeze a server at this step; returns the step's name ("" if none) and refused seeds."""
    command = [sys.executable, "-m", "tests.app.persistence.crash.freezing", url, str(step)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as older:
        try:
            name = (await asyncio.to_thread(first_line, older)).strip()
            if not name:
                return "", []
            _, status = await asyncio.to_thread(os.waitpid, older.pid, os.WUNTRACED)
            assert os.WIFSTOPPED(status)
            newer = await play_on(url)
            older.send_signal(signal.SIGCONT)
            assert older.stdout is not None
            said = json.loads(await asyncio.to_thread(older.stdout.readline))
        finally:
            older.kill()
    sound(url)
    in_ledger = look(url, kept)
    told = [{name: each[name] for name in ("ball", "seed", "tick")} for each in said["accepted"]]
    # Every accepted drop is in the ledger unchanged. Every drop in the ledger was accepted, except
    # those committed whose players had no answer when the process froze.
    assert [each for each in [*told, *newer] if each not in in_ledger] == []
    untold = {each["seed"] for each in in_ledger if each not in [*told, *newer]}
    assert untold <= {"1", "2", "3", "4"} - set(said["refused"])
    assert said["has"] == []
    return name, said["refused"]


@pytest.mark.long("a process is frozen at each step")
async def test_a_server_frozen_at_any_step_of_a_commit_harms_nothing(
    postgresql: PostgreSQL,
) -> None:
    met: list[tuple[str, list[str]]] = []
    step = 1
    while True:
        name, refused = await frozen_at(postgresql.new_database(), step)
        if not name:
            break
        met.append((name, refused))
        step += tries(3, 1)
    assert any(name.startswith(("SELECT", "INSERT INTO drops")) for name, _ in met), met
    assert any(refused for _, refused in met), "it was nowhere frozen before its commit"
