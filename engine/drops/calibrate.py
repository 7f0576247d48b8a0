"""How near a triangle's walk is to the binomial: what a tuning of its physics gives.

A ball that goes left or right with even odds at each row ends in the binomial distribution; how
near a board comes to that is the total-variation distance of its bins from it. The physics decides
it, and nothing steers the ball: what can be chosen are drag, restitution, friction and jitter.
"""

from dataclasses import dataclass
from math import comb, sqrt

import numpy as np
import numpy.typing as npt

from engine.board import payouts, presets
from engine.board.model import Board
from engine.board.presets import Tuning
from engine.drops.batch import DropBatch, drop_many

SHORTEST_FALL = 2.0
LONGEST_FALL = 5.0
"""s. Mean durations between which a drop is neither over at once nor tiresome."""

UNSEEN = 10**12
"""First seed of drops that no search has been fitted to."""


@dataclass(frozen=True, slots=True)
class Fit:
    """What a tuning gives: distance from the binomial, mean fall in s, balls that did not land.

    `floor` is the distance that as many fair draws would show on average.
    """

    tuning: Tuning
    drops: int
    distance: float
    floor: float
    duration: float
    impacts: float
    unsettled: int

    @property
    def cost(self) -> float:
        """Distance, and what the mean fall lies outside of its limits, in s."""
        outside = max(SHORTEST_FALL - self.duration, self.duration - LONGEST_FALL, 0.0)
        return self.distance + outside + self.unsettled


def binomial(rows: int) -> npt.NDArray[np.float64]:
    """Probabilities of rows + 1 bins under even odds, shape (rows + 1,)."""
    return np.array([comb(rows, i) for i in range(rows + 1)], np.float64) / 2.0**rows


def total_variation(histogram: npt.NDArray[np.int64], expected: npt.NDArray[np.float64]) -> float:
    """Half the sum of |p - q|, for counts and the probabilities expected of them."""
    return float(0.5 * np.abs(histogram / histogram.sum() - expected).sum())


def sampling_floor(expected: npt.NDArray[np.float64], drops: int) -> float:
    """Mean total variation that `drops` draws from `expected` itself would show.

    Each bin's share is nearly normal, and E|z| = sqrt(2 / pi) for a standard normal z.
    """
    spread = np.sqrt(expected * (1.0 - expected) / drops)
    return float(0.5 * sqrt(2.0 / np.pi) * spread.sum())


def tuned(rows: int, tuning: Tuning) -> Board:
    """The triangle of `rows` rows with another tuning."""
    fields = presets.triangle("tuned", rows, payouts.multipliers(rows, "medium"), tuning)
    return Board.of(fields)


def fit(
    rows: int, tuning: Tuning, drops: int, first_seed: int = 0, threads: int | None = None
) -> Fit:
    """Measure one tuning with the seeds first_seed … first_seed + drops - 1."""
    seeds = range(first_seed, first_seed + drops)
    batch = drop_many(tuned(rows, tuning), seeds, threads=threads)
    return fit_of(batch, tuning)


def fit_of(batch: DropBatch, tuning: Tuning) -> Fit:
    """What a batch on a triangle shows.

    Board and starts are symmetric, so the bins of the mirrored drops count as well: they cost
    nothing and halve the variance.
    """
    expected = binomial(batch.board.bins.count - 1)
    histogram = batch.histogram + batch.histogram[::-1]
    return Fit(
        tuning=tuning,
        drops=len(batch),
        distance=total_variation(histogram, expected),
        floor=sampling_floor(expected, 2 * len(batch)),
        duration=float(batch.duration.mean()),
        impacts=float(batch.impact_count.mean()),
        unsettled=batch.unsettled,
    )
