"""Stakes and payouts: whole numbers of minor units, never negative, never too large to keep."""

from decimal import Decimal
from typing import Final

from app.errors import InvalidValueError, shorten

MAX_STAKE: Final = 1_000_000_000
"""Minor units. Times the largest multiplier a board may have, 10^9, it still fits 64 bits."""

MAX_WHO: Final = 64  # characters


def parse_stake(value: object) -> int:
    """A stake in minor units; none is 0. Raises InvalidValueError naming what is none."""
    if value is None:
        return 0
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MAX_STAKE:
        raise InvalidValueError(
            f"stake {shorten(value)} is not a whole number of minor units from 0 to {MAX_STAKE:,}",
            field="stake",
        )
    return value


def parse_who(value: object) -> str | None:
    """A player's own mark, kept with the drop; raises InvalidValueError naming what is none."""
    if value is None:
        return None
    if not isinstance(value, str) or not 0 < len(value) <= MAX_WHO or not value.isprintable():
        raise InvalidValueError(
            f"who {shorten(value)} is not a text of 1 to {MAX_WHO} printable characters",
            field="who",
        )
    return value


def payout_of(stake: int, score: float) -> int:
    """What `stake` comes back as at the multiplier `score`, rounded down to whole minor units.

    The multiplier is taken as the decimal number it is written as: 0.1 of 10 is 1, not 0.
    """
    return int(Decimal(repr(score)) * stake)
