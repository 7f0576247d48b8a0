"""Stakes and payouts: whole numbers of minor units, from 0 to below 2^53."""

from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from math import ceil
from typing import Final

from plinko.app.errors import InvalidValueError
from plinko.engine.errors import shorten

MAX_STAKE: Final = 1_000_000_000
"""Minor units."""

MAX_PAYOUT: Final = 2**53 - 1
"""Minor units. JavaScript and many other readers of JSON round larger whole numbers."""

MAX_WHO: Final = 64  # characters


def parse_stake(value: object) -> int:
    """A stake in minor units; None is 0. Raises InvalidValueError for an invalid stake."""
    if value is None:
        return 0
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MAX_STAKE:
        raise InvalidValueError(
            f"stake {shorten(value)} is not a whole number of minor units from 0 to {MAX_STAKE:,}",
            field="stake",
        )
    return value


def check_payout(stake: int, multipliers: Iterable[float]) -> None:
    """Raise InvalidValueError if the stake could pay more than `MAX_PAYOUT` by a multiplier."""
    most = most_stake(multipliers)
    if stake > most:
        raise InvalidValueError(
            f"stake {stake} could pay more than {MAX_PAYOUT} minor units, which not every reader "
            f"of JSON keeps exactly: with this board's multipliers a stake is at most {most}",
            field="stake",
        )


def most_stake(multipliers: Iterable[float]) -> int:
    """The largest stake whose payout is at most `MAX_PAYOUT` by every multiplier."""
    highest = Fraction(repr(max(multipliers)))
    return min(ceil((MAX_PAYOUT + 1) / highest) - 1, MAX_PAYOUT) if highest else MAX_PAYOUT


def parse_who(value: object) -> str | None:
    """A player's mark, kept with the drop; raises InvalidValueError for an invalid one."""
    if value is None:
        return None
    if not isinstance(value, str) or not 0 < len(value) <= MAX_WHO or not value.isprintable():
        raise InvalidValueError(
            f"who {shorten(value)} is not a text of 1 to {MAX_WHO} printable characters",
            field="who",
        )
    return value


def payout_of(stake: int, score: float) -> int:
    """`stake` times the multiplier `score`, rounded down to whole minor units.

    The multiplier counts as the decimal number that it is written as: 2.3 times 100 is 230,
    although the float 2.3 is slightly less.
    """
    return int(Decimal(repr(score)) * stake)
