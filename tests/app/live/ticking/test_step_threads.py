"""Rooms of many touching balls tick on other threads: they delay no room, no bit changes."""

import asyncio
import functools
import threading
from collections.abc import AsyncIterator, Iterator
from typing import Any

import pytest

from plinko.app.errors import AppError, ClosedRoomError
from plinko.app.live.live_arena import LiveArena
from plinko.app.live.registry import Rooms
from plinko.app.live.ticking.step_threads import StepThreads
from plinko.app.protocol.touching_messages import AddMessage
from plinko.app.rooms.kinds import SCENE
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.rooms.touching.world import NextTick
from plinko.engine import Board
from tests.app.asking import ask, change
from tests.app.passes import rooms_by_hand, run_pass
from tests.kit.waiting import LIMIT, eventually, turns

MAIN = Board.preset("triangle-8")
HEAP = {"scene": "sandbox", "balls": 60, "substeps": 8}


class Gate:
    """A gate where threads wait before they compute; `open(n)` lets n computations through."""

    def __init__(self) -> None:
        self._passes = threading.Semaphore(0)
        self.came = 0

    def open(self, count: int = 1) -> None:
        self._passes.release(count)

    def wait(self) -> None:
        self.came += 1
        assert self._passes.acquire(timeout=LIMIT)


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> Iterator[Gate]:
    gate = Gate()
    compute = NextTick.compute

    def waiting(self: NextTick) -> None:
        gate.wait()
        compute(self)

    monkeypatch.setattr(NextTick, "compute", waiting)
    yield gate
    gate.open(1_000)


@pytest.fixture
async def rooms() -> AsyncIterator[Rooms]:
    held = rooms_by_hand(MAIN)
    yield held
    await asyncio.to_thread(held.runner.close)


async def heap_of(rooms: Rooms) -> LiveArena:
    live = await rooms.create(rooms.scene(HEAP), SCENE)
    assert isinstance(live, LiveArena)
    assert live.room.steps_aside
    return live


def alone(ticks: int, *, ball_at: int | None = None) -> TouchingRoom:
    """The same heap computed on one thread, with a ball thrown in at a tick."""
    held = rooms_by_hand(MAIN)
    room = TouchingRoom("alone", held.scene(HEAP), tick_rate=60, max_balls=500)
    for tick in range(ticks):
        if tick == ball_at:
            room.plan_change(AddMessage(x=0.0, y=0.5)).durable = True
            room.enter()
        room.step(watched=False)
    return room


async def test_others_tick_during_a_long_step_and_its_room_catches_up(
    rooms: Rooms, gate: Gate
) -> None:
    heap, main = await heap_of(rooms), rooms.find("main")
    drop = ask(main, 1)
    await turns()
    for tick in range(4):
        run_pass(rooms.runner)
        assert (heap.room.world.tick, main.room.world.tick) == (0, tick + 1)
    assert drop.done()
    assert heap.room.checkpoint(), "it is read while another thread computes"
    gate.open(4)  # the missed ticks, which follow without a pass of the ticker
    await eventually(lambda: heap.room.world.tick == 4)
    assert heap.room.world.digest == alone(4).world.digest


async def test_a_room_that_is_slow_for_long_gives_ticks_up(rooms: Rooms, gate: Gate) -> None:
    heap = await heap_of(rooms)
    run_pass(rooms.runner, 5)
    run_pass(rooms.runner, 5)
    gate.open(100)
    await eventually(lambda: heap.room.world.tick == 5 and heap.room.ready)
    run_pass(rooms.runner)
    assert heap.room.world.tick == 6


async def test_an_input_enters_at_its_tick_during_the_next_step(rooms: Rooms, gate: Gate) -> None:
    heap = await heap_of(rooms)
    gate.open(100)
    await eventually(lambda: run_pass(rooms.runner) and heap.room.world.tick >= 3)
    await eventually(lambda: heap.room.ready)
    tick = heap.room.world.tick
    placed: Any = change(heap, AddMessage(x=0.0, y=0.5))
    await turns()
    (planned,) = heap.room.planned
    assert planned.tick == tick + rooms.persistence.lead
    await eventually(lambda: run_pass(rooms.runner) and heap.room.world.tick >= tick + 8)
    assert placed.done()
    assert placed.result().tick == planned.tick
    assert heap.room.world.digest == alone(heap.room.world.tick, ball_at=planned.tick).world.digest


async def test_a_room_is_closed_or_restarted_during_its_step(rooms: Rooms, gate: Gate) -> None:
    gone, anew = await heap_of(rooms), await heap_of(rooms)
    run_pass(rooms.runner)
    old = anew.room
    await rooms.delete(gone)
    await rooms.reset(anew)
    gate.open(100)
    await eventually(lambda: run_pass(rooms.runner) and anew.room.world.tick >= 3)
    assert (gone.room.world.tick, old.world.tick) == (0, 0), "nobody ticks what is gone"
    assert anew.room.world.digest == alone(anew.room.world.tick).world.digest
    # A room deleted while it restarts stays deleted.
    heap = await heap_of(rooms)
    begun, deleted = await asyncio.gather(
        rooms.reset(heap), rooms.delete(heap), return_exceptions=True
    )
    assert isinstance(begun, ClosedRoomError)
    assert deleted is None
    with pytest.raises(AppError):
        rooms.find(heap.id)


async def test_a_step_that_fails_in_a_thread_closes_only_its_room(
    rooms: Rooms, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    heap, other = await heap_of(rooms), await heap_of(rooms)

    def bad() -> None:
        raise ZeroDivisionError("a heap")

    copy: Any = heap.room.world.copy

    def broken() -> Any:
        world = copy()
        world.step = bad
        return world

    monkeypatch.setattr(heap.room.world, "copy", broken)
    await eventually(lambda: run_pass(rooms.runner) and other.room.world.tick >= 3)
    with pytest.raises(AppError):
        rooms.find(heap.id)
    assert "room failed and is closed" in caplog.text
    assert rooms.find(other.id) is other


async def test_rooms_have_equally_many_ticks_whatever_they_cost() -> None:
    threads, order, busy = StepThreads(1), list[str](), threading.Event()
    left = {"dear": 3, "one": 3, "two": 3}
    finished = asyncio.Semaphore(0)

    def ask(name: str) -> None:
        """Ask as a room does: for the next tick when the last one is finished."""
        if left[name]:
            left[name] -= 1
            threads.submit(name, functools.partial(order.append, name), lambda: ask(name))
        finished.release()

    threads.submit("busy", lambda: assert_passes(busy), lambda: None)
    for name in left:
        ask(name)
    busy.set()
    for _ in range(3 * 4):
        async with asyncio.timeout(LIMIT):
            await finished.acquire()
    threads.close()
    assert order == ["dear", "one", "two"] * 3


async def test_what_a_room_does_not_need_any_more_is_not_computed() -> None:
    threads, computed, busy = StepThreads(1), list[str](), threading.Event()
    finished = asyncio.Event()
    threads.submit("busy", lambda: assert_passes(busy), lambda: None)
    for name in ("worthless", "needed"):
        threads.submit("room", functools.partial(computed.append, name), finished.set)
    threads.submit("closed", functools.partial(computed.append, "closed"), finished.set)
    threads.forget("closed")
    busy.set()
    async with asyncio.timeout(LIMIT):
        await finished.wait()
    threads.close()
    assert computed == ["needed"]


def assert_passes(event: threading.Event) -> None:
    assert event.wait(LIMIT)


async def test_an_input_kept_at_the_server_s_stop_harms_no_room(
    rooms: Rooms, caplog: pytest.LogCaptureFixture
) -> None:
    heap = await heap_of(rooms)
    await eventually(lambda: run_pass(rooms.runner) and heap.room.world.tick >= 1)
    placed = change(heap, AddMessage(x=0.0, y=0.5))
    await turns()
    rooms.leave()
    while heap.room.planned:
        run_pass(rooms.runner)
        heap.room.step(watched=False)
    rooms.runner.guarded(heap, heap.admit)
    await turns()
    assert placed.done()
    assert rooms.find(heap.id) is heap
    assert heap.id not in caplog.text
