"""Search for a triangle's drag, restitution, friction and jitter that make its walk binomial.

A ball that goes left or right with even odds at each row ends in the binomial distribution; how
near a board comes to that is the total-variation distance of its bins from it. The physics decides
it, and nothing steers the ball: what can be chosen are four parameters.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import comb, sqrt

import numpy as np
import numpy.typing as npt

from engine import payouts, presets
from engine.batch import DropBatch, drop_many
from engine.board import Board
from engine.presets import Tuning

SHORTEST_FALL = 2.0
LONGEST_FALL = 5.0
"""s. Mean durations between which a drop is neither over at once nor tiresome."""

LOW = Tuning(drag=0.5, restitution=0.2, friction=0.0, jitter=0.05)
HIGH = Tuning(drag=4.0, restitution=0.8, friction=0.6, jitter=0.85)
"""Where to look. Jitter beyond 0.85 spacings meets the mouth's walls."""

_HALTON_BASES = (2, 3, 5, 7)


@dataclass(frozen=True, slots=True)
class Fit:
    """What a tuning gives: distance from the binomial, mean fall in s, balls that did not land."""

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
    return presets.triangle("tuned", rows, payouts.multipliers(rows, "medium"), tuning)


def fit(rows: int, tuning: Tuning, drops: int, first_seed: int = 0) -> Fit:
    """Measure one tuning with the seeds first_seed … first_seed + drops - 1."""
    batch = drop_many(tuned(rows, tuning), range(first_seed, first_seed + drops))
    return fit_of(batch, tuning)


def fit_of(batch: DropBatch, tuning: Tuning) -> Fit:
    """What a batch on a triangle shows."""
    expected = binomial(batch.board.bins.count - 1)
    return Fit(
        tuning=tuning,
        drops=len(batch),
        distance=total_variation(batch.histogram, expected),
        floor=sampling_floor(expected, len(batch)),
        duration=float(batch.duration.mean()),
        impacts=float(batch.impact_count.mean()),
        unsettled=batch.unsettled,
    )


def search(
    rows: int, trials: int, drops: int, low: Tuning = LOW, high: Tuning = HIGH
) -> Iterator[Fit]:
    """Yield each better fit found: a Halton sweep of half the trials, then ever smaller steps.

    Every trial uses the same seeds, so that two tunings differ by themselves and not by luck.
    """
    best: Fit | None = None
    for trial in range(trials):
        if best is None or trial < trials // 2:
            centre, reach = 0.5, 0.5
            middle = np.full(4, centre)
        else:
            reach = 0.15 * 0.98 ** (trial - trials // 2)
            middle = _share(best.tuning, low, high)
        offset = 2.0 * np.array([_halton(trial + 1, base) for base in _HALTON_BASES]) - 1.0
        share = np.clip(middle + reach * offset, 0.0, 1.0)
        found = fit(rows, _tuning(share, low, high), drops)
        if best is None or found.cost < best.cost:
            best = found
            yield found


def _share(tuning: Tuning, low: Tuning, high: Tuning) -> npt.NDArray[np.float64]:
    span = np.subtract(high, low)
    return np.divide(np.subtract(tuning, low), span, out=np.zeros(4), where=span > 0.0)


def _tuning(share: npt.NDArray[np.float64], low: Tuning, high: Tuning) -> Tuning:
    """Parameters rounded to three decimals: nobody should read meaning into more."""
    values = np.add(low, share * np.subtract(high, low))
    return Tuning(*(round(float(value), 3) for value in values))


def _halton(index: int, base: int) -> float:
    """Van der Corput's radical inverse of `index` in `base`."""
    result, scale = 0.0, 1.0
    while index:
        scale /= base
        result += scale * (index % base)
        index //= base
    return result
