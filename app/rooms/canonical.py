"""JSON as canonical bytes (RFC 8785), for digests: the same however a value was written.

JavaScript writes 1.0 as 1, Python and JavaScript sort and space differently; here all agree. What
msgspec writes is that form already, but for its order, for whole numbers of type float and for
numbers about a millionth; those beyond 2^53, to which nothing in a log comes near, are refused.
"""

from decimal import Decimal
from typing import Final

import msgspec

from engine.errors import RecordError

LARGEST: Final = 2.0**53
"""From here on JavaScript rounds the digits of a whole number."""

_SMALL: Final = (1e-6, 1e-5)
"""From the first on JavaScript writes no exponent, msgspec from the second on."""

_encoder: Final = msgspec.json.Encoder(order="sorted")


def canonical(value: object) -> bytes:
    """Bytes of a JSON value of dicts, lists and plain values; integers of any size in full.

    Raises RecordError for a number that is not finite or not below LARGEST.
    """
    return _encoder.encode(_plain(value))


def _plain(value: object) -> object:
    """`value` with its numbers so that they are written as JavaScript does."""
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
