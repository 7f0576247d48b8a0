"""The search for tunings measures its fit correctly and never gets worse."""

from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np
import pytest

from plinko.engine.batches.search import ROUNDS, limits, search
from plinko.engine.board.presets import TUNING
from plinko.engine.drops.batch import drop_many
from plinko.engine.drops.calibrate import (
    LONGEST_FALL,
    SHORTEST_FALL,
    Fit,
    binomial,
    fit,
    fit_of,
    sampling_floor,
    total_variation,
    tuned,
)


def test_the_expected_bins_are_those_of_fair_coins() -> None:
    assert binomial(2).tolist() == [0.25, 0.5, 0.25]
    assert binomial(16).sum() == 1.0


def test_total_variation_is_0_for_expected_counts_and_1_for_none() -> None:
    assert total_variation(np.array([1, 2, 1]), binomial(2)) == 0.0
    assert total_variation(np.array([0, 0, 7]), np.array([0.5, 0.5, 0.0])) == 1.0


def test_the_sampling_floor_is_what_fair_draws_show() -> None:
    draws = np.random.default_rng(1).multinomial(4096, binomial(8), size=400)
    mean = np.mean([total_variation(row, binomial(8)) for row in draws])
    assert sampling_floor(binomial(8), 4096) == pytest.approx(mean, rel=0.05)


def test_a_fit_of_a_preset_is_that_of_its_drops() -> None:
    found = fit(8, TUNING["triangle-8"], 64)
    assert found.drops == 64
    assert found.unsettled_count == 0
    assert found.duration > 0.0
    assert 0.0 < found.distance < 1.0


def test_distance_and_floor_are_those_of_the_drops_themselves() -> None:
    batch = drop_many(tuned(8, TUNING["triangle-8"]), range(64))
    found = fit_of(batch, TUNING["triangle-8"])
    assert batch.histogram.tolist() != batch.histogram[::-1].tolist()
    assert found.distance == total_variation(batch.histogram, binomial(8))
    assert found.floor == sampling_floor(binomial(8), 64)


def test_a_search_improves_in_each_round_and_narrows_in_the_next() -> None:
    fits = list(search(8, trials=6, drops=64))
    rounds = [list(group) for _, group in groupby(fits, key=lambda found: found.drops)]
    assert [found[0].drops for found in rounds] == [64 * 2**i for i in range(len(ROUNDS) + 1)]
    for found in rounds:
        costs = [fit.cost for fit in found]
        assert costs == sorted(costs, reverse=True)
    for before, after in pairwise(rounds):
        assert after[0].tuning == before[-1].tuning


def test_a_search_stays_within_its_limits() -> None:
    low, high = limits(8)
    for found in search(8, trials=8, drops=16):
        assert all(a <= b <= c for a, b, c in zip(low, found.tuning, high, strict=True))


def test_a_fall_out_of_limits_and_stuck_balls_count_against_it() -> None:
    good = Fit(TUNING["triangle-8"], 64, 0.1, 0.05, 3.0, 20.0, 0)
    assert good.cost == pytest.approx(0.1)
    assert replace(good, duration=LONGEST_FALL + 1.0).cost == pytest.approx(1.1)
    assert replace(good, duration=SHORTEST_FALL - 0.5).cost == pytest.approx(0.6)
    assert replace(good, unsettled_count=2).cost == pytest.approx(2.1)
