"""Stakes and payouts: whole numbers of minor units that fit 64 bits, never negative."""

from decimal import Decimal
from typing import Final

from app.errors import InvalidValueError, shorten

MAX_STAKE: Final = 1_000_000_000
"""Minor units. Times 10^9, the largest multiplier of a board, it still fits 64 bits."""

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
