"""Measures how close a tuning of a triangle's physics comes to the binomial distribution.

A ball that goes left or right with even odds at each row ends in the binomial distribution. The
measure is the total-variation distance between that and the distribution over the board's bins.
Nothing steers the ball: a tuning can only choose drag, restitution, friction and jitter.
"""

from dataclasses import dataclass
from math import comb, sqrt

import numpy as np
import numpy.typing as npt

from plinko.engine.board import presets
from plinko.engine.board.model import Board
from plinko.engine.board.presets import Tuning
from plinko.engine.drops.batch import DropBatch, drop_many

SHORTEST_FALL = 2.0
LONGEST_FALL = 5.0
"""Limits of the mean duration in s, so that a drop is neither too short nor tedious to watch."""

UNSEEN = 10**12
"""First of the seeds that no search uses, so that they can judge its result."""


@dataclass(frozen=True, slots=True)
class Fit:
    """The measurement of a tuning by `drops` drops.

    distance: from the binomial. floor: the distance that as many fair draws would have on average.
    duration: mean, in s. impacts: mean number. unsettled_count: balls that did not land.
    """

    tuning: Tuning
    drops: int
    distance: float
    floor: float
    duration: float
    impacts: float
    unsettled_count: int

    @property
    def cost(self) -> float:
        """Distance, plus the excess of the mean duration over its limits in s, plus `unsettled`."""
        outside = max(SHORTEST_FALL - self.duration, self.duration - LONGEST_FALL, 0.0)
        return self.distance + outside + self.unsettled_count


def binomial(rows: int) -> npt.NDArray[np.float64]:
    """Probabilities of rows + 1 bins under even odds, shape (rows + 1,)."""
    return np.array([comb(rows, i) for i in range(rows + 1)], np.float64) / 2.0**rows


def total_variation(histogram: npt.NDArray[np.int64], expected: npt.NDArray[np.float64]) -> float:
    """Half the sum of |p - q|, where p are the counts' shares and q the expected probabilities."""
    return float(0.5 * np.abs(histogram / histogram.sum() - expected).sum())


def sampling_floor(expected: npt.NDArray[np.float64], drops: int) -> float:
    """Mean total-variation distance of `drops` draws from `expected` itself.

    Each bin's share is nearly normal, and E|z| = sqrt(2 / pi) for a standard normal z.
    """
    spread = np.sqrt(expected * (1.0 - expected) / drops)
    return float(0.5 * sqrt(2.0 / np.pi) * spread.sum())


def tuned(rows: int, tuning: Tuning) -> Board:
    return Board.of(presets.triangle("tuned", rows, presets.payouts_of(f"triangle-{rows}"), tuning))


def fit(
    rows: int, tuning: Tuning, drops: int, first_seed: int = 0, threads: int | None = None
) -> Fit:
    """Measure one tuning with the seeds first_seed … first_seed + drops - 1."""
    seeds = range(first_seed, first_seed + drops)
    batch = drop_many(tuned(rows, tuning), seeds, threads=threads)
    return fit_of(batch, tuning)


def fit_of(batch: DropBatch, tuning: Tuning) -> Fit:
    """Measure a tuning by a batch on its triangle."""
    expected = binomial(batch.board.bins.count - 1)
    return Fit(
        tuning=tuning,
        drops=len(batch),
        distance=total_variation(batch.histogram, expected),
        floor=sampling_floor(expected, len(batch)),
        duration=float(batch.duration.mean()),
        impacts=float(batch.impact_count.mean()),
        unsettled_count=batch.unsettled_count,
    )
