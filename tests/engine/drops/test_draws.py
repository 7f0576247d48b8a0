"""A draw made for a board has, for each bin with a weight, the first seeds that land there."""

import pytest

from plinko.engine import Board, ParameterError, drop, find_draw, seeds_landing_in

BOARD = Board.preset("triangle-8")


def test_each_bin_with_a_weight_gets_its_first_seeds() -> None:
    weights = [1, 0, 2, 0, 9, 0, 0, 0, 1]
    found = find_draw(BOARD, weights, per_bin=3, threads=1)
    assert found["weights"] == weights
    for bin_, (weight, seeds) in enumerate(zip(weights, found["seeds"], strict=True)):
        wanted = seeds_landing_in(BOARD, bin_, count=3) if weight else ()
        assert seeds == [str(seed) for seed in wanted]
        assert all(drop(BOARD, seed).bin == bin_ for seed in seeds)


def test_it_begins_after_a_seed_and_takes_a_presets_name() -> None:
    first = find_draw("triangle-8", [0] * 4 + [1] + [0] * 4)["seeds"][4]
    later = find_draw(BOARD, [0] * 4 + [1] + [0] * 4, after=first[0])["seeds"][4]
    assert int(later[0]) == next(seeds_landing_in(BOARD, 4, after=first[0]))


def test_it_gives_up_and_names_the_bins_that_lack_seeds() -> None:
    with pytest.raises(ParameterError, match="seeds from 0 to 3 lands in bin 0 or 8"):
        find_draw(BOARD, [1, 0, 0, 0, 0, 0, 0, 0, 1], patience=4)
    last = (1 << 64) - 3
    with pytest.raises(ParameterError, match="lands in bin 0"):
        find_draw(BOARD, [1, 0, 0, 0, 0, 0, 0, 0, 0], after=last)


@pytest.mark.parametrize(
    ("name", "values"), [("per_bin", {"per_bin": 0}), ("patience", {"patience": 0})]
)
def test_an_impossible_draw_is_named(name: str, values: dict[str, int]) -> None:
    with pytest.raises(ParameterError, match=f"{name} is 0") as refused:
        find_draw(BOARD, [1] * 9, **values)
    assert refused.value.field == name
