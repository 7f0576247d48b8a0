"""Seeds by bin: the search finds every seed that lands there, in order, and ends if none does."""

from itertools import islice

import pytest

from plinko.engine import Board, ParameterError, SeedError, drop, drop_many, seeds_landing_in
from plinko.engine.drops import seeds as module

BOARD = Board.preset("triangle-8")

ONE_SIDED = Board.from_json(
    {"bins": {"y": 2.0, "edges": [-1.0, 0.0, 1.0]}, "drop": {"x": -0.5, "jitter": 0.25}}
)
"""A board without pegs, on which every ball falls straight into bin 0."""


def test_each_seed_lands_there_and_none_between_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "FIRST_BATCH", 16)  # several batches within the compared seeds
    all_bins = drop_many(BOARD, 600).bin
    for number in range(BOARD.bins.count):
        wanted = [seed for seed in range(600) if all_bins[seed] == number]
        assert list(seeds_landing_in(BOARD, number, count=len(wanted), threads=1)) == wanted
        assert all(drop(BOARD, seed).bin == number for seed in wanted[:3])


def test_a_search_goes_on_after_a_seed() -> None:
    first = list(seeds_landing_in("triangle-8", 4, count=6))
    assert list(seeds_landing_in(BOARD, 4, after=first[2], count=3)) == first[3:]
    assert list(seeds_landing_in(BOARD, 4, after=str(first[2]), count=3)) == first[3:]
    assert list(seeds_landing_in(BOARD, 4, after=first[2] - 1, count=1)) == [first[2]]
    assert list(islice(seeds_landing_in(BOARD, 4), 6)) == first


def test_an_aim_is_where_the_balls_start() -> None:
    board = Board.preset("classic")
    aim = board.slots[2]
    for seed in seeds_landing_in(board, 2, count=3, aim=aim):
        assert drop(board, seed, aim=aim).bin == 2


def test_it_ends_with_the_last_seed_there_is() -> None:
    last = 2**64 - 1
    assert list(seeds_landing_in(ONE_SIDED, 0, after=last - 3)) == [last - 2, last - 1, last]
    assert list(seeds_landing_in(ONE_SIDED, 1, after=last - 3)) == []
    assert list(seeds_landing_in(ONE_SIDED, 0, after=last)) == []


def test_a_bin_that_no_ball_comes_to_ends_with_an_error() -> None:
    with pytest.raises(ParameterError, match=r"none of the 1,000 seeds from 5 to 1004") as caught:
        list(seeds_landing_in(ONE_SIDED, 1, after=4, patience=1000))
    assert caught.value.field == "bin"


def test_patience_restarts_with_each_seed_that_is_found() -> None:
    rare = list(seeds_landing_in(BOARD, 0, count=4))
    gap = max(b - a for a, b in zip([-1, *rare], rare, strict=False))
    assert list(seeds_landing_in(BOARD, 0, count=4, patience=gap)) == rare
    with pytest.raises(ParameterError, match="lands in bin 0"):
        list(seeds_landing_in(BOARD, 0, count=4, patience=gap - 1))


@pytest.mark.parametrize("number", [-1, 9, True, 1.0, "1", None])
def test_an_invalid_bin_is_named_at_once(number: object) -> None:
    with pytest.raises(ParameterError, match="the bins of 'triangle-8' are 0 to 8") as caught:
        seeds_landing_in(BOARD, number)  # type: ignore[arg-type]
    assert caught.value.field == "bin"


def test_an_invalid_count_or_seed_is_named_at_once() -> None:
    with pytest.raises(ParameterError, match="count is 0"):
        seeds_landing_in(BOARD, 0, count=0)
    with pytest.raises(ParameterError, match="patience is 0"):
        next(seeds_landing_in(BOARD, 0, patience=0))
    with pytest.raises(SeedError):
        seeds_landing_in(BOARD, 0, after=-1)
