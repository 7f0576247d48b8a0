"""The phase of a drop as a row of numbers, from which a solver starts or continues it."""

import numpy as np
import numpy.typing as npt

from plinko.engine.physics import body

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Columns of `initial`, whose rows belong to those of `states`.
HIT = 0  # the surface that the ball is hitting now, or NONE
HIT_SIDE = 1  # its side of a line, 1 or -1
# Used only if the ball is not hitting a surface:
SURFACE = 2  # the surface that it left last or lies on; NONE if it has not touched any
SIDE = 3  # its side of a line, 1 or -1
PHASE = 4  # LYING, or in flight how it left SURFACE (FREE, BOUNCED … of next_impact)
SLIP_ROOTS = 5  # arguments of `follow_contact` for a ball that lies
SLIP_SIGN = 6
BESIDE = 7  # another surface that it touches, or NONE
COLUMNS = 8

NONE = -1
LYING = 4


def at_rest(xs: Floats, y: float) -> Floats:
    """`states`, shape (n, 7), of balls at rest at (xs[i], y), in m."""
    states = np.zeros((len(xs), body.SIZE))
    states[:, body.X] = xs
    states[:, body.Y] = y
    return states


def in_flight(count: int) -> Ints:
    """`initial`, shape (count, COLUMNS), of balls at the start of their drops."""
    initial = np.zeros((count, COLUMNS), np.int64)
    initial[:, HIT] = NONE
    initial[:, SURFACE] = NONE
    initial[:, BESIDE] = NONE
    return initial
