"""A server that is attacked, killed and stalled for hours loses no ball.

`make test-attack HOURS=2` runs it for two hours. `make test` leaves it out: other tests try each
attack alone, without a server process.
"""

import asyncio
import itertools
import os
import random
import signal
from pathlib import Path
from typing import Final

import pytest

from benchmarks.scenes.expensive_boards import hall
from benchmarks.serving.attack.attackers import LOGGED
from benchmarks.serving.process import can_watch
from plinko.app.persistence.checks.audit import Audit
from plinko.app.persistence.checks.integrity import check_database
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.statements import store
from plinko.app.rooms.log import verify_log
from plinko.engine import Board
from tests.app.persistence.crash.siege import Siege
from tests.kit.process import ServerProcess

HOURS: Final = float(os.environ.get("PLINKO_TEST_HOURS", "0.05"))
LONG_LOG: Final = LOGGED if HOURS >= 0.5 else 1000  # drops
TOUCHING: Final = "interacting-triangle-8"
READERS: Final = f"100 logs of {LOGGED:,} drops"
READING: Final = 12.0  # s

# Few rooms, which are soon closed when unused: new rooms must replace older ones.
FLAGS: Final = ("--max-rooms", "100")
PROGRAM: Final = (
    "-c",
    "from plinko.app.live import stored_rooms; stored_rooms.REST_SECONDS = 60.0; "
    "from tests.kit import stakes; stakes.begin(); "
    "import plinko.__main__",
    *("serve", "--drop-rate", "1000"),
)


def board_that_ends_at_once() -> Board:
    return Board.from_json({**hall(), "name": "quick", "walls": hall()["walls"][:2]})


def besieged(file: Path, chance: random.Random, pause: float = 1.0) -> Siege:
    server = ServerProcess(f"sqlite:///{file}", FLAGS, PROGRAM)
    return Siege(server=server, file=file, chance=chance, pauses=(0.3, pause))


@pytest.mark.long("a server is attacked for minutes")
@pytest.mark.skipif(not can_watch(), reason="processor time is read from /proc")
@pytest.mark.timeout(3600 * (HOURS + 2))
async def test_whoever_attacks_every_ball_is_where_it_belongs(tmp_path: Path) -> None:
    file = tmp_path / "plinko.db"
    chance = random.Random(int(os.environ.get("PLINKO_TEST_SEED", "1")))
    siege = besieged(file, chance)
    with siege.server:
        await _fill(siege, LONG_LOG)
        siege.open(Board.preset("classic"))
        for room, board in (("main", "triangle-16"), ("triangle-8", "triangle-8")):
            siege.join(room, Board.preset(board))
        siege.join(TOUCHING, None)
        async with siege.playing():
            await siege.stand(3600 * HOURS)
        _hold_logs(siege)
        assert siege.server.end(signal.SIGTERM) == 0
        siege.server.start()
        assert siege.server.end(signal.SIGTERM) == 0
    _hold_ledger(siege, f"{HOURS:g} hours")


@pytest.mark.long("a server is attacked for minutes")
@pytest.mark.timeout(3600)
async def test_a_hundred_log_readers_cost_no_room_and_no_restart(tmp_path: Path) -> None:
    file = tmp_path / "plinko.db"
    siege = besieged(file, random.Random(1), pause=0.3)
    with siege.server:
        await _fill(siege, LOGGED)
        siege.join("main", Board.preset("triangle-16"))
        async with siege.playing():
            for how in (signal.SIGTERM, signal.SIGKILL, signal.SIGTERM):
                async with siege.attacked(READERS, "127.0.0.2"):
                    await asyncio.sleep(READING)  # no wait: the attack's duration
                await siege.until_all_take_drops()
                await siege.again(how)
                await siege.until_all_take_drops()
        _hold_logs(siege)
        assert siege.server.end(signal.SIGTERM) == 0
    _hold_ledger(siege, READERS)


async def _fill(siege: Siege, drops: int) -> None:
    """Fill a private room with a long log."""
    told = siege.open(board_that_ends_at_once())
    siege.logged = told.room
    filling = asyncio.create_task(siege.play(told, itertools.count(), 0.004))
    while len(told.accepted) < drops and not filling.done():
        await asyncio.sleep(0.1)
    filling.cancel()
    await asyncio.gather(filling, return_exceptions=True)


def _hold_logs(siege: Siege) -> None:
    """Verify every room's log, and compare it with the events that players received."""
    for name, told in siege.rooms.items():
        log = siege.server.get(f"/api/v1/rooms/{name}/log").json()
        found = verify_log(log)
        assert found.ok, f"{name}: {found}"
        if name not in siege.boards:
            said = {(each["seed"], each["tick"]) for each in told.accepted.values()}
            assert said <= {(each["input"]["seed"], each["tick"]) for each in log["inputs"]}


def _hold_ledger(siege: Siege, what: str) -> None:
    drops = siege.hold(siege.server.ledger, killed=True)
    database, audit = Database(siege.server.ledger), Audit()
    database.open()
    assert not check_database(database)
    with database.transaction() as connection:
        numbers = store.run_numbers(connection, tuple(siege.rooms))
    for number in numbers:
        audit.look(database, number, replay=False)
    database.close()
    assert not audit.findings
    print(  # noqa: T201
        f"\n{what}: {dict(siege.happened)}\nanswers: {dict(siege.answers)}\n"
        f"{siege.acknowledged} drops were announced, {drops} computed again, "
        f"{audit.drops} in the ledger, all are as they were announced; "
        f"slowest start {max(siege.server.starts):.1f} s"
    )
