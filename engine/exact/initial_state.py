"""Where in their drops balls are when a solver takes them up, or leaves them for a while."""

import numpy as np
import numpy.typing as npt

from engine.physics import body

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Columns of `initial`, beside the rows of `states`.
HIT = 0  # the surface that the ball is just hitting, NONE if it hits none
HIT_SIDE = 1  # of a line, 1 or -1
# Where nothing is being hit, what follows says how a ball goes on that was left in between.
SURFACE = 2  # that it left last or lies on, NONE if it has touched nothing yet
SIDE = 3  # of a line, 1 or -1
PHASE = 4  # in flight, by how it left (FREE, BOUNCED … of next_impact), or LYING
SLIP_ROOTS = 5  # of a ball that lies: what `follow_contact` knows of its slip
SLIP_SIGN = 6
BESIDE = 7  # another surface that it touches, NONE if it touches no other
COLUMNS = 8

NONE = -1
LYING = 4


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
    initial[:, SURFACE] = NONE
    initial[:, BESIDE] = NONE
    return initial
