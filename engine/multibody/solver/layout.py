"""What the kernels of touching balls work on: bodies, surroundings, pairs, settings, logs."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]
Counts = npt.NDArray[np.int64]

# Columns of `Bodies.pos`.
X = 0  # centre, m
Y = 1
ARC = 2  # theta R, m: how far the rim has turned
RADIUS = 3

# Columns of `Bodies.vel`.
VX = 0  # m/s
VY = 1
ROLL = 2  # omega R, m/s: speed of the rim
INVERSE_MASS = 3  # 1/kg; a disc's R^2 / I is twice that

# Columns of `Bodies.surface`.
RESTITUTION = 0
FRICTION = 1

# Columns of `Bodies.home`.
HOME_X = 0  # where the ball was when its pairs were listed, m
HOME_Y = 1
BUDGET = 2  # how far from there the list holds good, m

# Columns of `Bodies.marks`.
ID = 0
FLAGS = 1
STILL = 2  # frames in a row in which the ball was slow
RING = 3  # next row of the island it fell asleep with

# Bits of FLAGS.
ASLEEP = 1
BOUNCED = 2
LANDED = 4
LEFT = 8
GONE = LANDED | LEFT


class Bodies(NamedTuple):
    """Balls in rows by ascending id; the last row of `pos` and `vel` stands for all that is fixed.

    n is the room for balls; the rows in use are passed along.
    """

    pos: Floats  # (n + 1, 4): X, Y, ARC, RADIUS
    vel: Floats  # (n + 1, 4): VX, VY, ROLL, INVERSE_MASS
    surface: Floats  # (n, 2): RESTITUTION, FRICTION
    home: Floats  # (n, 3): HOME_X, HOME_Y, BUDGET
    marks: Ints  # (n, 4): ID, FLAGS, STILL, RING


# Columns of `Statics.items`.
X1 = 0  # first end of a segment, or a peg's centre, m
Y1 = 1
TX = 2  # unit vector along the segment; (1, 0) for a peg
TY = 3
LENGTH = 4  # 0 for a peg
THICKNESS = 5  # a peg's radius; 0 for a wall
ITEM_RESTITUTION = 6
ITEM_FRICTION = 7
ITEM_COLUMNS = 8


class Statics(NamedTuple):
    """Pegs, then walls: segments with a radius, in a grid of cells that lists what passes each."""

    items: Floats  # (m, 8)
    peg_count: int
    x0: float  # corner of the grid, m
    y0: float
    cells_per_metre: float
    columns: int
    rows: int
    starts: Ints  # (columns rows + 1,)
    members: Ints  # item numbers, ascending in each cell
    bins_y: float  # m; infinite where nothing lands


class Pairs(NamedTuple):
    """Who may touch whom before the next listing: ball a owns the rows starts[a] to starts[a+1].

    A pair belongs to one of its balls; the other is a ball's row, or -1 - item for a fixed one.
    """

    starts: Ints  # (n + 1,)
    other: Ints  # (p,)
    impulse: Floats  # (p, 2): normal and tangential impulse of the last substep, N s
    near_starts: Ints  # (n + 1,)
    near: Ints  # all that may touch a ball, whoever owns the pair: near_starts as starts


class Settings(NamedTuple):
    """What a frame is computed with; SI."""

    gravity: float
    drag: float
    damping: float  # of the velocity, per frame
    correction: float
    h: float  # a substep, s
    substeps: int
    max_speed: float  # infinite: no clamp
    sleep_frames: int  # frames of stillness before a ball may sleep; 0: never


class Lines(NamedTuple):
    """Work space of a frame: the straight line each ball is on, and what it meets first."""

    at: Floats  # (n, 8): columns in multibody/solver/prediction.py
    state: Ints  # (n, 3): HITS, STAMP, WAITING
    seen: Ints  # (n, 2): PARTNER, STAMP_THEN
    tree: Floats  # (2 m,), m >= n a power of two: times from row m on, above them the least of two


# Columns of `Log.floats` and `Log.ints`.
LOG_T = 0  # s since the start of the frame
LOG_X = 1  # of ball a's centre, m
LOG_Y = 2
LOG_SPEED = 3  # approach along the normal, m/s
LOG_A = 0  # ids
LOG_B = 1  # an id, or -1 - item

TOUCHES = 0
LANDINGS = 1
REBUILDS = 2
WAITS = 3
EVENTS = 4
CONTACTS = 5
DEPARTURES = 6  # not 0: balls went too far to be followed
AWAKE_THEN = 7  # balls awake when the frame began
COUNTS = 8


class Log(NamedTuple):
    """Impacts and landings of a frame; what does not fit is counted and left out."""

    floats: Floats  # (m, 4)
    ints: Ints  # (m, 2)
    landings: Floats  # (k, 2): t since the start of the frame in s, x in m
    landed: Ints  # (k,): ids
    counts: Counts  # (8,)
