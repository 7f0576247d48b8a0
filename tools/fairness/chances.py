"""Statistical tests of randomness: of counts in cells, of sums, and of many tests together."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import erfc, sqrt

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True)
class Outcome:
    """A test's name, its statistic, and the probability `p` of a deviation at least as large."""

    name: str
    statistic: float
    p: float


def normal(name: str, deviate: float) -> Outcome:
    """Test a statistic that is normal with mean 0 and deviation 1 for a good generator."""
    return Outcome(name, deviate, erfc(abs(deviate) / sqrt(2.0)))


def chi_square(name: str, counts: npt.NDArray[np.int64]) -> Outcome:
    """Test that all cells, of any shape, are equally likely. Both too uneven and too even fail.

    The chi-square distribution is approximated by Wilson and Hilferty's cube root (PNAS 17, 684,
    1931), whose error from some dozens of cells on is far below the level of the tests.
    """
    expected = counts.sum() / counts.size
    statistic = float(((counts - expected) ** 2).sum() / expected)
    return _of_chi_square(name, statistic, counts.size - 1)


def even_odds(name: str, hits: npt.NDArray[np.int64], tries: int) -> Outcome:
    """Test that independent counts, shape (n,), each have `tries` tosses of a fair coin."""
    statistic = float(((hits - tries / 2.0) ** 2).sum() / (tries / 4.0))
    return _of_chi_square(name, statistic, hits.size)


def _of_chi_square(name: str, statistic: float, freedom: int) -> Outcome:
    spread = 2.0 / (9.0 * freedom)
    deviate = ((statistic / freedom) ** (1.0 / 3.0) - (1.0 - spread)) / sqrt(spread)
    return Outcome(name, statistic, erfc(abs(deviate) / sqrt(2.0)))


def rejected(outcomes: Iterable[Outcome], level: float) -> list[Outcome]:
    """The tests that fail. A good generator fails any of them with probability `level` at most.

    Holm's step-down method (Scandinavian J. of Statistics 6, 65, 1979).
    """
    ordered = sorted(outcomes, key=lambda each: each.p)
    failed = []
    for left, each in zip(range(len(ordered), 0, -1), ordered, strict=True):
        if each.p * left > level:
            break
        failed.append(each)
    return failed
