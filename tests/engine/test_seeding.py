"""A seed is an integer below 2^64; starts of seeds are uniform over the drop zone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.engine.errors import EngineError, SeedError
from plinko.engine.seeding import parse_seed, splitmix64, start_x, start_xs

SEEDS = st.integers(0, 2**64 - 1)


@given(SEEDS)
def test_a_seed_is_read_from_a_number_and_a_decimal_string(seed: int) -> None:
    assert parse_seed(seed) == seed
    assert parse_seed(str(seed)) == seed
    assert parse_seed(np.uint64(seed)) == seed
    assert type(parse_seed(np.uint64(seed))) is int


@pytest.mark.parametrize(
    "value",
    [
        *(-1, 2**64, str(2**64), "-1", "+1", " 1", "1 ", "1.0", "0x10", "", "1_0", "١"),
        *(1.0, True, None, []),
    ],
    ids=repr,
)
def test_anything_else_is_refused_and_named(value: object) -> None:
    with pytest.raises(SeedError) as caught:
        parse_seed(value)
    assert repr(value).strip("'") in str(caught.value)
    assert caught.value.field == "seed"
    assert isinstance(caught.value, EngineError)


def test_a_long_value_is_cut_in_the_error() -> None:
    with pytest.raises(SeedError) as caught:
        parse_seed("9" * 10_000)
    assert len(str(caught.value)) < 120


def test_splitmix64_gives_the_published_numbers() -> None:
    # Outputs 1 to 3 of a generator started at 1234567; the state grows by the golden gamma.
    gamma = 0x9E3779B97F4A7C15
    states = [(1234567 + i * gamma) % 2**64 for i in range(3)]
    assert [splitmix64(s) for s in states] == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
    ]


@given(SEEDS, st.floats(-10.0, 10.0), st.floats(0.0, 2.0))
def test_a_start_is_within_the_jitter(seed: int, x: float, jitter: float) -> None:
    assert x - jitter <= start_x(seed, x, jitter) <= x + jitter


@given(st.lists(SEEDS, min_size=1, max_size=50), st.floats(-10.0, 10.0), st.floats(0.0, 2.0))
def test_many_starts_have_the_bits_of_each(seeds: list[int], x: float, jitter: float) -> None:
    many = start_xs(np.array(seeds, dtype=np.uint64), x, jitter)
    assert many.tolist() == [start_x(seed, x, jitter) for seed in seeds]


def test_starts_of_successive_seeds_are_even_and_uncorrelated() -> None:
    n = 100_000
    x = start_xs(np.arange(n, dtype=np.uint64), 0.0, 1.0)
    counts = np.histogram(x, bins=100, range=(-1.0, 1.0))[0]
    # Chi-squared with 99 degrees of freedom: mean 99, deviation 14. A correlation's is 1 / 316.
    assert abs(((counts - n / 100) ** 2 / (n / 100)).sum() - 99) < 5 * 14.1
    assert abs(np.corrcoef(x[:-1], x[1:])[0, 1]) < 5 / np.sqrt(n)
    assert x.min() < -0.999
    assert x.max() > 0.999
