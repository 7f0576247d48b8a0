"""Finds a payout table for known chances: multipliers of the familiar shape with a wanted return.

The search begins with the reference game's table, in which the rarest bin pays the top award. It
then moves multipliers up and down a ladder of numbers that people read easily, as little as
possible, until the return from every aim is within its bounds.
"""

import json
from dataclasses import dataclass, replace
from importlib.resources import files
from itertools import combinations, product
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.payouts import ROWS, Risk, both_halves
from plinko.engine.errors import ParameterError
from plinko.engine.physics.array_types import Floats

Rungs = npt.NDArray[np.intp]

LADDER: Final = np.array(
    [n / 10 for n in range(1, 30)]
    + [n / 2 for n in range(6, 20)]
    + [float(n) for n in range(10, 50)]
    + [float(n) for n in range(50, 100, 2)]
    + [float(n) for n in range(100, 300, 5)]
    + [float(n) for n in range(300, 1001, 10)]
    + [float(n) for n in range(1050, 10_001, 50)]
)
"""Allowed multipliers, easy to read: tenths, halves, whole numbers, then coarser steps."""

NEAR: Final = 5e-4
"""Allowed difference between the wanted return and the return from the board's own start."""

MOST_BINS: Final = 64
"""Most bins with different multipliers; the search tries all pairs of them."""

_SCALES: Final = (1.0, 0.96, 1.04, 0.92, 1.08, 0.86, 1.15)  # of the wanted table, to begin with
_STEPS: Final = (-4, -3, -2, -1, 1, 2, 3, 4)  # rungs that a multiplier moves in one step
_SHIFTS: Final = (0.0, 1e-4, -1e-4, 2e-4, -2e-4)
"""Of the wanted return, tried in turn: a local search may end just outside the bounds."""

_STIFF: Final = 1e11  # cost of a squared violation; a squared log change of a multiplier costs 1
_VIOLATED: Final = 1e3  # additional cost of any violation, however small
_HEADLINE: Final = 10.0  # additional cost for the top award, by which players know the table
_FAMILIAR: Final = (0.9, 1.1)  # range of its return in which the reference table is not scaled


@dataclass(frozen=True, slots=True)
class Bounds:
    """Bounds of a table's return: `target` from the board's own start (within NEAR), and from
    every other aim `least` to `most`."""

    target: float = 0.99
    least: float = 0.955
    most: float = 0.9915


def bounds_of(target: float) -> Bounds:
    """The bounds for a target: at most 0.15 % above it, and at most 3.5 % below, from every aim."""
    return Bounds(target, target - 0.035, target + 0.0015)


def solve(chances: Floats, risk: Risk, bounds: Bounds, mirrored: bool) -> tuple[float, ...]:
    """Return the multipliers of all bins, left to right.

    chances: shape (aims, bins), the first row from the board's own start; if a row sums to less
    than 1, the rest returns the stake. mirrored: both sides pay the same. Raises ParameterError if
    no table was found.
    """
    folded = 0.5 * (chances + chances[:, ::-1]) if mirrored else chances
    bins = folded.shape[1]
    groups = (bins + 1) // 2 if mirrored else bins
    if groups > MOST_BINS:
        most = 2 * MOST_BINS if mirrored else MOST_BINS
        raise ParameterError(
            f"the board has {bins} bins: a table can be solved for at most {most}", field="board"
        )
    member = (
        np.minimum(np.arange(bins), bins - 1 - np.arange(bins)) if mirrored else np.arange(bins)
    )
    shared = np.zeros((len(folded), groups))
    np.add.at(shared.T, member, folded.T)
    void = 1.0 - folded.sum(axis=1)
    # The rarest bin, by the average over all aims, comes first, because it pays most.
    order = np.argsort(folded[:, :groups].mean(axis=0), kind="stable")
    wanted = _familiar(shared[0, order], void[0], bins, folded[0], risk, bounds.target)
    found = np.empty(groups)
    for ranked, shift in product((True, False), _SHIFTS):
        near = replace(bounds, target=bounds.target + shift)
        found[order] = LADDER[_nearest(shared[:, order], void, wanted, near, ranked)]
        if _violation(void + shared @ found, bounds) == 0.0:
            break
    else:
        raise ParameterError(
            f"no table of risk {risk} returns {bounds.target:g} from the board's own start and "
            f"{bounds.least:g} to {bounds.most:g} from each of {len(chances)} aims: use another "
            "return or risk, or more drops",
            field="return",
        )
    pays: list[float] = found[member].tolist()
    return tuple(pays)


def reference(rows: int, risk: Risk) -> tuple[float, ...]:
    """The reference game's multipliers of `rows` + 1 bins, left to right, for rows of ROWS."""
    text = files("plinko.engine.payouts").joinpath("reference.json").read_text(encoding="utf-8")
    return both_halves(tuple(json.loads(text)[f"{rows}-{risk}"]), rows)


def _familiar(
    shared: Floats, void: float, bins: int, chances: Floats, risk: Risk, target: float
) -> Floats:
    """The reference table by rank of the bins, flatter or steeper if its return is far off.

    The lowest award stays, and the logarithm of every other's ratio to it is scaled to the target.
    So where rare bins are hit more often than in the reference game, all of them pay less, and the
    awards still rise from bin to bin.
    """
    rows = min(max(bins - 1, ROWS[0]), ROWS[-1])
    table = np.sort(np.array(reference(rows, risk)))[::-1]
    ranks = np.linspace(0.0, rows, len(shared) if len(shared) < len(chances) else bins)
    wanted: Floats = np.exp(np.interp(ranks, np.arange(rows + 1), np.log(table)))
    returned = void + float(shared @ wanted)
    if _FAMILIAR[0] < returned < _FAMILIAR[1]:
        return wanted
    lowest = wanted[-1]
    steep = np.log(wanted / lowest)
    low, high = 0.0, np.log(LADDER[-1] / lowest) / max(steep[0], 1e-9)
    for _ in range(60):  # the return rises with the power
        power = 0.5 * (low + high)
        if void + float(shared @ np.exp(power * steep)) * lowest < target:
            low = power
        else:
            high = power
    found: Floats = lowest * np.exp(low * steep)
    return np.clip(found, LADDER[0], LADDER[-1])


def _violation(returns: Floats, bounds: Bounds) -> Floats:
    """Sum of the squared violations of the bounds; returns[..., 0] is the board's own start's."""
    off = np.maximum(0.0, np.abs(returns[..., 0] - bounds.target) - NEAR)
    low = np.maximum(0.0, bounds.least - returns[..., 1:])
    high = np.maximum(0.0, returns[..., 1:] - bounds.most)
    found: Floats = off**2 + (low**2 + high**2).sum(axis=-1)
    return found


def _nearest(shared: Floats, void: Floats, wanted: Floats, bounds: Bounds, ranked: bool) -> Rungs:
    """Return the best rungs that local searches find, the rarest bin's first.

    The searches begin with the wanted table, scaled versions of it, and a table with one multiplier
    for all bins. ranked: a bin that is hit more often must not pay more. If each slot has its own
    frequent bins, no such table may be within the bounds.
    """
    moves = _moves(len(wanted))

    def climb(now: Rungs) -> tuple[float, Rungs]:
        """Descend from `now` until no one or two steps lower the cost; return cost and rungs."""
        best = np.inf
        while True:
            tried = np.clip(now + moves, 0, len(LADDER) - 1)
            if ranked:
                tried = tried[(np.diff(tried, axis=1) <= 0).all(axis=1)]
            pays = LADDER[tried]
            violation = _violation(void + pays @ shared.T, bounds)
            cost = _STIFF * violation + _VIOLATED * (violation > 0.0)
            changes = np.log(pays / wanted) ** 2
            cost += changes.sum(axis=1) + _HEADLINE * changes[:, 0]
            first = int(cost.argmin())
            if not cost[first] < best:
                return best, now
            best, now = float(cost[first]), tried[first]

    begins = [wanted * scale for scale in _SCALES] + [np.full(len(wanted), bounds.target)]
    nearest = (np.abs(np.log(LADDER[:, None]) - np.log(pays)).argmin(axis=0) for pays in begins)
    return min(map(climb, nearest), key=lambda each: each[0])[1]


def _moves(count: int) -> Rungs:
    """All moves: none, each step of one multiplier, each pair of steps; shape (moves, count)."""
    one = [(place, step) for place in range(count) for step in _STEPS]
    rows = [(), *((move,) for move in one)]
    rows += [pair for pair in combinations(one, 2) if pair[0][0] != pair[1][0]]
    found = np.zeros((len(rows), count), np.intp)
    for row, steps in enumerate(rows):
        for place, step in steps:
            found[row, place] = step
    return found
