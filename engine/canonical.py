"""Numbers as canonical bytes, for digests: the same bits on every machine."""

import numpy as np
import numpy.typing as npt

_NAN_BITS = np.uint64(0x7FF8000000000000)


def float_bits(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Little-endian float64 of `values`, every NaN replaced by the one quiet NaN without sign."""
    floats = np.array(values, "<f8")
    floats.view("<u8")[np.isnan(floats)] = _NAN_BITS
    return floats
