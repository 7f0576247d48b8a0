"""Who is told what of a commit: once, all that hangs together, and nobody for another's fault."""

import asyncio
import shutil
import threading
from pathlib import Path
from typing import Any

import pytest

from app.errors import LedgerError
from app.persistence.ledger.commit_queue import CommitQueue, Fate, Job, RevokedError
from app.persistence.ledger.writer import Ledger
from app.persistence.statements.store import last_number
from app.rooms.records import DropRow
from engine import Board
from tests.app.conftest import TINY
from tests.app.persistence.ledger.stepped import PATIENCE, Steps, Table
from tests.app.persistence.oracle import Told
from tests.waiting import LIMIT, eventually, turns

GONE = LedgerError("gone")


def at_once() -> float:
    return 0.0


def queue_of(*jobs: Job) -> CommitQueue:
    queue = CommitQueue()
    queue.open()
    for job in jobs:
        queue.put(job)
    return queue


def row(number: int) -> DropRow:
    return DropRow(1, number, 0, number)


async def table_over(empty: Path, folder: Path) -> Table:
    file = folder / "plinko.db"
    if not file.exists():
        shutil.copy(empty, file)
    table = Table(f"sqlite:///{file}", {"main": Told("main"), "triangle-8": Told("triangle-8")})
    await table.until(table.rooms.resume())
    return table


# The queue alone.


def test_nothing_is_put_in_before_the_remains_of_a_refusal_are_taken_out() -> None:
    first, second = Job([row(0)], [row(7)]), Job([row(1)], [row(8)])
    queue = queue_of(first, second)
    taken = queue.take(at_once)
    assert taken == [first, second]
    assert queue.give_up(GONE) == [first, second]
    with pytest.raises(LedgerError, match="gone"):
        queue.put(Job())
    with pytest.raises(RevokedError):
        queue.check(taken)
    queue.revoked()
    (undo,) = queue.take(at_once) or []
    assert undo.writes == [row(8), row(7)], "the latest first"
    told, mended = queue.done([undo])
    assert (told, mended) == ([undo], GONE)
    with pytest.raises(LedgerError):
        queue.put(Job())
    queue.open(GONE)
    queue.put(Job())


def test_a_commit_that_came_through_after_it_was_given_up_is_told_to_nobody_and_undone() -> None:
    job, kept = Job([row(0)], [row(7)]), Job([row(1)], keep=True)
    queue = queue_of(job, kept)
    taken = queue.take(at_once)
    assert taken is not None
    queue.give_up(GONE)
    assert queue.done(taken) == ([kept], None)
    assert job.fate is Fate.REFUSED
    (undo,) = queue.take(at_once) or []
    assert undo.writes == [row(7)]


def test_a_failure_that_comes_while_one_is_mended_opens_nothing_too_early() -> None:
    queue = queue_of(Job([row(0)], [row(7)]))
    queue.take(at_once)
    queue.failed(GONE)
    mending = queue.take(at_once)
    assert mending is not None
    queue.put(Job(read=last_number))
    again = LedgerError("again")
    queue.give_up(again)  # whoever reads has lost patience
    assert queue.done(mending) == (mending, None)
    queue.open(GONE)
    assert queue.failure is again
    (undo,) = queue.take(at_once) or []
    assert queue.done([undo])[1] is again


def test_what_is_kept_outlasts_every_failure_in_its_order() -> None:
    kept = [Job([row(number)], keep=True) for number in range(3)]
    queue = queue_of(kept[0], Job([row(9)], [row(7)]), kept[1])
    for _ in range(3):
        queue.take(at_once)
        queue.failed(GONE)
    queue.put(kept[2])
    undo, *rest = queue.take(at_once) or []
    assert (undo.writes, rest) == ([row(7)], kept), "and what was refused is undone once"


def test_writes_never_wait_for_more_than_one_read() -> None:
    reads = [Job(read=last_number) for _ in range(3)]
    queue = queue_of(*reads)
    assert queue.take(at_once) == [reads[0]]
    write = Job([row(0)])
    queue.put(write)
    assert queue.take(at_once) == [write]
    assert queue.take(at_once) == [reads[1]]


def test_a_read_never_overtakes_writes_that_were_put_in_before_it() -> None:
    write, read = Job([row(0)]), Job(read=lambda connection: None)
    queue = queue_of(write, read)
    pauses = iter([0.001, 0.0, 0.0])  # a commit was just made: the next is not due yet
    assert queue.take(lambda: next(pauses)) == [write]
    assert queue.take(lambda: next(pauses)) == [read]


def test_while_writes_fail_what_is_there_can_be_read() -> None:
    kept, read = Job([row(0)], keep=True), Job(read=lambda connection: None)
    queue = queue_of(kept)
    queue.take(at_once)
    queue.failed(GONE)
    queue.put(read)
    assert queue.take(lambda: 1.0) == [read]


# With rooms over it.


async def test_an_input_that_the_database_will_never_take_takes_the_later_ones_of_its_room_along(
    empty: Path, tmp_path: Path
) -> None:
    """A later one that stayed would leave a gap; other rooms' drops have nothing to do with it."""
    table = await table_over(empty, tmp_path)
    for seed in range(3):
        table.asks("main", seed)
        table.asks("triangle-8", 10 + seed)
        table.work()
    main = table.persistence.sessions.of(table.rooms.find("main")).number
    with table.database.transaction() as connection:
        connection.exec_driver_sql(
            f"INSERT INTO drops VALUES ({main}, 4, 0, '99', NULL, 0, NULL, NULL, 0)"
        )
    asked = {seed: table.asks("main", seed) for seed in range(3, 6)}
    others = [table.asks("triangle-8", seed) for seed in range(13, 16)]
    table.turn()
    assert table.asks("main", 6) is None, "not before the loop has heard of the refusal"
    table.work()
    assert table.ledger.up
    table.tick(3)
    await asyncio.sleep(0)
    assert [each is not None and each.exception() is None for each in others] == [True] * 3
    outcome = {seed: None if each is None else each.exception() for seed, each in asked.items()}
    assert outcome[3] is None
    assert all(isinstance(outcome[seed], LedgerError) for seed in (4, 5))
    assert len(table.rooms.find("main").planned) == 0
    table.end()


@pytest.mark.parametrize("change", ["reset", "delete"])
async def test_a_rooms_end_that_came_through_after_it_was_given_up_is_taken_back(
    change: str, empty: Path, tmp_path: Path
) -> None:
    table = await table_over(empty, tmp_path)
    room = await table.until(table.rooms.create(Board.from_json(TINY)))
    table.told[room.id] = Told(room.id)
    table.asks(room.id, 1, 100)
    await table.until_still()
    changed = asyncio.ensure_future(getattr(table.rooms, change)(room))
    while table.ledger.idle:  # the room that takes its place is made on another thread
        await turns()

    def stall(step: str) -> None:
        if step == "committed":
            table.loop.pass_time(2.0 * PATIENCE)

    table.database.at = stall
    table.turn()
    table.database.at = lambda step: None
    table.work()
    with pytest.raises(LedgerError, match="not answered"):
        await changed
    assert table.ledger.up
    assert table.rooms.find(room.id) is room
    table.asks(room.id, 2, 100)
    await table.until_still()
    table.end()
    again = await table_over(empty, tmp_path)
    again.told[room.id] = table.told[room.id]
    found = await again.until(again.rooms.seek(room.id))
    assert found.drops == 2
    again.end()


async def test_a_frozen_process_with_a_drop_waiting_refuses_nothing_and_is_ready_again(
    empty: Path, tmp_path: Path
) -> None:
    table = await table_over(empty, tmp_path)
    asked = table.asks("main", 1)
    table.loop.freeze(2.3)
    await table.until(table.ledger.probe())
    assert asked is not None
    assert (await asked).ball == 0
    table.end()


async def test_an_owner_that_fails_keeps_its_news_from_nobody(empty: Path, tmp_path: Path) -> None:
    table = await table_over(empty, tmp_path)

    def fail(error: LedgerError | None) -> None:
        raise ZeroDivisionError

    told: list[Any] = []
    table.ledger.submit([], fail)
    table.ledger.submit([], told.append)
    table.work()
    assert told == [None]
    table.end()


async def test_a_database_that_hangs_keeps_no_server_from_ending(
    empty: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.persistence.ledger.writer._FAREWELL", 0.01)
    shutil.copy(empty, tmp_path / "plinko.db")
    database = Steps(f"sqlite:///{tmp_path / 'plinko.db'}")
    ledger = Ledger(database, period=0.0, patience=PATIENCE)
    ledger.open()
    on = threading.Event()
    database.at = lambda step: _wait(on)
    ledger.start()
    ledger.defer([row(0)])
    await ledger.close()
    on.set()
    await eventually(lambda: not database.is_open)


def _wait(on: threading.Event) -> None:
    assert on.wait(LIMIT)
