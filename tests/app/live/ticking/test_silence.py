"""A room that is slow once or always still ticks, and so does every other room."""

import pytest

from plinko.app.live.live_room import LiveRoom
from plinko.app.live.registry import Rooms
from plinko.app.protocol import messages
from plinko.app.rooms.kinds import INTERACTING
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.engine import Board
from tests.app.asking import ask
from tests.app.passes import rooms_by_hand, run_pass
from tests.kit.hand import HandClock
from tests.kit.waiting import turns

MAIN = Board.preset("triangle-8")


class Clock(HandClock):
    """A clock that the test advances, and that advances a little each time it is read."""

    def __call__(self) -> float:
        self.time += 1e-6
        return super().__call__()


async def seven_rooms(clock: Clock) -> tuple[Rooms, list[LiveRoom]]:
    """`main` and six other rooms; a ball falls in each."""
    rooms = rooms_by_hand(MAIN, clock)
    others = [await rooms.create(MAIN, INTERACTING) for _ in range(6)]
    asked = [ask(room, 0) for room in (rooms.find("main"), *others)]
    await turns()
    run_pass(rooms.runner)
    assert all(each.done() for each in asked)
    return rooms, others


def slow(room: LiveRoom, clock: Clock, seconds: float, patch: pytest.MonkeyPatch) -> None:
    """Make each further tick of a room take this long, without moving its balls."""

    def step(*, watched: bool) -> list[messages.Event]:
        clock.time += seconds
        room.room.world.tick += 1
        return []

    patch.setattr(room.room, "step", step)


@pytest.mark.parametrize("seconds", [0.02, 0.05, 1.0, 60.0])
async def test_after_one_slow_tick_all_rooms_tick_in_the_next_pass(
    seconds: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = Clock()
    rooms, others = await seven_rooms(clock)
    for room in others:
        slow(room, clock, 0.0, monkeypatch)
    for room in others:
        with monkeypatch.context() as once:
            slow(room, clock, seconds, once)
            run_pass(rooms.runner)
        before = [each.room.world.tick for each in others]
        run_pass(rooms.runner)
        assert [each.room.world.tick for each in others] == [tick + 1 for tick in before]


async def test_ticks_that_do_not_fit_into_a_pass_are_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    rooms, others = await seven_rooms(clock)
    for room in others:
        slow(room, clock, 0.0, monkeypatch)
    run_pass(rooms.runner)
    assert rooms.runner.counts.skipped == 0
    for room in others:
        slow(room, clock, 0.02, monkeypatch)
    before = sum(room.room.world.tick for room in others)
    for _ in range(60):
        run_pass(rooms.runner)
    ran = sum(room.room.world.tick for room in others) - before
    assert ran == 60
    assert rooms.runner.counts.skipped == 60 * len(others) - ran


async def test_an_open_room_that_has_not_ticked_for_a_second_is_late(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rooms, (held, *closed) = await seven_rooms(Clock())
    stopped = {held.id, *(each.id for each in closed)}
    monkeypatch.setattr(TouchingRoom, "held", property(lambda room: room.id in stopped))
    for _ in range(60):
        run_pass(rooms.runner)
    assert rooms.runner.counts.late == 0
    for room in closed:
        await rooms.delete(room)
    for _ in range(30):
        run_pass(rooms.runner, 2)
    assert rooms.runner.counts.late == 60
    monkeypatch.undo()
    for _ in range(60):
        run_pass(rooms.runner)
    assert rooms.runner.counts.late == 60
    assert rooms.runner.counts.skipped == 0, "there was time"
