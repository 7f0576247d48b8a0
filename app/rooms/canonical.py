"""Canonical JSON (RFC 8785) for digests: equal values give equal bytes in every language.

JavaScript writes 1.0 as 1, and Python and JavaScript differ in order and spaces. msgspec already
writes the canonical form, with three exceptions: the order of keys, floats that are whole numbers,
and numbers from 1e-6 to 1e-5. Floats from 2^53 on are refused; no value in a log comes near.
"""

from decimal import Decimal
from typing import Final

import msgspec

from plinko.engine.errors import RecordError

LARGEST: Final = 2.0**53
"""From here on JavaScript rounds whole numbers."""

_SMALL: Final = (1e-6, 1e-5)
"""JavaScript writes numbers without an exponent from the first on, msgspec from the second on."""

_encoder: Final = msgspec.json.Encoder(order="sorted")


def canonical(value: object) -> bytes:
    """The canonical bytes of a JSON value; integers of any size are written in full.

    Raises RecordError for a float that is not finite, or from LARGEST on.
    """
    return _encoder.encode(_plain(value))


def _plain(value: object) -> object:
    """`value` with numbers that msgspec writes as JavaScript does."""
    if isinstance(value, float):
        if not -LARGEST < value < LARGEST:
            raise RecordError(f"the number {value!r} is not within 2^53 of 0")
        if _SMALL[0] <= abs(value) < _SMALL[1]:
            return msgspec.Raw(f"{Decimal(repr(value)):f}".encode())
        return int(value) if value.is_integer() else value
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return value
