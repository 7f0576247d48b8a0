"""A room whose balls bounce a hundred thousand times slows down, but no other room."""

import asyncio
from typing import Any

import numpy as np
import pytest

from app.errors import AppError, BallLimitError, BusyError
from app.live.broadcast.hub import Hub
from app.live.registry import Rooms
from app.live.ticking import runner
from app.protocol import messages
from app.rooms import independent
from app.rooms.boards import Boards
from app.rooms.independent import IndependentRoom
from app.rooms.kinds import INTERACTING
from app.rooms.pending import DropCommand
from app.settings import Settings
from benchmarks.scenes.expensive_boards import hall
from engine import Board, World, drop
from engine.drops import sliced
from engine.physics import body
from engine.world.exact_path import KEPT, SLICE
from tests.app.asking import ask
from tests.app.passes import run_pass
from tests.kit.waiting import turns

MAIN = Board.preset("triangle-8")
HALL = Board.from_json(hall())
CALL = 1e-4  # s that each reading of the clock takes, as long as a slice of a path


class Clock:
    """A clock that advances by CALL each time it is read."""

    def __init__(self) -> None:
        self.time = 0.0

    def __call__(self) -> float:
        self.time += CALL
        return self.time


def followed(room: Any) -> int:
    """How many events of the balls in flight are computed."""
    assert isinstance(room.world, World)
    return sum(path.sliced.events for path in room.world._exact()._paths)


async def test_a_lagging_room_catches_up_within_its_share_of_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    rooms = Rooms(Settings(), Boards(8), Hub(8), MAIN, clock=clock)
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
    assert (heap.room.world.tick, rooms.find("main").room.world.tick) == (
        before[0] + 2,
        before[1] + 5,
    )
    assert all(each.done() for each in asked)


async def test_main_and_requests_come_before_an_expensive_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    rooms = Rooms(Settings(), Boards(8), Hub(8), MAIN, clock=clock)
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
    rooms = Rooms(Settings(), Boards(8), Hub(8), MAIN, clock=clock)
    others = [await rooms.create(MAIN, INTERACTING) for _ in range(4)]
    asked = [ask(room, 0) for room in (rooms.find("main"), *others)]
    await turns()
    run_pass(rooms.runner)

    def ticked(requests: float) -> int:
        """How many rooms tick in a pass when requests take this many seconds."""
        before = [room.room.world.tick for room in others]
        for _ in rooms.runner.tick(1):
            clock.time += requests
        return sum(a < room.room.world.tick for a, room in zip(before, others, strict=True))

    assert ticked(0.0) == 4
    # Half of the time to main's next tick is over: only the room whose turn it is ticks.
    assert ticked(0.009) == 1
    assert ticked(0.0) == 4
    assert all(each.done() for each in asked)


async def test_all_rooms_together_keep_a_bounded_number_of_events(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(runner, "MOST_EVENTS", 600)
    rooms = Rooms(Settings(), Boards(8), Hub(8), MAIN, clock=Clock())
    dear = [await rooms.create(HALL) for _ in range(2)]
    asked = [ask(room, 0) for room in dear]
    await turns()
    while sum(room.room.events_kept for room in dear) <= 600:
        run_pass(rooms.runner)
    with pytest.raises(BusyError, match=r"in all rooms have \d+ events"):
        await ask(rooms.find("main"), 0)
    assert all(each.done() for each in asked)


async def test_forty_drops_of_a_dear_board_are_computed_in_turns() -> None:
    rooms = Rooms(Settings(), Boards(8), Hub(8), MAIN, clock=Clock())
    dear, main = await rooms.create(HALL), rooms.find("main")
    asked = [ask(dear, seed) for seed in range(40)]
    await turns()
    asked.append(ask(main, 1))
    await turns()
    for _ in range(60):
        before, tick = followed(dear.room), main.room.world.tick
        run_pass(rooms.runner)
        # A turn has 2 ms: about twenty slices of 64 events, and the few events that end a slice.
        assert followed(dear.room) - before <= 20 * (64 + 8)
        assert main.room.world.tick == tick + 1
        if tick % 20 == 0:
            asked.append(ask(main, tick))
        await asyncio.sleep(0)
    assert 0 < dear.room.world.tick < 60
    assert all(each.done() for each in asked[:41])


def test_a_room_whose_balls_bounce_for_ever_takes_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(independent, "MOST_EVENTS", 500)
    room = IndependentRoom("dear", HALL, tick_rate=60, max_balls=9)
    for seed in (0, 1):
        room.drop(DropCommand(seed))
    while room.world.events_kept <= 500:
        room.step(watched=False)
    with pytest.raises(BallLimitError, match=r"keeps \d+ events .* no drop above 500"):
        room.plan_drop(DropCommand(2))


def test_a_room_with_too_many_events_in_a_tick_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(independent, "MOST_EVENTS", 10)
    room = IndependentRoom("dear", HALL, tick_rate=60, max_balls=9)
    room.drop(DropCommand(0))
    room.look_ahead()
    with pytest.raises(AppError, match=r"events in one tick; a room may keep at most 40"):
        room.look_ahead()


def test_of_a_ball_that_bounces_often_few_events_are_kept() -> None:
    room = IndependentRoom("dear", HALL, tick_rate=60, max_balls=9)
    room.drop(DropCommand(4))
    most = 0
    while followed(room) < 5_000:
        while room.look_ahead():
            most = max(most, room.events_kept)
        room.step(watched=False)
    assert most < KEPT + 2 * SLICE
    begin, ahead = room.world.ahead(0)
    whole = room.world.trajectory(0)
    count = len(ahead.segments)
    assert begin > 2_000
    assert (ahead.segments == whole.segments[begin : begin + count]).all()
    known = whole.events[:, 0] >= ahead.segments[0, body.T]
    assert (ahead.events == whole.events[known][: len(ahead.events)]).all()
    again = IndependentRoom("dear", HALL, tick_rate=60, max_balls=9)
    again.restore(room.checkpoint())
    assert again.events_kept < KEPT + 2 * SLICE
    assert again.world.bodies.tobytes() == room.world.bodies.tobytes()


def test_a_dear_ball_lands_as_its_drop_says() -> None:
    room = IndependentRoom("dear", HALL, tick_rate=60, max_balls=9)
    alone = drop(HALL, 4)
    room.drop(DropCommand(4))
    events: list[Any] = []
    while room.awake:
        while not room.ready:
            room.look_ahead()
        events += room.step(watched=False)
    (landed,) = events
    assert len(alone.impacts) > 10_000
    assert (landed.digest, landed.bin, landed.t) == (alone.digest, alone.bin, alone.duration)


SHAFT = {
    "name": "shaft",
    "width": 4e-3,
    "height": 1.0,
    "ball": {"radius": 1e-3, "restitution": 1.0},
    "walls": [
        {"x1": -5e-3, "y1": 0.969, "x2": 2.5e-3, "y2": 0.97},
        {"x1": -5e-3, "y1": -0.01, "x2": -5e-3, "y2": 1.0},
        {"x1": 5e-3, "y1": -0.01, "x2": 5e-3, "y2": 1.0},
    ],
    "wall_material": {"restitution": 1.0},
    "bins": {"y": 1.0, "edges": [-5e-3, 0.0, 5e-3], "multipliers": [1.0, 1.0]},
    "drop": {"x": -1.25e-3, "y": 0.0, "jitter": 1e-4},
}
"""A ball's way between two impacts is hundreds of times as long as the ball is wide."""


async def test_a_board_with_too_slow_an_impact_closes_its_room(
    limited_calls: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sliced, "EFFORT", 50_000)
    rooms = Rooms(Settings(), Boards(8), Hub(8), MAIN, clock=Clock())
    main, dear = rooms.find("main"), await rooms.create(Board.from_json(SHAFT))
    asked = [ask(room, 1) for room in (main, dear)]
    await turns()
    accepted = [await each for each in asked]
    landing = asyncio.ensure_future(dear.landings.wait(accepted[1].ball, 60.0))
    await asyncio.sleep(0)
    while rooms.is_open(dear.id):
        run_pass(rooms.runner)
    with pytest.raises(AppError, match="was closed: too much to compute"):
        await landing
    before = main.room.world.tick
    run_pass(rooms.runner)
    assert main.room.world.tick == before + 1
