"""Search for a triangle's drag, restitution, friction and jitter that make its walk binomial.

A ball that goes left or right with even odds at each row ends in the binomial distribution; how
near a board comes to that is the total-variation distance of its bins from it. The physics decides
it, and nothing steers the ball: what can be chosen are four parameters.
"""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from math import comb, sqrt

import numpy as np
import numpy.typing as npt

from engine.board import payouts, presets
from engine.board.model import Board
from engine.board.presets import TABLE_GRAVITY, Tuning
from engine.drops.batch import DropBatch, drop_many

SHORTEST_FALL = 2.0
LONGEST_FALL = 5.0
"""s. Mean durations between which a drop is neither over at once nor tiresome."""

ROUNDS = (0.15, 0.08, 0.04, 0.02)
"""Of the local search: how far each looks around the best so far, as a part of the whole range."""

HEATS = (16, 4)
"""A trial is first given this part of its drops, and no more if it is DOUBT times the sampling
floor worse than the best so far: most need a sixteenth."""

DOUBT = 2.0

UNSEEN = 10**12
"""First seed of drops that no search has been fitted to."""

_HALTON_BASES = (2, 3, 5, 7, 11, 13)


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


def limits(rows: int) -> tuple[Tuning, Tuning]:
    """Where to look for a tuning: the least and the largest of each parameter.

    The height of the start is the preset's. Motion on boards of one shape depends on drag only by
    its ratio to sqrt(g / spacing). Jitter beyond 0.85 spacings meets the mouth's walls.
    """
    rate = sqrt(TABLE_GRAVITY / presets.spacing_of(rows))
    given = (TABLE_GRAVITY, presets.TUNING[f"triangle-{rows}"].start)
    low = Tuning(round(0.45 * rate, 3), 0.60, 0.1, 0.02, *given)
    return low, Tuning(round(0.75 * rate, 3), 0.80, 0.7, 0.85, *given)


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


def fit(rows: int, tuning: Tuning, drops: int, first_seed: int = 0) -> Fit:
    """Measure one tuning with the seeds first_seed … first_seed + drops - 1."""
    batch = drop_many(tuned(rows, tuning), range(first_seed, first_seed + drops))
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


def search(rows: int, trials: int, drops: int) -> Iterator[Fit]:
    """Yield each better fit found: a sweep of the whole range, then rounds ever nearer the best.

    The sweep is `trials` points of Halton's sequence with `drops` drops each. Each of the ROUNDS
    looks at a quarter as many with twice the drops of the round before, the best so far measured
    anew among them: by chance it may have looked better than it is. Within a round every trial uses
    the same seeds, so that two tunings differ by themselves and not by luck; each round has others.
    """
    low, high = limits(rows)
    centre = _tuning(np.full(len(low), 0.5), low, high)
    best = yield from _round(rows, _around(centre, 0.5, trials, low, high), drops, 0)
    seed = drops
    for reach in ROUNDS:
        drops *= 2
        near = _around(best.tuning, reach, max(trials // 4, 1), low, high)
        best = yield from _round(rows, [best.tuning, *near], drops, seed)
        seed += drops


def _round(
    rows: int, tunings: Sequence[Tuning], drops: int, first_seed: int
) -> Generator[Fit, None, Fit]:
    """Yield each better fit of a round and return the best."""
    best = None
    for tuning in tunings:
        if best is not None and _falls_behind(rows, tuning, drops, first_seed, best):
            continue
        found = fit(rows, tuning, drops, first_seed)
        if best is None or found.cost < best.cost:
            best = found
            yield found
    assert best is not None
    return best


def _falls_behind(rows: int, tuning: Tuning, drops: int, first_seed: int, best: Fit) -> bool:
    """Whether a part of its drops shows that a tuning is worse than the best."""
    for part in HEATS:
        found = fit(rows, tuning, max(drops // part, 1), first_seed)
        if found.cost > best.cost + DOUBT * found.floor:
            return True
    return False


def _around(centre: Tuning, reach: float, count: int, low: Tuning, high: Tuning) -> list[Tuning]:
    """`count` tunings spread evenly within `reach` of `centre`, a part of the range each way."""
    tunings = []
    for index in range(1, count + 1):
        offset = 2.0 * np.array([_halton(index, base) for base in _HALTON_BASES]) - 1.0
        share = np.clip(_share(centre, low, high) + reach * offset, 0.0, 1.0)
        tunings.append(_tuning(share, low, high))
    return tunings


def _share(tuning: Tuning, low: Tuning, high: Tuning) -> npt.NDArray[np.float64]:
    span = np.subtract(high, low)
    return np.divide(np.subtract(tuning, low), span, out=np.zeros(len(low)), where=span > 0.0)


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
