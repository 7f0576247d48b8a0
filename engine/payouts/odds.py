"""What a payout table gives from one aim: its return, how sure that is, the odds of each award."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any, Final

import numpy as np

from engine.payouts.landings import Landings

DEVIATIONS: Final = 1.959964
"""Standard deviations on either side that hold 95 % of a normal law."""


@dataclass(frozen=True, slots=True)
class Odds:
    """Of one drop with a stake of 1 from one aim; a drop that settles nowhere gives it back.

    aim: m, None for the board's own start. returned: the mean of what is paid; doubt: half its
    interval of 95 %. hit_rate: chance that at least the stake comes back. volatility: standard
    deviation of what is paid. chances: of each bin. awards: each multiplier with its chance, the
    highest first.
    """

    aim: float | None
    drops: int
    returned: float
    doubt: float
    hit_rate: float
    volatility: float
    unsettled: int
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
            "unsettled": self.unsettled,
            "chances": list(self.chances),
            "awards": [{"multiplier": pays, "chance": chance} for pays, chance in self.awards],
        }


def odds_of(landings: Landings, multipliers: Sequence[float]) -> Odds:
    """What `multipliers`, one a bin, give on what landed."""
    pays = np.array([*multipliers, 1.0])
    chances = landings.chances
    void = landings.unsettled / max(landings.drops, 1)
    share = np.array([*chances, void])
    returned = float(share @ pays)
    volatility = sqrt(max(float(share @ (pays - returned) ** 2), 0.0))
    awards = {
        float(value): float(share[:-1][pays[:-1] == value].sum()) for value in np.unique(pays[:-1])
    }
    return Odds(
        aim=landings.aim,
        drops=landings.drops,
        returned=returned,
        doubt=DEVIATIONS * volatility / sqrt(max(landings.drops, 1)),
        hit_rate=float(share[pays >= 1.0].sum()),
        volatility=volatility,
        unsettled=landings.unsettled,
        chances=tuple(chances.tolist()),
        awards=tuple(sorted(awards.items(), reverse=True)),
    )
