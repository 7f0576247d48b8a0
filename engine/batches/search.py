"""Search for a triangle's drag, restitution, friction and jitter that make its walk binomial."""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import sqrt

import numpy as np
import numpy.typing as npt

from engine.batches.workers import Here, Workers
from engine.board import presets
from engine.board.presets import TABLE_GRAVITY, Tuning
from engine.drops.calibrate import Fit, fit

ROUNDS = (0.15, 0.08, 0.04, 0.02)
"""Of the local search: how far each looks around the best so far, as a part of the whole range."""

HEATS = (16, 4)
"""A trial is first given this part of its drops, and no more if it is DOUBT times the sampling
floor worse than the best so far: most need a sixteenth."""

DOUBT = 2.0

_HALTON_BASES = (2, 3, 5, 7, 11, 13)


def limits(rows: int) -> tuple[Tuning, Tuning]:
    """Where to look for a tuning: the least and the largest of each parameter.

    The height of the start is the preset's. Motion on boards of one shape depends on drag only by
    its ratio to sqrt(g / spacing). Jitter beyond 0.85 spacings meets the mouth's walls.
    """
    rate = sqrt(TABLE_GRAVITY / presets.spacing_of(rows))
    given = (TABLE_GRAVITY, presets.TUNING[f"triangle-{rows}"].start)
    low = Tuning(round(0.45 * rate, 3), 0.60, 0.1, 0.02, *given)
    return low, Tuning(round(0.75 * rate, 3), 0.80, 0.7, 0.85, *given)


def search(rows: int, trials: int, drops: int, workers: Workers | None = None) -> Iterator[Fit]:
    """Yield each better fit found: a sweep of the whole range, then rounds ever nearer the best.

    The sweep is `trials` points of Halton's sequence with `drops` drops each. Each of the ROUNDS
    looks at a quarter as many with twice the drops of the round before, the best so far measured
    anew among them: by chance it may have looked better than it is. Within a round every trial uses
    the same seeds, so that two tunings differ by themselves and not by luck; each round has others.
    `workers` (default: this process) measure as many trials side by side as they can; what is
    found does not depend on them.
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
    """What the trials of a round have in common."""

    rows: int
    drops: int
    first_seed: int

    def fits(self, tuning: Tuning, best: Fit | None, threads: int) -> list[Fit]:
        """A tuning with ever more of the drops, until a part shows it to be worse than `best`."""
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

    Trials that are measured side by side know the best before them, not of them. That measures some
    for longer than one after the other would, and decides the same: a best is only ever replaced
    by a better one, so that who falls behind the older falls behind the newer.
    """
    best: Fit | None = None
    left = list(tunings)
    while left:
        # Without a best the first goes alone: all others are measured against it.
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
    """Whether drops show that a tuning is worse than the best."""
    return best is not None and found.cost > best.cost + DOUBT * found.floor


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
