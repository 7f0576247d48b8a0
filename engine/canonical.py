"""Converts numbers to canonical bytes for digests, the same on every machine."""

import numpy as np
import numpy.typing as npt

_NAN_BITS = np.uint64(0x7FF8000000000000)


def float_bits(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return `values` as little-endian float64, with the same quiet NaN for every NaN."""
    floats = np.array(values, "<f8")
    floats.view("<u8")[np.isnan(floats)] = _NAN_BITS
    return floats
