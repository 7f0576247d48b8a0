"""Types of the kernels' arrays."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Indices = npt.NDArray[np.uint32]
"""Unsigned, so that machine code does not test for negative indices."""
