"""The phase of a drop as a row of numbers, from which a solver starts or continues it."""

from typing import NamedTuple

import numpy as np

from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats, Ints

# Columns of `initial`, whose rows belong to those of `states`.
HIT = 0  # the surface that the ball is hitting now, or NONE
HIT_SIDE = 1  # its side of a line, 1 or -1
# Used only if the ball is not hitting a surface:
SURFACE = 2  # the surface that it left last or lies on; NONE if it has not touched any
SIDE = 3  # its side of a line, 1 or -1
PHASE = 4  # LYING, or in flight how it left SURFACE (FREE, BOUNCED … of next_impact)
SLIP_ROOT = 5  # the rest is `Resume`
SLIP_SIGN = 6
SECOND_SURFACE = 7
COLUMNS = 8

NONE = -1
LYING = 4


class Resume(NamedTuple):
    """What else a ball that leaves a surface or lies on it continues with.

    slip_root: the order of the slip's root in a contact. 0: no root, the slip is computed. 1: the
    slip is zero, because an impact stopped it. 2: its rate is zero too, because a rolling ball has
    just begun to slip in the direction slip_sign. second_surface: another surface that the ball
    touches and does not move into, or NONE.
    """

    slip_root: int
    slip_sign: float
    second_surface: int


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
    initial[:, SECOND_SURFACE] = NONE
    return initial
