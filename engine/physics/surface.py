"""The surfaces of a board as rows of an array, and the geometry of a contact.

A surface is a circle (a peg, or the end of a wall) or a line (a wall between its ends). A surface
is named by its row's number in the array, which has shape (n, COLUMNS).
"""

from math import sqrt

import numpy as np
import numpy.typing as npt

from plinko.engine.jit.decorator import inner_kernel, lean_kernel

Surfaces = npt.NDArray[np.float64]

# Columns. Some have one meaning for circles and another for lines.
X = 0  # of a circle's centre or a line's first end, m
Y = 1
DISTANCE = 2  # circle: contact distance D, the sum of both radii, m; line: 0
DISTANCE2 = 3  # circle: D^2
LENGTH = 3  # line, m
TX = 4  # line: unit vector along it
TY = 5
NX = 6  # line: unit normal
NY = 7
FIRST_END = 8  # line: the circles as which it continues at its two ends
LAST_END = 9
END_X = 10  # line: its last end, m
END_Y = 11
NEXT = 12  # line: the next piece of the same straight wall, -1 for none
FROM = 13  # line: where this piece begins and ends along the whole wall, m
TO = 14
INVERSE = 8  # circle: 1 / D
OWNER = 15  # the item that owns this surface: itself, unless it is a part of another one
COLUMNS = 16

ROUNDING = 2.0**-50
"""Uncertainty of a position relative to |x| + |y|: four units in the last place."""


@inner_kernel
def rounding(x: float, y: float) -> float:
    """Uncertainty in m of a position (x, y): what is nearer touches, within rounding."""
    return ROUNDING * (abs(x) + abs(y))


@inner_kernel
def ends_in(items: Surfaces, line: int, circle: int) -> bool:
    """Whether `line` is a line, and continues as this circle at one of its ends."""
    row = items[line]
    return bool(row[DISTANCE] == 0.0 and (row[FIRST_END] == circle or row[LAST_END] == circle))


@inner_kernel
def is_flush(items: Surfaces, radius: float, line: int, side: float, circle: int) -> bool:
    """Whether the circle rises just to the height of a ball's centre on `side` of the line.

    There the two touch without crossing: a ball on the line passes the circle without an impact,
    and where the line ends the ball passes onto it. A wall is flush with the circles of its ends.
    """
    dx = items[circle, X] - items[line, X]
    dy = items[circle, Y] - items[line, Y]
    height = side * (items[line, NX] * dx + items[line, NY] * dy) + items[circle, DISTANCE]
    near = rounding(items[circle, X], items[circle, Y]) + rounding(items[line, X], items[line, Y])
    return bool(abs(height - radius) <= near + ROUNDING * items[circle, DISTANCE])


@inner_kernel
def touch(
    items: Surfaces, radius: float, item: int, side: float, x: float, y: float
) -> tuple[float, float, float, float]:
    """Unit normal (nx, ny) of `item` towards a ball that touches it at (x, y), and the centre of
    the ball at the exact distance.

    `radius` is the ball's, `side` (1 or -1) its side of a line; lengths in m. The centre moves only
    by rounding errors; otherwise these would add up over many bounces on one surface.
    """
    dx = x - items[item, X]
    dy = y - items[item, Y]
    distance = items[item, DISTANCE]
    if distance > 0.0:
        length = sqrt(dx * dx + dy * dy)
        nx = dx / length
        ny = dy / length
        return nx, ny, items[item, X] + distance * nx, items[item, Y] + distance * ny
    nx = side * items[item, NX]
    ny = side * items[item, NY]
    gap = radius - (dx * nx + dy * ny)
    return nx, ny, x + gap * nx, y + gap * ny


@lean_kernel
def gap_of(items: Surfaces, radius: float, item: int, side: float, x: float, y: float) -> float:
    """Distance in m between `item` and a ball at (x, y) on this side of it; negative if inside.

    Of a circle, it is the first-order distance, which is exact only near the circle.
    """
    dx = x - items[item, X]
    dy = y - items[item, Y]
    distance = items[item, DISTANCE]
    if distance > 0.0:
        return float(0.5 * (dx * dx + dy * dy - distance * distance) * items[item, INVERSE])
    return float(side * (dx * items[item, NX] + dy * items[item, NY]) - radius)


@inner_kernel
def side_of(items: Surfaces, item: int, x: float, y: float) -> float:
    """The side of a line on which a ball at (x, y) is, 1 or -1; 0 for a circle."""
    row = items[item]
    if row[DISTANCE] > 0.0:
        return 0.0
    d = (x - row[X]) * row[NX] + (y - row[Y]) * row[NY]
    return 1.0 if d > 0.0 else -1.0


@inner_kernel
def curvature(items: Surfaces, item: int) -> float:
    """Curvature of the centre's path on `item`, 1/m: 1/D on a circle, 0 on a line."""
    distance = items[item, DISTANCE]
    return 1.0 / distance if distance > 0.0 else 0.0
