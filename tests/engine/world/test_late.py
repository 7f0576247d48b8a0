"""A ball that enters late is where it would be anyway, and lands at the same time."""

import pytest

from plinko.engine import Board, World
from plinko.engine.drops.flight import fly
from plinko.engine.drops.start import start_of

BOARD = Board.preset("triangle-8")
SEEDS = (3, 4)


def world_after(ticks: int, *, late_at: int) -> tuple[World, list[object]]:
    """A world of two balls; the second one starts at tick 7 and is added at tick `late_at`."""
    world, events = World(BOARD), list[object]()
    world.add(seed=SEEDS[0])
    for tick in range(ticks):
        if tick == late_at:
            flight = fly(BOARD, start_of(BOARD, SEEDS[1], None))
            assert world.add_flight(flight, SEEDS[1], 7) == 1
        world.step(contacts=False)
        events += world.take_events()
    return world, events


@pytest.mark.parametrize("late_at", [8, 20, 100, 1000])
def test_a_ball_that_enters_late_goes_on_as_if_it_had_not(late_at: int) -> None:
    expected, on_time = world_after(1100, late_at=7)
    found, events = world_after(1100, late_at=late_at)
    assert sorted(events, key=repr) == sorted(on_time, key=repr)
    assert found.digest == expected.digest
    assert len(events) == 2


def test_the_world_is_at_once_as_if_the_ball_had_been_on_time() -> None:
    expected, lonely = World(BOARD), World(BOARD)
    start = start_of(BOARD, SEEDS[1], None)
    for world in (expected, lonely):
        world.add(seed=SEEDS[0])
        for _ in range(7):
            world.step()
    expected.add(SEEDS[1])
    bounces = 0
    while expected.count == 2:
        late = World(BOARD)
        late.restore(lonely.snapshot())
        late.add_flight(fly(BOARD, start), SEEDS[1], 7)
        assert late.digest == expected.digest
        bounces += int(late.bodies["bounced"][1])
        for world in (expected, lonely):
            world.step()
    assert bounces > 3, "it has also entered in ticks in which it bounced"


@pytest.mark.parametrize("jumps", [[2, 3, 5, 30], [7, 1, 100], [1000]])
def test_a_world_that_jumps_arrives_where_steps_would_bring_it(jumps: list[int]) -> None:
    stepping, jumping = World(BOARD), World(BOARD)
    for ball, ticks in enumerate(jumps * 3):
        for world in (stepping, jumping):
            world.add(seed=ball)
        for _ in range(ticks):
            stepping.step(contacts=False)
        jumping.advance_to(jumping.tick + ticks, contacts=False)
        assert jumping.digest == stepping.digest
        assert jumping.bodies.tobytes() == stepping.bodies.tobytes()
        assert jumping.take_events() == stepping.take_events()
    for world in (stepping, jumping):
        world.advance_to(world.tick + 10_000, contacts=False)
    assert jumping.take_events() == stepping.take_events()
    assert not jumping.awake
