"""A room that is expensive to compute slows down at most itself."""

import asyncio
import threading
from typing import Any

import numpy as np
import pytest

from benchmarks.scenes.expensive_boards import hall
from plinko.app.errors import AppError, BallLimitError, BusyError
from plinko.app.live import live_table
from plinko.app.live.ticking import runner
from plinko.app.protocol import messages
from plinko.app.protocol.paths import Path, path_of
from plinko.app.rooms import independent
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.kinds import INTERACTING
from plinko.app.rooms.pending import DropCommand
from plinko.engine import Board, drop
from plinko.engine.drops import sliced
from plinko.engine.drops.flight import Flight
from plinko.engine.drops.sliced import SlicedFlight
from tests.app.asking import ask
from tests.app.passes import rooms_by_hand, run_pass
from tests.kit.hand import HandClock
from tests.kit.waiting import LIMIT, turns

MAIN = Board.preset("triangle-8")
HALL = Board.from_json(hall())
CALL = 1e-4  # s that each reading of the clock takes, as long as a slice of a path


class Clock(HandClock):
    """A clock that advances by CALL each time it is read."""

    def __call__(self) -> float:
        self.time += CALL
        return super().__call__()


async def test_a_lagging_room_catches_up_within_its_share_of_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    rooms = rooms_by_hand(MAIN, clock)
    heap = await rooms.create(MAIN, INTERACTING)
    asked = [ask(room, 1) for room in (heap, rooms.find("main"))]
    await turns()
    run_pass(rooms.runner)
    step = heap.room.step

    def slow(*, watched: bool) -> list[messages.Event]:
        clock.time += 0.03
        return step(watched=watched)

    monkeypatch.setattr(heap.room, "step", slow)
    before = heap.room.world.tick, rooms.find("main").room.world.tick
    run_pass(rooms.runner, 5)
    after = heap.room.world.tick, rooms.find("main").room.world.tick
    assert after == (before[0] + 2, before[1] + 5)
    assert all(each.done() for each in asked)


async def test_main_and_requests_come_before_an_expensive_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    rooms = rooms_by_hand(MAIN, clock)
    main = rooms.find("main")
    dear = [await rooms.create(MAIN, INTERACTING) for _ in range(2)]
    asked = [ask(room, 0) for room in (main, *dear)]
    await turns()
    run_pass(rooms.runner)
    before = [room.room.world.tick for room in (main, *dear)]

    def slow(*, watched: bool) -> list[messages.Event]:
        clock.time += 0.003
        return []

    for room in dear:
        monkeypatch.setattr(room.room, "step", slow)
    clock.tick()
    times = [clock.time]
    for awake in rooms.runner.tick(1):
        if len(times) == 1:
            now = [room.room.world.tick for room in (main, *dear)]
            assert now == [before[0] + 1, *before[1:]]
        times.append(clock.time)
        assert awake
    # Main's turn is short; then come the turns of the two rooms that take 3 ms.
    assert [each > 0.003 for each in np.diff(times)] == [False, True, True]
    assert all(each.done() for each in asked)


async def test_requests_between_rooms_do_not_delay_the_next_tick() -> None:
    clock = Clock()
    rooms = rooms_by_hand(MAIN, clock)
    others = [await rooms.create(MAIN, INTERACTING) for _ in range(4)]
    asked = [ask(room, 0) for room in (rooms.find("main"), *others)]
    await turns()
    run_pass(rooms.runner)

    def ticked(requests: float) -> int:
        """How many rooms tick in a pass when requests take this many seconds."""
        before = [room.room.world.tick for room in others]
        clock.tick()
        for _ in rooms.runner.tick(1):
            clock.time += requests
        return sum(a < room.room.world.tick for a, room in zip(before, others, strict=True))

    assert ticked(0.0) == 4
    # Half of the time to main's next tick is over: only the room whose turn it is ticks.
    assert ticked(0.009) == 1
    assert ticked(0.0) == 4
    assert all(each.done() for each in asked)


async def test_long_flights_fill_no_memory_and_stop_no_other_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rooms = rooms_by_hand(MAIN, Clock())
    dear = [await rooms.create(HALL) for _ in range(2)]
    for room in dear:
        await ask(room, 0)
    run_pass(rooms.runner)
    kept = sum(room.room.events_kept for room in dear)
    monkeypatch.setattr(runner, "MOST_EVENTS", kept // 2)
    with pytest.raises(BusyError, match=rf"in all rooms have {kept} events"):
        await ask(dear[0], 1)
    await ask(rooms.find("main"), 0)
    monkeypatch.setattr(runner, "MOST_EVENTS", kept // 8)
    with pytest.raises(BusyError, match=r"in all rooms have \d+ events"):
        await ask(rooms.find("main"), 1)


async def test_a_long_flight_is_computed_on_a_thread_and_holds_up_no_tick(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gate, finish = threading.Event(), live_table._finish

    def slow(flight: SlicedFlight) -> Flight:
        assert gate.wait(LIMIT)
        return finish(flight)

    monkeypatch.setattr(live_table, "_finish", slow)
    rooms = rooms_by_hand(MAIN, Clock())
    dear, main = await rooms.create(HALL), rooms.find("main")
    asked = [ask(dear, seed) for seed in (4, 5)]
    await ask(main, 1)
    for _ in range(10):
        before = main.room.world.tick
        run_pass(rooms.runner)
        assert main.room.world.tick == before + 1
    assert not any(each.done() for each in asked), "no ball is announced before its flight is known"
    gate.set()
    accepted = await asyncio.gather(*asked)
    assert [each.ball for each in accepted] == [0, 1]
    run_pass(rooms.runner)
    alone = drop(HALL, 4)
    (state,) = alone.states([(dear.room.world.tick - accepted[0].tick) / 60])
    assert dear.room.world.bodies["x"][0] == state["x"], "it enters late, where it would be"


@pytest.mark.parametrize("seed", [4, 5])
async def test_a_long_path_is_cut_on_a_thread_and_a_short_one_only_when_needed(
    monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    threads: list[threading.Thread] = []
    cut = path_of

    def noted(*args: Any) -> Path:
        threads.append(threading.current_thread())
        return cut(*args)

    for module in (live_table, independent):
        monkeypatch.setattr(module, "path_of", noted)
    rooms = rooms_by_hand(MAIN, Clock())
    dear, main = await rooms.create(HALL), rooms.find("main")
    await asyncio.gather(ask(dear, seed), ask(main, 1))
    assert len(threads) == 1
    assert threads[0] is not threading.main_thread()
    await dear.cut_paths()
    assert len(threads) == 1, "its room has it"
    await main.cut_paths()
    assert threads[1:] == [threading.main_thread()]


def test_a_table_whose_flights_are_long_takes_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(independent, "MOST_EVENTS", 500)
    room = IndependentRoom("dear", HALL, tick_rate=60, max_balls=9)
    room.drop(DropCommand(4))
    with pytest.raises(BallLimitError, match=r"have \d+ events, more than 500"):
        room.drop(DropCommand(2))


SHAFT = {
    "name": "shaft",
    "width": 4e-3,
    "height": 1.0,
    "ball": {"radius": 1e-3, "restitution": 1.0},
    "pegs": [{"x": x, "y": 1.02, "radius": 1e-4} for x in (0.0, 5e-4)],
    "walls": [
        {"x1": -5e-3, "y1": 0.969, "x2": 2.5e-3, "y2": 0.97},
        *({"x1": x, "y1": -0.01, "x2": x, "y2": 1.0} for x in (-5e-3, 5e-3)),
    ],
    "wall_material": {"restitution": 1.0},
    "bins": {"y": 1.0, "edges": [-5e-3, 0.0, 5e-3], "multipliers": [1.0, 1.0]},
    "drop": {"x": -1.25e-3, "y": 0.0, "jitter": 1e-4},
}
"""A ball's way between two impacts is hundreds of times as long as the ball is wide. The pegs,
below the bins, make search windows as short as the ball."""


async def test_a_board_with_too_slow_an_impact_closes_its_room(
    limited_calls: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sliced, "EFFORT", 50_000)
    rooms = rooms_by_hand(MAIN, Clock())
    main, dear = rooms.find("main"), await rooms.create(Board.from_json(SHAFT))
    await ask(main, 1)
    with pytest.raises(AppError, match="was closed: too much to compute"):
        await ask(dear, 1)
    assert not rooms.is_open(dear.id)
    before = main.room.world.tick
    run_pass(rooms.runner)
    assert main.room.world.tick == before + 1
