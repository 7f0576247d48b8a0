"""Where in their drops balls are when a solver takes them up."""

import numpy as np
import numpy.typing as npt

from engine.physics import body

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Columns of `initial`, beside the rows of `states`.
HIT = 0  # the surface that the ball is just hitting, NONE if it is in flight
HIT_SIDE = 1  # of a line, 1 or -1
IMPACTS_BEFORE = 2
COLUMNS = 3

NONE = -1


def at_rest(xs: Floats, y: float) -> Floats:
    """`states`, shape (n, 7), of balls about to fall from each (xs[i], y), in m."""
    states = np.zeros((len(xs), body.SIZE))
    states[:, body.X] = xs
    states[:, body.Y] = y
    return states


def in_flight(count: int) -> Ints:
    """`initial`, shape (count, COLUMNS), of balls in flight that have hit nothing yet."""
    initial = np.zeros((count, COLUMNS), np.int64)
    initial[:, HIT] = NONE
    return initial
