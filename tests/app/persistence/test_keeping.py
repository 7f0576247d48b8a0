"""When drops become facts and enter; the test decides when the ledger answers."""

import asyncio
from collections.abc import Callable, Sequence

import pytest

from plinko.app.errors import LedgerError
from plinko.app.persistence.ledger.commit_queue import Done
from plinko.app.protocol.messages import Accepted
from plinko.app.rooms.records import Mark, NewDrop, ResultRow, Write
from plinko.engine import Board, drop
from tests.app.asking import ask
from tests.app.passes import rooms_by_hand, run_pass
from tests.kit.null_ledger import NullLedger
from tests.kit.waiting import turns

BOARD = Board.preset("triangle-8")


class Patient(NullLedger):
    """A ledger whose writes wait until the test commits or refuses them."""

    def __init__(self) -> None:
        super().__init__()
        self.waiting: list[asyncio.Future[None]] = []
        self.written: list[Write] = []
        self.kept: list[Callable[[], None]] = []

    async def drop(self, request: NewDrop, *before: Write) -> NewDrop:
        self.waiting.append(asyncio.get_running_loop().create_future())
        await self.waiting[-1]
        return await super().drop(request, *before)

    def defer(self, writes: Sequence[Write], done: Done | None = None) -> None:
        self.written += writes
        super().defer(writes, done)

    async def answer(self, error: LedgerError | None = None) -> None:
        asked = self.waiting.pop(0)
        if error is None:
            asked.set_result(None)
        else:
            asked.set_exception(error)
        await turns()


class Table:
    """Rooms over a Patient ledger, ticked by hand."""

    def __init__(self) -> None:
        self.ledger = Patient()
        self.rooms = rooms_by_hand(BOARD, ledger=self.ledger)
        self.live = self.rooms.find("main")
        self.room = self.live.room

    def tick(self, times: int = 1) -> None:
        for _ in range(times):
            run_pass(self.rooms.runner)

    async def ask(self, seed: int) -> "asyncio.Task[Accepted]":
        asked = ask(self.live, seed)
        await turns()
        return asked


@pytest.mark.parametrize("latency", [0, 1, 2, 30])
async def test_a_start_s_tick_does_not_depend_on_the_ledger_s_speed(latency: int) -> None:
    table = Table()
    await table.ask(1)
    await table.ledger.answer()
    table.tick(10)
    asked = await table.ask(2)
    table.tick(latency)
    await table.ledger.answer()
    table.tick(3)
    assert (await asked).tick == 11
    assert table.room.world.tick == 10 + latency + 3, "balls that fall wait for nobody"
    (state,) = drop(BOARD, 2).states([(table.room.world.tick - 11) / 60])
    assert table.room.world.bodies["x"][1] == state["x"], "late, it is where it would be"


async def test_a_tick_late_by_ten_seconds_shows_the_present() -> None:
    table = Table()
    for seed in range(3):
        await table.ask(seed)
        await table.ledger.answer()
    run_pass(table.rooms.runner, 600)
    await turns()
    assert (table.room.world.tick, table.room.world.count) == (600, 0)
    landed = [row for row in table.ledger.written if isinstance(row, ResultRow)]
    assert {row.digest for row in landed} == {drop(BOARD, seed).digest for seed in range(3)}
    assert max(row.tick for row in landed) < 600, "each at its own tick"


async def test_a_sleeping_room_leaves_all_that_its_next_run_needs() -> None:
    table = Table()
    for seed in range(3):
        await table.ask(seed)
        await table.ledger.answer()
    table.rooms.persistence.runs.of(table.room).known = True
    while table.room.awake:
        table.tick()
        await turns()
    mark = table.ledger.written[-1]
    assert isinstance(mark, Mark)
    assert (mark.awake, mark.tick, mark.checkpoint) == (False, table.room.log_tick, None)
    results = [row for row in table.ledger.written if isinstance(row, ResultRow)]
    assert [row.digest for row in sorted(results, key=lambda row: row.ball)] == [
        drop(BOARD, seed).digest for seed in range(3)
    ]
