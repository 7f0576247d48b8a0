"""Sweeps of a substep as arrays: the straight path each ball is on, and its predicted impact."""

from typing import NamedTuple

from engine.multibody.solver.layout.array_types import Floats, Ints

# Columns of `Sweeps.path`.
X0 = 0  # centre in m at the start of the substep, had the ball been on this path then
Y0 = 1
VX = 2  # velocity along the path, m/s; zero for a ball that sleeps or is frozen
VY = 3
RADIUS = 4
RESTITUTION = 5
STATUS = 6
SINCE = 7  # s: when the ball came to this path
COLUMNS = 8

# Values of STATUS.
AWAKE = 0.0
ASLEEP = 1.0
GONE = 2.0

# Columns of `Sweeps.state`.
IMPACTS = 0  # impacts of the ball in this substep
VERSION = 1  # changes with each of them: predictions made before no longer hold
FROZEN = 2  # whether the ball stays where it is until the substep ends

# Columns of `Sweeps.predicted`.
PARTNER = 0  # a ball's row, -1 - item, EXPIRY or NOTHING
PARTNER_VERSION = 1  # the partner's VERSION when this was predicted

NOTHING = -2147483648
EXPIRY = -2147483647  # the ball leaves the margin within which its neighbour list holds


class Sweeps(NamedTuple):
    """Work space of a step: each ball's path, and the first impact predicted for it.

    `tree` is a winner tree (Knuth, The Art of Computer Programming 3, 5.4.1): the balls' times of
    impact from row m on, and in each row k below the lesser of the rows 2k and 2k + 1.
    """

    path: Floats  # (n, 8)
    state: Ints  # (n, 3): IMPACTS, VERSION, FROZEN
    predicted: Ints  # (n, 2): PARTNER, PARTNER_VERSION
    tree: Floats  # (2 m,), m >= n a power of two
