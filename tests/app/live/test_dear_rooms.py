"""A room whose balls bounce a hundred thousand times slows down, and no other does."""

import asyncio
from typing import Any

import pytest

from app.errors import BallLimitError
from app.live.hub import Hub
from app.live.registry import Rooms
from app.rooms import independent
from app.rooms.boards import Boards
from app.rooms.independent import IndependentRoom
from app.rooms.pending import DropCommand
from app.settings import Settings
from benchmarks.serving.attack import hall
from engine import Board, World, drop

MAIN = Board.preset("triangle-8")
HALL = Board.from_json(hall())
CALL = 1e-4  # s by which each look at the clock moves it: a slice of a path is as long


class Clock:
    """Time passes with each look."""

    def __init__(self) -> None:
        self.time = 0.0

    def __call__(self) -> float:
        self.time += CALL
        return self.time


def followed(room: Any) -> int:
    """Events that were computed of the balls in flight."""
    assert isinstance(room.world, World)
    return room.world.events_kept


async def test_forty_drops_of_a_dear_board_are_computed_in_turns() -> None:
    rooms = Rooms(Settings(), Boards(8), Hub(8), MAIN, clock=Clock())
    dear, main = await rooms.create(HALL), rooms.find("main")
    asked = [rooms.drop(dear, seed, None) for seed in range(40)]
    asked.append(rooms.drop(main, 1, None))
    for _ in range(60):
        before, tick = followed(dear), main.world.tick
        rooms.runner.tick(1)
        # A turn has 2 ms: some twenty slices of 64 events and the few that end one.
        assert followed(dear) - before <= 20 * (64 + 8)
        assert main.world.tick == tick + 1
        if tick % 20 == 0:
            asked.append(rooms.drop(main, tick, None))
        await asyncio.sleep(0)
    assert 0 < dear.world.tick < 60
    assert all(each.done() for each in asked[:41])


def test_a_room_whose_balls_bounce_for_ever_takes_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(independent, "MOST_EVENTS", 500)
    room = IndependentRoom("dear", HALL, tick_rate=60, max_balls=9)
    for seed in (0, 1):
        room.drop(DropCommand(seed))
    while room.world.events_kept <= 500:
        room.step(watched=False)
    with pytest.raises(BallLimitError, match=r"have \d+ events behind them, of which it keeps 500"):
        room.plan_drop(DropCommand(2))


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
