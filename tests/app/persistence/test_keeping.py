"""When drops enter, and how rooms are rebuilt; the test decides when the ledger answers."""

import asyncio
from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.errors import LedgerError
from app.live.broadcast.hub import Hub
from app.live.registry import Rooms
from app.persistence.ledger.commit_queue import Done
from app.persistence.ledger.null_ledger import NullLedger
from app.persistence.recovery.rebuild import Taken, rebuild
from app.persistence.service import PersistenceService
from app.protocol.messages import Accepted, Landed
from app.rooms.boards import Boards
from app.rooms.independent import IndependentRoom
from app.rooms.kinds import BallLimits
from app.rooms.pending import DropCommand
from app.rooms.records import DropRow, Mark, ResultRow, RoomRow, Write
from app.settings import Settings
from engine import PHYSICS_VERSION, Board, drop
from tests.app.asking import ask
from tests.app.passes import run_pass
from tests.kit.waiting import turns

BOARD = Board.preset("triangle-8")
LIMITS = BallLimits(200, 200)


class Patient(NullLedger):
    """A ledger whose writes wait until the test commits or refuses them."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Sequence[Write], asyncio.Future[None]]] = []
        self.written: list[Write] = []

    def submit(self, *writes: Write, line: int | None = None) -> "asyncio.Future[None]":
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.waiting.append((writes, future))
        return future

    def defer(self, writes: Sequence[Write], done: Done | None = None) -> None:
        self.written += writes
        if done is not None:
            done(None)

    async def answer(self, error: LedgerError | None = None) -> None:
        writes, asked = self.waiting.pop(0)
        if error is None:
            self.written += writes
            asked.set_result(None)
        else:
            asked.set_exception(error)
        await turns()


class Table:
    """Rooms over a Patient ledger, ticked by hand."""

    def __init__(self) -> None:
        self.ledger = Patient()
        persistence = PersistenceService(self.ledger, tick_rate=60, limits=LIMITS)
        self.rooms = Rooms(Settings(), Boards(8), Hub(8), BOARD, persistence=persistence)
        self.live = self.rooms.find("main")
        self.room = self.live.room

    def tick(self, times: int = 1) -> None:
        for _ in range(times):
            run_pass(self.rooms.runner)

    async def ask(self, seed: int) -> "asyncio.Task[Accepted]":
        asked = ask(self.live, seed)
        await turns()
        return asked


async def test_a_drop_is_accepted_only_when_it_is_durable() -> None:
    table = Table()
    asked = await table.ask(1)
    table.tick(5)
    assert not asked.done()
    assert (table.room.world.tick, table.room.world.count) == (0, 0), "a sleeping room sleeps on"
    await table.ledger.answer()
    assert (await asked).tick == 0


@pytest.mark.parametrize("latency", [0, 1, 2, 30])
async def test_a_start_s_tick_does_not_depend_on_the_ledger_s_speed(
    latency: int,
) -> None:
    table = Table()
    await table.ask(1)
    await table.ledger.answer()
    table.tick(10)
    asked = await table.ask(2)
    table.tick(latency)
    await table.ledger.answer()
    table.tick(3)
    assert (await asked).tick == 11
    (row,) = [row for row in table.ledger.written if isinstance(row, DropRow) and row.seed == 2]
    assert row.tick == 11, "and it is the one in the ledger"
    assert table.room.world.tick == 10 + latency + 3, "balls that fall wait for nobody"


async def test_while_a_start_is_undecided_the_others_fall_on() -> None:
    table = Table()
    await table.ask(1)
    await table.ledger.answer()
    table.tick(10)
    asked = await table.ask(2)
    table.tick(20)
    assert table.room.world.tick == 30
    await table.ledger.answer(LedgerError("lost"))
    with pytest.raises(LedgerError, match="lost"):
        await asked
    table.tick(5)
    assert table.room.world.tick == 35, "refused, the room goes on without it"
    assert table.room.drops == 1


async def test_no_tick_is_shown_before_the_ledger_allows_it() -> None:
    table = Table()
    defer = table.ledger.defer
    await table.ask(1)
    await table.ledger.answer()
    table.ledger.defer = lambda writes, done=None: None  # type: ignore[method-assign]
    table.tick(100)
    assert table.room.world.tick == 30, "half a second was written ahead with the drop"
    table.ledger.up = False
    table.tick(10)
    assert table.room.world.tick == 40, "with the ledger lost the room can still be watched"
    table.ledger.up = True
    table.ledger.defer = defer  # type: ignore[method-assign]
    table.tick(60)
    assert table.room.world.tick > 80
    assert all(
        row.tick >= table.room.world.tick
        for row in table.ledger.written[-1:]
        if isinstance(row, Mark)
    )


async def test_a_slow_ledger_is_not_given_more_marks_than_it_needs() -> None:
    table = Table()
    asked = await table.ask(1)
    await table.ledger.answer()
    await asked
    unanswered: list[Any] = []

    def defer(writes: Sequence[Write], done: Done | None = None) -> None:
        if done is not None:
            unanswered.append(done)

    answered, table.ledger.defer = table.ledger.defer, defer  # type: ignore[method-assign]
    record = table.rooms.persistence.runs.of(table.room)
    record.horizon = 1 << 30  # so that it ticks without waiting for the ledger
    for _ in range(100):
        table.rooms.persistence.ticked(60, [table.room])
    assert len(unanswered) == 8
    for done in unanswered:
        done(None)
    table.ledger.defer = answered  # type: ignore[method-assign]
    before = len(table.ledger.written)
    table.rooms.persistence.ticked(60, [table.room])
    assert len(table.ledger.written) > before


async def test_a_sleeping_room_leaves_all_that_its_next_run_needs() -> None:
    table = Table()
    for seed in range(3):
        await table.ask(seed)
        await table.ledger.answer()
    while table.room.awake:
        table.tick()
    mark = table.ledger.written[-1]
    assert isinstance(mark, Mark)
    assert (mark.awake, mark.tick, mark.checkpoint_drops) == (False, table.room.world.tick, 3)
    again = IndependentRoom("main", BOARD, tick_rate=60, max_balls=200)
    assert mark.checkpoint is not None
    again.restore(mark.checkpoint)
    assert again.stats() == table.room.stats()
    assert again.world.digest() == table.room.world.digest()
    results = [row for row in table.ledger.written if isinstance(row, ResultRow)]
    assert [row.digest for row in sorted(results, key=lambda row: row.ball)] == [
        drop(BOARD, seed).digest for seed in range(3)
    ]


def row_of(room: IndependentRoom, tick: int, checkpoint: bytes | None, drops: int) -> RoomRow:
    return RoomRow(
        number=1,
        id=room.id,
        board=BOARD.digest,
        mode="independent",
        owned=False,
        tick_rate=60,
        physics_version=PHYSICS_VERSION,
        opened=0.0,
        used=0.0,
        awake=True,
        tick=tick,
        checkpoint=checkpoint,
        checkpoint_drops=drops,
    )


@given(
    plays=st.lists(
        st.tuples(st.integers(0, 2**64 - 1), st.integers(0, 200)), min_size=1, max_size=6
    ),
    crash=st.floats(0.0, 1.0),
    save=st.floats(0.0, 1.0),
    ahead=st.integers(0, 40),
)
@settings(max_examples=25)
def test_wherever_it_is_cut_a_rebuilt_room_is_the_one_that_was(
    plays: list[tuple[int, int]], crash: float, save: float, ahead: int
) -> None:
    """From any checkpoint before any crash, the world has the same bits and the same results.

    The original room is stepped to the tick of the rebuilt one, and compared.
    """
    room = IndependentRoom("r", BOARD, tick_rate=60, max_balls=200)
    kept: list[tuple[DropRow, ResultRow | None]] = []
    landed: list[Landed] = []
    checkpoint: tuple[bytes | None, int] = (None, 0)
    end = sum(pause for _, pause in plays)
    for seed, pause in plays:
        pending = room.plan_drop(DropCommand(seed))
        pending.durable = True
        room.enter()
        kept.append((room.format.row(1, pending), None))
        for _ in range(pause):
            if not room.awake or room.world.tick >= crash * end:
                break
            if room.world.tick == int(save * crash * end):
                checkpoint = (room.checkpoint(), room.drops)
            landed += [each for each in room.step(watched=True) if isinstance(each, Landed)]
    told = room.world.tick
    row = row_of(room, told + ahead, *checkpoint)
    rebuilt = rebuild(row, BOARD, kept, limits=LIMITS)
    assert rebuilt.room.world.tick >= told, "no tick that was shown is taken back"
    while room.world.tick < rebuilt.room.world.tick:
        landed += [each for each in room.step(watched=False) if isinstance(each, Landed)]
    assert rebuilt.room.world.tick == room.world.tick
    assert rebuilt.room.world.digest() == room.world.digest()
    assert rebuilt.room.stats() == room.stats()
    assert rebuilt.differences == []
    wanted = {each.ball: room.format.result(1, each) for each in landed}
    assert {each.ball: each for each in rebuilt.take_results()}.items() <= wanted.items()


def test_a_result_that_is_not_reproduced_is_reported() -> None:
    room = IndependentRoom("r", BOARD, tick_rate=60, max_balls=200)
    room.drop(DropCommand(1))
    landed = []
    while room.awake:
        landed += [each for each in room.step(watched=False) if isinstance(each, Landed)]
    true = room.format.result(1, landed[0])
    lie = ResultRow(**{name: getattr(true, name) for name in true.__slots__} | {"bin": 99})
    for result, wanted in ((true, 0), (lie, 1)):
        kept: Taken = [(DropRow(1, 0, 0, 1), result)]
        rebuilt = rebuild(row_of(room, 10_000, None, 0), BOARD, kept, limits=LIMITS)
        assert len(rebuilt.differences) == wanted
        assert rebuilt.take_results() == []
