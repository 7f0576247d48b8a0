"""A billiard: pegs and walls without bins; the pegs may repeat without end."""

import dataclasses
import math
from functools import cached_property
from typing import Any, Final

from plinko.engine.board import values
from plinko.engine.board.fields import BoardFields
from plinko.engine.board.form import MIN_RADIUS, field_of
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Bins, Peg, Wall
from plinko.engine.errors import BoardError

Vector = tuple[float, float]

ELASTIC: Final = Material(restitution=1.0, friction=0.0)

_GRAVITY: Final = field_of("board", "gravity")._replace(low=0.0)

_NO_BINS: Final = Bins(math.inf, (-1.0, 1.0), (0.0,))
"""Bins on a line that no ball crosses. The search pays one comparison per window for it."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Billiard:
    """The surroundings of a ball. SI units, x right, y down; raises BoardError for a bad value.

    ball: a disc; its centre moves like a point among pegs that are larger by its radius. material:
    of all pegs and walls. gravity in m/s^2, 0 or more; linear drag in 1/s. cell: two vectors in m
    by which the pegs repeat in all directions; None: nothing repeats.
    """

    pegs: tuple[Peg, ...] = ()
    walls: tuple[Wall, ...] = ()
    ball: BallSpec = dataclasses.field(default_factory=lambda: BallSpec(restitution=1.0))
    material: Material = ELASTIC
    gravity: float = 0.0
    drag: float = 0.0
    cell: tuple[Vector, Vector] | None = None

    def __post_init__(self) -> None:
        """Replace the values by checked floats."""
        checked: dict[str, Any] = {
            "pegs": values.pegs(self.pegs),
            "walls": values.walls(self.walls),
            "ball": values.CHECKS["ball"](self.ball),
            "material": values.material(self.material, "material"),
            "gravity": values.number(self.gravity, "gravity", _GRAVITY),
            "drag": values.CHECKS["drag"](self.drag),
            "cell": None if self.cell is None else _cell(self.cell, self.pegs, self.walls),
        }
        for key, value in checked.items():
            object.__setattr__(self, key, value)

    @cached_property
    def fields(self) -> BoardFields:
        """The billiard as a board for the exact solver, without copies of the pegs."""
        return self.with_pegs(self.pegs)

    def with_pegs(self, pegs: tuple[Peg, ...]) -> BoardFields:
        """`fields` with other pegs: the pegs of one cell and their copies around it."""
        return BoardFields(
            name="billiard",
            gravity=self.gravity,
            drag=self.drag,
            ball=self.ball,
            pegs=pegs,
            peg_material=self.material,
            walls=self.walls,
            wall_material=self.material,
            bins=_NO_BINS,
        )


def _cell(cell: Any, pegs: tuple[Peg, ...], walls: tuple[Wall, ...]) -> tuple[Vector, Vector]:
    """Return `cell` as two vectors of floats; raises BoardError unless they span an area."""
    if walls or not pegs:
        raise BoardError(
            f"cell is given with {len(pegs)} pegs and {len(walls)} walls: a billiard that repeats "
            "has pegs, at least one, and no walls",
            field="cell",
        )
    vectors = values.items(cell, "cell", 2)
    wanted = "it must be two vectors, each of two numbers in m"
    if len(vectors) != 2:
        raise values.fail("cell", cell, wanted)
    found: list[Vector] = []
    for i, vector in enumerate(vectors):
        parts = values.items(vector, f"cell[{i}]", 2)
        if len(parts) != 2:
            raise values.fail(f"cell[{i}]", vector, wanted)
        x, y = (values.number(part, f"cell[{i}][{j}]") for j, part in enumerate(parts))
        found.append((x, y))
    (ax, ay), (bx, by) = found
    if not abs(ax * by - ay * bx) >= MIN_RADIUS**2:
        raise values.fail("cell", cell, "its two vectors must not be parallel")
    return found[0], found[1]
