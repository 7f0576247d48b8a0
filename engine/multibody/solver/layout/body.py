"""The balls: columns of the arrays in `Bodies`, and the bits of a ball's flags."""

from typing import NamedTuple

from plinko.engine.multibody.solver.layout.array_types import Floats, Ints

# Columns of `Bodies.pos`.
X = 0  # centre, m
Y = 1
RIM_ARC = 2  # theta R, m: arc length by which the rim has turned
RADIUS = 3

# Columns of `Bodies.vel`.
VX = 0  # m/s
VY = 1
RIM_SPEED = 2  # omega R, m/s
INVERSE_MASS = 3  # 1/kg; R^2 / I of a uniform disc is twice that

# Columns of `Bodies.surface`.
RESTITUTION = 0
FRICTION = 1

# Columns of `Bodies.anchor`.
ANCHOR_X = 0  # place of the ball when its neighbours were listed, m
ANCHOR_Y = 1
MARGIN = 2  # distance from there up to which the neighbour list is valid, m

# Columns of `Bodies.marks`.
ID = 0
FLAGS = 1
STILL_STEPS = 2  # consecutive steps in which the ball was slow
NEXT_IN_ISLAND = 3  # row of the next ball in its sleeping island, a circular list; else its own row

# Bits of FLAGS.
ASLEEP = 1
BOUNCED = 2
LANDED = 4
LEFT = 8
GONE = LANDED | LEFT


class Bodies(NamedTuple):
    """Balls in rows by ascending id; the last row of `pos` and `vel` represents all fixed shapes.

    n is the room for balls. Kernels take the number of rows in use as an argument.
    """

    pos: Floats  # (n + 1, 4): X, Y, RIM_ARC, RADIUS
    vel: Floats  # (n + 1, 4): VX, VY, RIM_SPEED, INVERSE_MASS
    surface: Floats  # (n, 2): RESTITUTION, FRICTION
    anchor: Floats  # (n, 3): ANCHOR_X, ANCHOR_Y, MARGIN
    marks: Ints  # (n, 4): ID, FLAGS, STILL_STEPS, NEXT_IN_ISLAND
