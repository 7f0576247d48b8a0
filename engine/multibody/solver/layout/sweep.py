"""The sweeps of a substep: each ball's straight path, and its predicted first impact."""

from typing import NamedTuple

from plinko.engine.multibody.solver.layout.array_types import Floats, Ints

# Columns of `Sweeps.path`.
X0 = 0  # centre in m, extrapolated along the path back to the start of the substep
Y0 = 1
VX = 2  # velocity along the path, m/s; zero for a ball that sleeps or is frozen
VY = 3
RADIUS = 4
RESTITUTION = 5
STATUS = 6
SINCE = 7  # time in the substep, s, to which `Bodies.pos` is advanced
COLUMNS = 8

# Values of STATUS.
AWAKE = 0.0
ASLEEP = 1.0
GONE = 2.0

# Columns of `Sweeps.state`.
IMPACTS = 0  # impacts of the ball in this substep
VERSION = 1  # changes with each impact, which makes earlier predictions invalid
FROZEN = 2  # whether the ball stays at its place until the substep ends

# Columns of `Sweeps.predicted`.
PARTNER = 0  # a ball's row, -1 - item, EXPIRY or NOTHING
PARTNER_VERSION = 1  # the partner's VERSION at the time of the prediction

NOTHING = -2147483648
EXPIRY = -2147483647  # the ball leaves the margin within which the neighbour list is valid


class Sweeps(NamedTuple):
    """Work space of a step: each ball's path, and its predicted first impact.

    `tree` is a winner tree (Knuth, The Art of Computer Programming 3, 5.4.1). Row m + i has ball
    i's time of impact, and each row k < m the lesser of the rows 2k and 2k + 1, so row 1 has the
    least of all.
    """

    path: Floats  # (n, 8)
    state: Ints  # (n, 3): IMPACTS, VERSION, FROZEN
    predicted: Ints  # (n, 2): PARTNER, PARTNER_VERSION
    tree: Floats  # (2 m,), m >= n a power of two
