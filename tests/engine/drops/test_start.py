"""A player's aim sets the middle of the random start, and nothing else about it."""

import json
from typing import Any

import numpy as np
import pytest

from plinko.engine import Board, ParameterError, drop, drop_many, verify
from plinko.engine.seeding import start_x

BOARD = Board.preset("triangle-16")
ZONE = BOARD.drop
AIM = ZONE.x + 0.5 * ZONE.aim_span


def test_an_aim_moves_the_middle_and_the_seed_draws_the_offset() -> None:
    for seed in (0, 42, 2**64 - 1):
        aimed = drop(BOARD, seed, aim=AIM)
        assert aimed.x_start == start_x(seed, AIM, ZONE.jitter)
        assert aimed.digest == drop(BOARD, x=aimed.x_start).digest
        assert drop(BOARD, seed, aim=ZONE.x) == drop(BOARD, seed)
    assert len({drop(BOARD, seed, aim=AIM).digest for seed in range(20)}) == 20


def test_a_record_names_its_aim_and_another_aim_does_not_verify() -> None:
    record = json.loads(json.dumps(drop(BOARD, 7, aim=AIM).to_dict()))
    assert record["aim"] == AIM
    assert "x" not in record
    assert verify(record).ok
    assert not verify(record | {"aim": -AIM}).ok
    assert "aim" not in drop(BOARD, 7).to_dict()


def test_starts_of_the_outermost_aims_stay_in_the_drop_zone() -> None:
    for name in ("triangle-8", "triangle-9", "triangle-16", "classic", "galton"):
        board = Board.preset(name)
        zone = board.drop
        seeds = np.arange(200, dtype=np.uint64)
        for aim in (zone.x - zone.aim_span, zone.x + zone.aim_span):
            starts = drop_many(board, seeds, aim=aim).x_start
            assert np.abs(starts - zone.x).max() <= zone.span


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"aim": AIM}, "a seed or an explicit x"),
        ({"seed": 1, "aim": ZONE.x + 1.01 * ZONE.aim_span}, "aim .* is not from"),
        ({"seed": 1, "aim": float("nan")}, "aim nan is not from"),
        ({"seed": 1, "aim": True}, "aim True is not a number"),
        ({"seed": 1, "aim": AIM, "x": 0.0}, "aim is .*, but x is 0.0"),
    ],
)
def test_an_aim_that_says_no_start_is_refused_and_named(
    start: dict[str, Any], message: str
) -> None:
    with pytest.raises(ParameterError, match=message):
        drop(BOARD, **start)


def test_where_there_are_slots_only_they_can_be_aimed_at() -> None:
    form = BOARD.to_dict()
    form["drop"] |= {"slots": [-0.1, 0.1], "aim": 0.2}
    board = Board.from_json(form)
    assert drop(board, 3, aim=-0.1).x_start == start_x(3, -0.1, ZONE.jitter)
    with pytest.raises(ParameterError, match=r"aim 0\.05 is not a slot: the slots are -0\.1, "):
        drop(board, 3, aim=0.05)
