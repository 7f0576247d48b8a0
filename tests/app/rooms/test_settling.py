"""When a room ends, its falling balls are computed to their end, within a time limit."""

import pytest

from app.errors import BusyError
from app.rooms.independent import IndependentRoom
from app.rooms.pending import DropCommand
from app.rooms.settling import MOST_EFFORT, settle
from benchmarks.scenes.expensive_boards import hall
from engine import Board, drop


def with_balls(board: Board, count: int) -> IndependentRoom:
    room = IndependentRoom("r", board, tick_rate=60, max_balls=count)
    for seed in range(count):
        room.plan_drop(DropCommand(seed)).durable = True
        room.enter()
    return room


def test_a_full_room_of_a_preset_ends_as_single_drops_do() -> None:
    board = Board.preset("triangle-8")
    room = with_balls(board, 20)
    settled = settle(room, room.checkpoint(), [])
    assert {each.seed: each.digest for each in settled.landed} == {
        str(seed): drop(board, seed).digest for seed in range(20)
    }


def test_a_ball_that_bounces_for_hours_is_given_up_in_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    efforts: list[str] = []
    look_ahead = IndependentRoom.look_ahead

    def counted(room: IndependentRoom) -> bool:
        efforts.append(room.id)
        return look_ahead(room)

    monkeypatch.setattr(IndependentRoom, "look_ahead", counted)
    room = with_balls(Board.from_json(hall()), 3)
    with pytest.raises(BusyError, match="take too long to compute") as raised:
        settle(room, room.checkpoint(), [])
    assert len(efforts) == MOST_EFFORT
    assert raised.value.retry_after is not None
