"""The order in which rooms are rebuilt; the test decides when a rebuild continues."""

import asyncio

import pytest

from app.errors import DamagedRoomError, LedgerError, RebuildingError
from app.persistence.recovery.rebuild_queue import RebuildQueue, Turn
from app.rooms.records import Parked
from tests.kit.waiting import turns


def parked(room_id: str) -> Parked:
    return Parked(1, room_id, "board", "b" * 64, "independent", 0, 0, 0.0)


class Bench:
    """A queue of rooms with `slices` slices each; `done` lists the rooms of slices, in order."""

    def __init__(self, *rooms: str, slices: int = 3, patience: float = 60.0) -> None:
        self.done: list[str] = []
        self.rests = 0
        self.faults: dict[str, list[LedgerError]] = {}
        self.slices = slices
        self.go_on = asyncio.Event()
        self.queue = RebuildQueue(self.rebuild, patience=patience, sleep=self.rest)
        self.queue.fill(map(parked, rooms))

    async def rest(self, seconds: float) -> None:
        self.rests += 1
        await self.go_on.wait()

    async def rebuild(self, room_id: str, turn: Turn) -> None:
        if self.faults.get(room_id):
            raise self.faults[room_id].pop(0)
        for _ in range(self.slices):
            self.done.append(room_id)
            await turn()


async def test_all_come_back_one_after_another() -> None:
    bench = Bench("a", "b")
    bench.go_on.set()
    await bench.queue.run()
    assert bench.done == [*"aaabbb"]
    assert bench.queue.waiting == []
    await bench.queue.need("a")


async def test_a_requested_room_is_rebuilt_at_once() -> None:
    bench = Bench("a", "b", "c")
    running = asyncio.create_task(bench.queue.run())
    await turns()
    assert bench.done == ["a"], "and rests"
    bench.go_on.set()
    await bench.queue.need("c")
    assert bench.done[1:] == [*"ccc"]
    await running
    assert bench.done == [*"acccaabbb"]


async def test_a_waiting_room_goes_on_once_it_is_asked_for_too() -> None:
    bench = Bench("a", "b")
    running = asyncio.create_task(bench.queue.run())
    await turns()
    rebuild, held = bench.rebuild, asyncio.Event()

    async def slow(room_id: str, turn: Turn) -> None:
        await held.wait()
        await rebuild(room_id, turn)

    bench.queue._rebuild = slow
    second = asyncio.create_task(bench.queue.need("b"))
    bench.go_on.set()
    await turns()
    assert bench.done == ["a"], "b is asked for, a waits"
    await bench.queue.need("a")
    assert bench.done == [*"aaa"]
    held.set()
    await second
    await running
    assert bench.done == [*"aaabbb"]


async def test_a_ledger_that_cannot_be_read_is_asked_again() -> None:
    bench = Bench("a", "b")
    bench.go_on.set()
    bench.faults["a"] = [LedgerError("lost"), LedgerError("lost")]
    with pytest.raises(LedgerError, match="lost"):
        await bench.queue.need("a")
    assert "a" in bench.queue
    await bench.queue.run()
    assert bench.done == [*"aaabbb"]


async def test_requests_do_not_wait_for_a_damaged_room() -> None:
    bench = Bench("a", "b")
    bench.go_on.set()
    bench.faults["a"] = [DamagedRoomError("damaged")]
    asked = asyncio.create_task(bench.queue.need("a"))
    await bench.queue.run()
    with pytest.raises(DamagedRoomError, match="damaged"):
        await asked
    assert bench.done == [*"bbb"]
    assert bench.queue.waiting == []


async def test_a_rebuild_outlasts_a_request_that_timed_out() -> None:
    bench = Bench("a", patience=0.0)
    bench.slices = 1
    begun = asyncio.Event()
    rebuild = bench.rebuild

    async def slow(room_id: str, turn: Turn) -> None:
        await begun.wait()
        await rebuild(room_id, turn)

    bench.queue._rebuild = slow
    with pytest.raises(RebuildingError, match="room 'a' is being rebuilt"):
        await bench.queue.need("a")
    begun.set()
    bench.go_on.set()
    await bench.queue.run()
    assert bench.done == ["a"]


async def test_a_queue_that_is_stopped_leaves_nothing_running() -> None:
    bench = Bench("a", "b")
    running = asyncio.create_task(bench.queue.run())
    await turns()
    asked = asyncio.create_task(bench.queue.need("b"))
    await turns()
    running.cancel()
    with pytest.raises(asyncio.CancelledError):
        await running
    assert [each for each in asyncio.all_tasks() if each.get_name() in "ab"] == []
    asked.cancel()
    await asyncio.gather(asked, return_exceptions=True)
