"""Searches drag, restitution, friction and jitter of a triangle for a binomial distribution."""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import sqrt

import numpy as np
import numpy.typing as npt

from plinko.engine.batches.workers import Here, Workers
from plinko.engine.board import presets
from plinko.engine.board.presets import Tuning
from plinko.engine.board.worlds import TABLE_GRAVITY
from plinko.engine.drops.calibrate import Fit, fit

ROUNDS = (0.15, 0.08, 0.04, 0.02)
"""How far each local round searches around the best fit, as a fraction of the whole range."""

HEATS = (16, 4)
"""A trial begins with 1/16, then 1/4 of its drops. It ends early if its cost is more than DOUBT
times the sampling floor above the best fit's; most trials end after 1/16."""

DOUBT = 2.0

_HALTON_BASES = (2, 3, 5, 7, 11, 13)


def limits(rows: int) -> tuple[Tuning, Tuning]:
    """The least and the largest value of each parameter in the search.

    The height of the start is the preset's. On boards of one shape, the effect of drag depends only
    on its ratio to sqrt(g / spacing). With a jitter above 0.85 spacings, balls would start in the
    mouth's walls.
    """
    rate = sqrt(TABLE_GRAVITY / presets.spacing_of(rows))
    given = (TABLE_GRAVITY, presets.TUNING[f"triangle-{rows}"].start)
    low = Tuning(round(0.45 * rate, 3), 0.60, 0.1, 0.02, *given)
    return low, Tuning(round(0.75 * rate, 3), 0.80, 0.7, 0.85, *given)


def search(rows: int, trials: int, drops: int, workers: Workers | None = None) -> Iterator[Fit]:
    """Yield each better fit: first from a sweep of the whole range, then from local rounds.

    The sweep has `trials` points of Halton's sequence with `drops` drops each. Each of the ROUNDS
    has a quarter as many points around the best fit, and twice the drops of the previous round. It
    also measures the best fit again, which may have been lucky. All trials of a round use the same
    seeds, so that luck does not decide between two tunings; each round has other seeds.

    workers: default is this process. They measure as many trials at once as they can; the result
    does not depend on them.
    """
    given = workers or Here()
    low, high = limits(rows)
    centre = _tuning(np.full(len(low), 0.5), low, high)
    best = yield from _round(
        given, _Trials(rows, drops, 0), _around(centre, 0.5, trials, low, high)
    )
    seed = drops
    for reach in ROUNDS:
        drops *= 2
        near = _around(best.tuning, reach, max(trials // 4, 1), low, high)
        best = yield from _round(given, _Trials(rows, drops, seed), [best.tuning, *near])
        seed += drops


@dataclass(frozen=True, slots=True)
class _Trials:
    """The parameters that all trials of a round share."""

    rows: int
    drops: int
    first_seed: int

    def fits(self, tuning: Tuning, best: Fit | None, threads: int) -> list[Fit]:
        """Measure a tuning with more and more drops, until it is clearly worse than `best`."""
        parts = () if best is None else HEATS
        found = []
        for part in (*parts, 1):
            drops = max(self.drops // part, 1)
            found.append(fit(self.rows, tuning, drops, self.first_seed, threads))
            if _is_behind(found[-1], best):
                break
        return found


def _round(
    workers: Workers, trials: _Trials, tunings: Sequence[Tuning]
) -> Generator[Fit, None, Fit]:
    """Yield each better fit of a round and return the best.

    Trials that run at the same time are all compared with the best fit from before them. So some
    run longer than they would one after the other, but the result is the same: a best fit is only
    replaced by a better one, and a trial that is worse than the older is worse than the newer too.
    """
    best: Fit | None = None
    left = list(tunings)
    while left:
        # Without a best fit, the first trial runs alone, because the others are compared with it.
        some = left[: 1 if best is None else workers.at_once]
        left = left[len(some) :]
        measured = dict(workers.compute(partial(_measured, trials, best), some))
        for tuning in some:
            *heats, whole = measured[tuning]
            if any(_is_behind(each, best) for each in heats) or whole.drops < trials.drops:
                continue
            if best is None or whole.cost < best.cost:
                best = whole
                yield best
    assert best is not None
    return best


def _measured(trials: _Trials, best: Fit | None, tuning: Tuning, threads: int) -> list[Fit]:
    return trials.fits(tuning, best, threads)


def _is_behind(found: Fit, best: Fit | None) -> bool:
    """Whether a tuning is clearly worse than the best fit, sampling noise considered."""
    return best is not None and found.cost > best.cost + DOUBT * found.floor


def _around(centre: Tuning, reach: float, count: int, low: Tuning, high: Tuning) -> list[Tuning]:
    """`count` tunings, evenly spread around `centre`; reach: fraction of the range to each side."""
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
    """A tuning with parameters rounded to three decimals; more would suggest false precision."""
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
