"""How far what tables paid back may be from what they should, and how far it is: pure."""

from dataclasses import dataclass
from math import sqrt
from typing import Final

DEVIATIONS: Final = 4.0
"""k of the tolerance k sigma / sqrt(n). One look in 16,000 is farther off by chance alone."""


@dataclass(frozen=True, slots=True)
class Return:
    """What came back of what was staked, as a share; and what should, give or take `tolerance`."""

    actual: float
    expected: float
    tolerance: float


def return_of(
    *,
    plays: int,
    staked: int,
    squares: float,
    paid: int,
    expected: float,
    doubt: float,
    sigma: float,
) -> Return:
    """Of plays with these sums of stakes, their squares and what was paid, in minor units.

    expected: what the table returns; doubt: how far that is known; sigma: the standard deviation of
    what a stake of 1 brings. Of equal stakes the tolerance is k sigma / sqrt(n); beside it there is
    the doubt, and what rounding down takes: less than a minor unit of each play.
    """
    chance = DEVIATIONS * sigma * sqrt(squares) / staked
    return Return(paid / staked, expected, chance + doubt + plays / staked)
