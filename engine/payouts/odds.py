"""The odds of a payout table from one aim: its return with an error, and each award's chance."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any, Final

import numpy as np

from plinko.engine.payouts.landings import Landings

DEVIATIONS: Final = 1.959964
"""Half-width of the 95 % interval of a normal distribution, in standard deviations."""


@dataclass(frozen=True, slots=True)
class Odds:
    """The odds of one drop with a stake of 1 from one aim; an unsettled drop returns the stake.

    aim: m, None for the board's own start. returned: mean payout. doubt: half the width of its 95 %
    interval. hit_rate: chance that at least the stake comes back. volatility: standard deviation of
    the payout. chances: of each bin. awards: each multiplier with its chance, the highest first.
    """

    aim: float | None
    drops: int
    returned: float
    doubt: float
    hit_rate: float
    volatility: float
    unsettled_count: int
    chances: tuple[float, ...]
    awards: tuple[tuple[float, float], ...]

    def to_dict(self) -> dict[str, Any]:
        """The JSON form."""
        return {
            "aim": self.aim,
            "drops": self.drops,
            "return": self.returned,
            "doubt": self.doubt,
            "hit_rate": self.hit_rate,
            "volatility": self.volatility,
            "unsettled": self.unsettled_count,
            "chances": list(self.chances),
            "awards": [{"multiplier": pays, "chance": chance} for pays, chance in self.awards],
        }


def odds_of(landings: Landings, multipliers: Sequence[float]) -> Odds:
    """Compute the odds of `multipliers`, one per bin, from counted landings."""
    pays = np.array([*multipliers, 1.0])
    chances = landings.chances
    void = landings.unsettled_count / max(landings.drops, 1)
    share = np.array([*chances, void])
    returned = float(share @ pays)
    volatility = sqrt(max(float(share @ (pays - returned) ** 2), 0.0))
    awards = {
        value: float(share[:-1][pays[:-1] == value].sum())
        for value in sorted({*pays[:-1].tolist()})
    }
    return Odds(
        aim=landings.aim,
        drops=landings.drops,
        returned=returned,
        doubt=DEVIATIONS * volatility / sqrt(max(landings.drops, 1)),
        hit_rate=float(share[pays >= 1.0].sum()),
        volatility=volatility,
        unsettled_count=landings.unsettled_count,
        chances=tuple(chances.tolist()),
        awards=tuple(sorted(awards.items(), reverse=True)),
    )
