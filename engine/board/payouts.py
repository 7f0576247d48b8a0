"""The payout tables of the house table, solved by `plinko payouts` for a return of 99 %.

Values run from the edge to the centre. A board with an odd number of rows has an even number of
bins, so its two middle bins share the last value.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, Literal

Risk = Literal["low", "medium", "high"]

_LOW: Final = {
    8: (5.5, 1.8, 1.1, 1.0, 0.5),
    9: (6.0, 2.0, 1.5, 1.0, 0.7),
    10: (8.5, 2.9, 1.3, 1.1, 1.0, 0.5),
    11: (8.5, 3.0, 1.8, 1.3, 1.0, 0.7),
    12: (10.0, 3.0, 1.5, 1.4, 1.1, 1.0, 0.5),
    13: (8.0, 4.0, 2.6, 2.0, 1.1, 0.9, 0.7),
    14: (7.0, 4.0, 2.0, 1.4, 1.3, 1.1, 1.0, 0.5),
    15: (15.0, 8.0, 2.9, 1.8, 1.4, 1.1, 1.0, 0.7),
    16: (16.0, 9.0, 2.1, 1.5, 1.3, 1.2, 1.1, 1.0, 0.5),
}
_MEDIUM: Final = {
    8: (13.0, 2.9, 1.3, 0.6, 0.4),
    9: (17.0, 3.5, 1.8, 0.8, 0.5),
    10: (23.0, 5.0, 2.2, 1.2, 0.6, 0.4),
    11: (23.0, 6.0, 2.9, 1.6, 0.8, 0.5),
    12: (33.0, 10.0, 4.0, 1.9, 1.1, 0.6, 0.3),
    13: (43.0, 13.0, 6.0, 2.9, 1.1, 0.7, 0.4),
    14: (58.0, 16.0, 6.5, 4.0, 2.0, 1.0, 0.5, 0.2),
    15: (86.0, 17.0, 10.0, 4.5, 2.7, 1.2, 0.5, 0.3),
    16: (110.0, 42.0, 10.0, 5.0, 2.9, 1.4, 1.0, 0.5, 0.3),
}
_HIGH: Final = {
    8: (31.0, 2.8, 1.2, 0.3, 0.2),
    9: (38.0, 6.0, 2.0, 0.5, 0.2),
    10: (76.0, 8.0, 3.0, 0.8, 0.3, 0.2),
    11: (115.0, 13.0, 6.0, 1.4, 0.4, 0.2),
    12: (165.0, 22.0, 7.5, 1.6, 0.6, 0.2, 0.2),
    13: (260.0, 37.0, 10.0, 3.5, 0.9, 0.2, 0.2),
    14: (420.0, 60.0, 19.0, 5.0, 2.0, 0.3, 0.2, 0.2),
    15: (470.0, 62.0, 18.0, 6.0, 2.1, 0.4, 0.2, 0.2),
    16: (990.0, 120.0, 25.0, 8.5, 3.5, 1.8, 0.2, 0.2, 0.2),
}

RISKS: Final[tuple[Risk, ...]] = ("medium", "low", "high")

HALF_TABLES: Final[Mapping[Risk, Mapping[int, tuple[float, ...]]]] = MappingProxyType(
    {
        "low": MappingProxyType(_LOW),
        "medium": MappingProxyType(_MEDIUM),
        "high": MappingProxyType(_HIGH),
    },
)
"""Risk -> rows -> multipliers from the edge bin to the centre."""

ROWS: Final = tuple(_MEDIUM)
"""Row counts that have a table: 8 to 16."""


def multipliers(rows: int, risk: Risk) -> tuple[float, ...]:
    """Multipliers of all `rows` + 1 bins, left to right; KeyError for rows without a table."""
    return both_halves(HALF_TABLES[risk][rows], rows)


def both_halves(half: tuple[float, ...], rows: int) -> tuple[float, ...]:
    """Mirror a table from the edge to the centre of a triangle of `rows` rows."""
    centre_stands_once = rows % 2 == 0
    return half + half[-2::-1] if centre_stands_once else half + half[::-1]
