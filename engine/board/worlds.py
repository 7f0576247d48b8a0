"""The worlds: triangles with gravity, air, balls and pegs of their own, as a row of numbers each.

Planets have their own gravity. There, one kind of light ball falls through the air; its drag is
proportional to the air's density, so there is none on the Moon. Glass, steel and rubber balls fall
on the house table, with pegs of the same material. A board's size is chosen for the time of a fall.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

from plinko.engine.board.materials import GRAVITY

TABLE_GRAVITY: Final = 24.79
"""m/s^2. On the reference game's scale a triangle is 7.6 m wide. Under Earth's gravity a ball would
need six seconds for 16 rows, which is slow to watch. This gravity gives the motion on a board 3 m
wide under Earth's gravity, magnified to 7.6 m (Froude's law: for equal times, g scales as length).
"""


class World(NamedTuple):
    """Gravity in m/s^2, drag in 1/s; restitution and friction, the same for ball, pegs and walls;
    ball and peg radii in peg spacings; the board's size in the house table's."""

    gravity: float
    drag: float
    restitution: float
    friction: float
    ball: float = 0.21
    peg: float = 0.105
    size: float = 1.0


WORLDS: Final[Mapping[str, World]] = {
    "earth": World(GRAVITY["Earth"], 2.5, 0.7, 0.2, ball=0.2, size=0.8),
    "moon": World(GRAVITY["Moon"], 0.0, 0.7, 0.3, ball=0.18, size=0.3),
    "mars": World(GRAVITY["Mars"], 0.04, 0.75, 0.5, ball=0.2, peg=0.14, size=0.45),
    "jupiter": World(GRAVITY["Jupiter"], 4.0, 0.75, 0.3, ball=0.2),
    "glass": World(TABLE_GRAVITY, 3.0, 0.95, 0.05),
    "steel": World(TABLE_GRAVITY, 3.0, 0.875, 0.1),
    "rubber": World(TABLE_GRAVITY, 3.0, 0.8, 0.9),
}
"""By the first part of their presets' names."""
