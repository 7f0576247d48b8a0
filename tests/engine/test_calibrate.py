"""The search for tunings measures what it says, and only ever gets better."""

import numpy as np
import pytest

from engine.calibrate import HIGH, LOW, binomial, fit, sampling_floor, search, total_variation
from engine.presets import TUNING


def test_the_expected_bins_are_those_of_fair_coins() -> None:
    assert binomial(2).tolist() == [0.25, 0.5, 0.25]
    assert binomial(16).sum() == 1.0


def test_total_variation_is_zero_for_the_expected_counts_and_one_for_none_of_them() -> None:
    assert total_variation(np.array([1, 2, 1]), binomial(2)) == 0.0
    assert total_variation(np.array([0, 0, 7]), np.array([0.5, 0.5, 0.0])) == 1.0


def test_the_sampling_floor_is_what_fair_draws_show() -> None:
    draws = np.random.default_rng(1).multinomial(4096, binomial(8), size=400)
    mean = np.mean([total_variation(row, binomial(8)) for row in draws])
    assert sampling_floor(binomial(8), 4096) == pytest.approx(mean, rel=0.05)


def test_a_fit_of_a_preset_is_that_of_its_drops() -> None:
    found = fit(8, TUNING["triangle-8"], 64)
    assert found.drops == 64
    assert found.unsettled == 0
    assert found.duration > 0.0
    assert 0.0 < found.distance < 1.0


def test_a_search_yields_ever_lower_costs_within_its_limits() -> None:
    fits = list(search(8, trials=6, drops=64))
    costs = [found.cost for found in fits]
    assert costs == sorted(costs, reverse=True)
    for found in fits:
        assert all(
            low <= value <= high for low, value, high in zip(LOW, found.tuning, HIGH, strict=True)
        )
