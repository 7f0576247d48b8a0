"""Computes the start of a drop from its seed (SplitMix64); nothing else in a drop is random."""

import numpy as np
import numpy.typing as npt

from plinko.engine.errors import SeedError, shorten

SEED_LIMIT = 1 << 64
_MASK = SEED_LIMIT - 1
_GAMMA = 0x9E3779B97F4A7C15
_MIX_1 = 0xBF58476D1CE4E5B9
_MIX_2 = 0x94D049BB133111EB
_UNIT = 2.0**-53  # spacing of the 53-bit fractions


def parse_seed(value: object) -> int:
    """Return `value` as a seed, 0 <= seed < 2^64; accepts an integer or its decimal string.

    Raises SeedError naming the value. Booleans, floats, signs and blanks are refused, because a
    seed that was silently rounded would replay another drop.
    """
    if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) <= 20:
        value = int(value)
    if isinstance(value, np.integer):
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < SEED_LIMIT:
        raise SeedError(
            f"seed {shorten(value, 40)} is not an integer from 0 to 2^64 - 1", field="seed"
        )
    return value


def splitmix64(seed: int) -> int:
    """First output of SplitMix64 with the state `seed` (Steele, Lea and Flood, OOPSLA 2014)."""
    z = (seed + _GAMMA) & _MASK
    z = ((z ^ (z >> 30)) * _MIX_1) & _MASK
    z = ((z ^ (z >> 27)) * _MIX_2) & _MASK
    return z ^ (z >> 31)


def start_x(seed: int, x: float, jitter: float) -> float:
    """Start of a drop in m: `x` plus a uniform offset in [-jitter, jitter)."""
    fraction = (splitmix64(seed) >> 11) * _UNIT
    return x + jitter * (2.0 * fraction - 1.0)


def start_xs(seeds: npt.NDArray[np.uint64], x: float, jitter: float) -> npt.NDArray[np.float64]:
    """`start_x` for each of `seeds`, shape (n,), with the same bits."""
    z = seeds + np.uint64(_GAMMA)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(_MIX_1)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(_MIX_2)
    z = z ^ (z >> np.uint64(31))
    fraction = (z >> np.uint64(11)).astype(np.float64) * _UNIT
    offsets: npt.NDArray[np.float64] = x + jitter * (2.0 * fraction - 1.0)
    return offsets
