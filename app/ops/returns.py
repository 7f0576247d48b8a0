"""Compare the return that rooms actually paid with the expected return and its tolerance. Pure."""

from dataclasses import dataclass
from math import sqrt
from typing import Final

DEVIATIONS: Final = 4.0
"""k of the tolerance k sigma / sqrt(n). By chance alone one check in 16,000 exceeds it."""


@dataclass(frozen=True, slots=True)
class Return:
    """The actual and the expected return as shares of the stakes, and the tolerance."""

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
    """The return of plays with these sums of stakes, of their squares and of payouts (minor units).

    expected: the return of the payout table; doubt: its uncertainty; sigma: the standard deviation
    of the payout of a stake of 1. For n equal stakes the tolerance from chance is k sigma /
    sqrt(n). Added to it are the doubt, and the loss by rounding down, which is less than one minor
    unit per play.
    """
    chance = DEVIATIONS * sigma * sqrt(squares) / staked
    return Return(paid / staked, expected, chance + doubt + plays / staked)
