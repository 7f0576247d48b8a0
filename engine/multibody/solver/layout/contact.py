"""The contacts of a substep: the work space of the contact solver."""

from typing import NamedTuple

from plinko.engine.multibody.solver.layout.array_types import Floats, Ints

# Columns of `Contacts.ends`.
A = 0  # row of a ball
B = 1  # row of the other ball, or the last row of `Bodies.pos` for a fixed shape
PAIR = 2  # row in the neighbour list
END_COLUMNS = 3

# Columns of `Contacts.rows`.
NORMAL_X = 0
NORMAL_Y = 1
MASS = 2  # effective mass of the pair along the normal, kg; along the tangent it is a third
BIAS = 3  # approach that closes the gap within the substep, m/s
FRICTION = 4  # friction coefficient of the pair
NORMAL_IMPULSE = 5  # accumulated, N s
TANGENT_IMPULSE = 6
TORQUE_IMPULSE = 7  # accumulated, N m s
COLUMNS = 8


class Contacts(NamedTuple):
    """Room for a contact of each pair. Kernels take the number of contacts as an argument."""

    ends: Ints  # (p, 3): A, B, PAIR
    rows: Floats  # (p, 8)
