"""What a board consists of, as plain fields, which its checks, digest and JSON form read.

Nothing is checked here. `Board` in model.py is the subclass that checks them.
"""

from dataclasses import dataclass, field
from typing import Final

from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall
from plinko.engine.constants import EARTH_GRAVITY

DEFAULT_WIDTH: Final = 8.0
DEFAULT_HEIGHT: Final = 6.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardFields:
    """Everything except the seed that decides a ball's path.

    Lengths in m (x right, y down), gravity in m/s^2, linear drag in 1/s. `width` and `height`
    belong to the picture, which shows x from -width/2 to width/2 and y from 0 to height; the
    physics ignores them.
    """

    name: str = "board"
    width: float = DEFAULT_WIDTH
    height: float = DEFAULT_HEIGHT
    gravity: float = EARTH_GRAVITY
    drag: float = 0.0
    ball: BallSpec = field(default_factory=BallSpec)
    pegs: tuple[Peg, ...] = ()
    peg_material: Material = field(default_factory=Material)
    walls: tuple[Wall, ...] = ()
    wall_material: Material = field(default_factory=Material)
    bins: Bins
    drop: DropZone = field(default_factory=DropZone)

    @property
    def slots(self) -> tuple[float, ...]:
        """The x in m of the starts that a player can choose from; often empty."""
        return self.drop.slots

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """x_min, x_max, y_min, y_max in m of a box around the picture and all parts of the board.

        On a valid board with walls at its sides, the box contains the ball's whole disc from start
        to landing. Without such walls, the ball may leave the box at a side for a moment.
        """
        reach = self.ball.radius
        half = 0.5 * self.width
        zone, bins = self.drop, self.bins
        xs = [-half, half, bins.edges[0], bins.edges[-1]]
        xs += [zone.x - zone.span - reach, zone.x + zone.span + reach]
        xs += [x + side for x in zone.slots for side in (-reach, reach)]
        ys = [0.0, self.height, zone.y - reach, bins.y + reach]
        for peg in self.pegs:
            xs += (peg.x - peg.radius, peg.x + peg.radius)
            ys += (peg.y - peg.radius, peg.y + peg.radius)
        for wall in self.walls:
            xs += (wall.x1, wall.x2)
            ys += (wall.y1, wall.y2)
        return min(xs), max(xs), min(ys), max(ys)
