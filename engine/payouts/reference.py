"""The payout tables of triangular boards in the reference game, whose shapes players know.

Values run from the edge to the centre. A board with an odd number of rows has an even number of
bins, so its two middle bins share the last value.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from plinko.engine.board.payouts import Risk

_LOW: Final = {
    8: (5.6, 2.1, 1.1, 1.0, 0.5),
    9: (5.6, 2.0, 1.6, 1.0, 0.7),
    10: (8.9, 3.0, 1.4, 1.1, 1.0, 0.5),
    11: (8.4, 3.0, 1.9, 1.3, 1.0, 0.7),
    12: (10.0, 3.0, 1.6, 1.4, 1.1, 1.0, 0.5),
    13: (8.1, 4.0, 3.0, 1.9, 1.2, 0.9, 0.7),
    14: (7.1, 4.0, 1.9, 1.4, 1.3, 1.1, 1.0, 0.5),
    15: (15.0, 8.0, 3.0, 2.0, 1.5, 1.1, 1.0, 0.7),
    16: (16.0, 9.0, 2.0, 1.4, 1.4, 1.2, 1.1, 1.0, 0.5),
}
_MEDIUM: Final = {
    8: (13.0, 3.0, 1.3, 0.7, 0.4),
    9: (18.0, 4.0, 1.7, 0.9, 0.5),
    10: (22.0, 5.0, 2.0, 1.4, 0.6, 0.4),
    11: (24.0, 6.0, 3.0, 1.8, 0.7, 0.5),
    12: (33.0, 11.0, 4.0, 2.0, 1.1, 0.6, 0.3),
    13: (43.0, 13.0, 6.0, 3.0, 1.3, 0.7, 0.4),
    14: (58.0, 15.0, 7.0, 4.0, 1.9, 1.0, 0.5, 0.2),
    15: (88.0, 18.0, 11.0, 5.0, 3.0, 1.3, 0.5, 0.3),
    16: (110.0, 41.0, 10.0, 5.0, 3.0, 1.5, 1.0, 0.5, 0.3),
}
_HIGH: Final = {
    8: (29.0, 4.0, 1.5, 0.3, 0.2),
    9: (43.0, 7.0, 2.0, 0.6, 0.2),
    10: (76.0, 10.0, 3.0, 0.9, 0.3, 0.2),
    11: (120.0, 14.0, 5.2, 1.4, 0.4, 0.2),
    12: (170.0, 24.0, 8.1, 2.0, 0.7, 0.2, 0.2),
    13: (260.0, 37.0, 11.0, 4.0, 1.0, 0.2, 0.2),
    14: (420.0, 56.0, 18.0, 5.0, 1.9, 0.3, 0.2, 0.2),
    15: (620.0, 83.0, 27.0, 8.0, 3.0, 0.5, 0.2, 0.2),
    16: (1000.0, 130.0, 26.0, 9.0, 4.0, 2.0, 0.2, 0.2, 0.2),
}

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


def reference(rows: int, risk: Risk) -> tuple[float, ...]:
    """Multipliers of all `rows` + 1 bins, left to right; KeyError for rows without a table."""
    half = HALF_TABLES[risk][rows]
    centre_stands_once = rows % 2 == 0
    return half + half[-2::-1] if centre_stands_once else half + half[::-1]
