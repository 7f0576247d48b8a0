"""Rooms behave as docs/protocol.md says about new balls, stalls and flags."""

import pytest

from plinko.app.protocol import messages
from plinko.app.protocol.client_messages import parse_place
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.room import QUIET, Room
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.rooms.touching.values import MOTION
from plinko.engine import Board, drop
from tests.outsider import decoder

BOARD = Board.preset("triangle-8")


def independent() -> IndependentRoom:
    return IndependentRoom("r", BOARD, tick_rate=60, max_balls=99)


def seen(room: Room) -> decoder.Row:
    """The room's snapshot, as a client decodes it."""
    box = {name: getattr(room.extent, name) for name in ("x_min", "x_max", "y_min", "y_max")}
    return decoder.snapshot(room.snapshot(), box, room.velocity_scale)


def test_a_ball_is_first_in_the_snapshot_after_its_starting_tick() -> None:
    room = independent()
    room.drop(DropCommand(1))
    room.step(watched=True)
    before = seen(room)
    accepted = room.drop(DropCommand(2))
    assert [ball["id"] for ball in before["balls"]] == [0]
    assert accepted.tick == before["tick"]
    room.step(watched=True)
    after = seen(room)
    assert after["tick"] == before["tick"] + 1
    (_, second) = after["balls"]
    fallen = 0.5 * BOARD.gravity / 60**2
    assert second["y"] - BOARD.drop.y == pytest.approx(fallen, rel=0.05)


def test_bit_0_marks_impacts_too_soft_for_an_event() -> None:
    form = BOARD.to_dict()
    dull = {"restitution": 0.3, "friction": 0.2}
    form |= {"ball": form["ball"] | dull, "peg_material": dull, "wall_material": dull}
    room = IndependentRoom("r", Board.from_json(form), tick_rate=240, max_balls=9)
    room.drop(DropCommand(3))
    marked, told = set(), set()
    while room.awake:
        events = room.step(watched=True)
        told |= {event.tick for event in events if isinstance(event, messages.Contact)}
        found = seen(room)
        marked |= {found["tick"] for ball in found["balls"] if ball["bounced"]}
    path = drop(Board.from_json(form), 3)
    hits = path.impacts[path.impacts["kind"] <= 1]
    assert marked == {int(t * 240) + 1 for t in hits["t"]}
    assert told < marked, f"some impacts are slower than {QUIET} m/s"


def test_caught_up_events_have_their_ticks_and_one_snapshot() -> None:
    room = independent()
    room.drop(DropCommand(1))
    hit = drop(BOARD, 1).impacts["t"][0]
    while room.world.tick < int(hit * 60) - 1:
        room.step(watched=True)
    seen(room)
    events = [event for _ in range(4) for event in room.step(watched=True)]
    (ball,) = seen(room)["balls"]
    assert ball["bounced"]
    (contact, *_) = events
    assert contact.tick == int(hit * 60) + 1 < room.world.tick  # type: ignore[attr-defined]
    (still,) = seen(room)["balls"]
    assert not still["bounced"], "a mark is of the snapshot before"


def test_a_stopped_clock_shows_a_drop_at_once() -> None:
    room = TouchingRoom("t", BOARD, tick_rate=60, max_balls=9)
    room.paused = True
    tick = room.drop(DropCommand(1)).tick
    assert room.touched
    found = seen(room)
    assert (found["tick"], len(found["balls"])) == (tick, 1)


def test_zero_is_one_place_in_rooms_too() -> None:
    assert str(parse_place(-0.0, "x")) == str(parse_place(0, "x")) == "0.0"
    assert str(MOTION["vx"].check(-0.0, "vx")) == "0.0"
