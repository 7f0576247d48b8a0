"""The commit queue gives every write one outcome, the same for writes that depend on another."""

import shutil
import threading
from pathlib import Path
from typing import Any

import pytest

from plinko.app.errors import LedgerError, UnknownRoomError
from plinko.app.persistence.ledger.commit_queue import CommitQueue, Fate, Job, RevokedError
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements.store import last_number
from plinko.app.rooms.log import verify_log
from plinko.app.rooms.records import DropRow, NewDrop, Order
from plinko.engine import Board
from tests.app.conftest import TINY
from tests.app.persistence.ledger.stepped import PATIENCE, Steps, Table
from tests.kit.facts import new
from tests.kit.told import Told
from tests.kit.waiting import LIMIT, eventually

GONE = LedgerError("gone")


def at_once() -> float:
    return 0.0


def queue_of(*jobs: Job) -> CommitQueue:
    queue = CommitQueue()
    queue.open()
    for job in jobs:
        queue.put(job)
    return queue


def row(number: int) -> NewDrop:
    return new(DropRow(1, number, 0, number))


def table_over(empty: Path, folder: Path) -> Table:
    file = folder / "plinko.db"
    if not file.exists():
        shutil.copy(empty, file)
    table = Table(f"sqlite:///{file}", {"main": Told("main"), "triangle-8": Told("triangle-8")})
    table.until(table.rooms.resume())
    table.until(table.rooms.seek("triangle-8"))
    return table


# The queue alone.


def test_an_input_refused_before_its_commit_is_never_sent() -> None:
    first, second = Job([row(0)]), Job([row(1)])
    queue = queue_of(first, second)
    taken = queue.take(at_once)
    assert taken == [first, second]
    assert queue.give_up(GONE) == [first, second]
    with pytest.raises(LedgerError, match="gone"):
        queue.put(Job())
    with pytest.raises(RevokedError):
        queue.send(taken)
    queue.revoked()
    assert queue.take(at_once) == [], "a probe, and nothing of what was refused"
    assert queue.done([]) is GONE
    with pytest.raises(LedgerError):
        queue.put(Job())
    queue.open(GONE)
    queue.put(Job())


def test_what_was_sent_is_not_refused_by_a_loss_of_patience() -> None:
    sent, kept, waiting = Job([row(0)]), Job([row(1)], keep=True), Job([row(2)])
    queue = queue_of(sent, kept)
    taken = queue.take(at_once)
    assert taken is not None
    queue.send(taken)
    queue.put(waiting)
    assert queue.give_up(GONE) == [waiting]
    assert queue.done(taken) is GONE
    assert (sent.fate, kept.fate, waiting.fate) == (Fate.DONE, Fate.DONE, Fate.REFUSED)


def test_a_failure_after_a_commit_came_back_does_not_end_with_it() -> None:
    queue = queue_of(Job([row(0)]))
    queue.take(at_once)
    queue.failed(GONE)
    probe = queue.take(at_once)
    assert probe == []
    outlived = queue.done(probe)
    queue.put(Job(read=last_number))
    again = LedgerError("again")
    queue.give_up(again)  # the reader has waited too long
    assert outlived is GONE
    queue.open(outlived)
    assert queue.failure is again
    assert queue.done(queue.take(at_once) or []) is again


def test_what_is_kept_outlasts_every_failure_in_its_order() -> None:
    kept = [Job([row(number)], keep=True) for number in range(3)]
    queue = queue_of(kept[0], Job([row(9)]), kept[1])
    for _ in range(3):
        taken = queue.take(at_once) or []
        queue.send(taken)
        queue.failed(GONE)
    queue.put(kept[2])
    assert queue.take(at_once) == kept


def test_what_waits_is_refused_while_a_commit_is_in_doubt() -> None:
    sent, waiting, read = Job([row(0)]), Job([row(1)]), Job(read=last_number)
    queue = queue_of(sent)
    taken = queue.take(at_once) or []
    queue.send(taken)
    queue.put(waiting)
    queue.put(read)
    assert queue.doubted(GONE) == [waiting]
    assert (sent.fate, read.fate) == (Fate.SENT, Fate.OPEN)
    assert queue.failed(GONE) == [sent], "once it is known that it is not there"


def test_writes_never_wait_for_more_than_one_read() -> None:
    reads = [Job(read=last_number) for _ in range(3)]
    queue = queue_of(*reads)
    assert queue.take(at_once) == [reads[0]]
    write = Job([row(0)])
    queue.put(write)
    assert queue.take(at_once) == [write]
    assert queue.take(at_once) == [reads[1]]


def test_a_read_never_overtakes_writes_queued_before_it() -> None:
    write, read = Job([row(0)]), Job(read=lambda connection: None)
    queue = queue_of(write, read)
    pauses = iter([0.001, 0.0, 0.0])  # right after a commit, the next one is not yet due
    assert queue.take(lambda: next(pauses)) == [write]
    assert queue.take(lambda: next(pauses)) == [read]


def test_while_writes_fail_what_is_there_can_be_read() -> None:
    kept, read = Job([row(0)], keep=True), Job(read=lambda connection: None)
    queue = queue_of(kept)
    queue.take(at_once)
    queue.failed(GONE)
    queue.put(read)
    assert queue.take(lambda: 1.0) == [read]


# The queue with rooms.


def test_a_drop_that_cannot_be_written_is_refused_and_no_other(empty: Path, tmp_path: Path) -> None:
    """It never had a number, so there is no gap, and nothing is taken back."""
    table = table_over(empty, tmp_path)
    for seed in range(3):
        table.asks("main", seed)
        table.asks("triangle-8", 10 + seed)
        table.work()
    asked = [table.asks("main", 3), table.asks("main", 4, -1), table.asks("main", 5)]
    others = [table.asks("triangle-8", seed) for seed in range(13, 16)]
    table.work()
    assert table.ledger.up
    table.tick(3)
    assert [each is not None and each.exception() is None for each in others] == [True] * 3
    assert isinstance(asked[1] and asked[1].exception(), LedgerError)
    balls = [each.result().accepted.ball for each in (asked[0], asked[2]) if each]
    assert balls == [3, 4]
    table.end()


@pytest.mark.parametrize("change", ["reset", "delete"])
def test_a_room_s_end_once_sent_stays_however_late_its_answer(
    change: str, empty: Path, tmp_path: Path
) -> None:
    table = table_over(empty, tmp_path)
    room = table.until(table.rooms.create(Board.from_json(TINY)))
    table.told[room.id] = Told(room.id)
    table.asks(room.id, 1, 100)
    table.until_still()
    closing: list[str] = []

    def stall(step: str) -> None:
        closing.extend([step] * step.startswith("UPDATE rooms SET closed"))
        if step == "committed" and closing:
            closing.clear()
            table.loop.pass_time(2.0 * PATIENCE)

    table.database.at = stall
    table.until(getattr(table.rooms, change)(room))
    table.database.at = lambda step: None
    table.work()
    assert table.ledger.up
    if change == "delete":
        with pytest.raises(UnknownRoomError):
            table.rooms.find(room.id)
    else:
        assert table.rooms.find(room.id).room.drops == 0
    table.end()
    again = table_over(empty, tmp_path)
    again.told[room.id] = table.told[room.id]
    if change == "reset":
        assert again.until(again.rooms.seek(room.id)).room.drops == 0
    again.end()


def test_a_frozen_process_with_a_waiting_drop_refuses_nothing(empty: Path, tmp_path: Path) -> None:
    table = table_over(empty, tmp_path)
    asked = table.asks("main", 1)
    table.loop.freeze(2.3)
    table.until(table.ledger.commit())
    assert asked is not None
    assert asked.result().accepted.ball == 0
    table.end()


def test_a_failing_callback_does_not_stop_the_others(empty: Path, tmp_path: Path) -> None:
    table = table_over(empty, tmp_path)

    def fail(error: LedgerError | None) -> None:
        raise ZeroDivisionError

    told: list[Any] = []
    table.ledger.defer([Order("halt", "a", 1.0)], fail)
    table.ledger.defer([Order("halt", "b", 1.0)], told.append)
    table.work()
    assert told == [None]
    table.end()


async def test_a_database_that_hangs_keeps_no_server_from_ending(
    empty: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plinko.app.persistence.ledger.writer._CLOSE_SECONDS", 0.01)
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


def test_while_a_drop_is_in_doubt_balls_fall_and_it_enters_late(
    empty: Path, tmp_path: Path
) -> None:
    table = table_over(empty, tmp_path)
    table.asks("main", 1)
    table.work()
    room = table.rooms.find("main")
    table.tick(10)
    asked = table.asks("main", 2)
    assert asked is not None

    def stall(step: str) -> None:
        if step == "committed":
            table.loop.pass_time(2.0 * PATIENCE)
            table.tick(30)

    table.database.at = stall
    table.turn()
    table.database.at = lambda step: None
    assert room.room.world.tick >= 40, "the room did not wait"
    assert not asked.done()
    table.work()
    assert 10 < asked.result().accepted.tick < 40
    table.until_still()
    assert verify_log(table.log("main")).ok
    table.end()
