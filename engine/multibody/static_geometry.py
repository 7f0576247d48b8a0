"""Static geometry: the pegs, walls and bins of an arena, and their form for the kernels."""

import hashlib
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf
from typing import Any

import numpy as np

from plinko.engine.board import values as validation
from plinko.engine.board.json_form import surfaces_dict
from plinko.engine.board.materials import Material
from plinko.engine.board.model import Board
from plinko.engine.board.parts import Bins, Peg, Wall
from plinko.engine.canonical import float_bits
from plinko.engine.errors import BoardError
from plinko.engine.multibody.solver.layout.shape import StaticShapes
from plinko.engine.multibody.solver.static_grid import lay_out_shapes


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class StaticGeometry:
    """Pegs and walls, their materials, and bins, if any; coordinates in m, y down.

    Raises BoardError for an invalid value. The geometry is not checked: the parts may form a closed
    box or a trap.
    """

    pegs: tuple[Peg, ...] = ()
    walls: tuple[Wall, ...] = ()
    peg_material: Material = field(default_factory=Material)
    wall_material: Material = field(default_factory=Material)
    bins: Bins | None = None
    digest: str = field(init=False, compare=False)
    """SHA-256 of the content, 64 hex digits."""

    def __post_init__(self) -> None:
        checked: dict[str, Any] = {
            "pegs": validation.pegs(self.pegs),
            "walls": validation.walls(self.walls),
            "peg_material": validation.material(self.peg_material, "peg_material"),
            "wall_material": validation.material(self.wall_material, "wall_material"),
            "bins": None if self.bins is None else validation.bins(self.bins),
        }
        for key, value in checked.items():
            object.__setattr__(self, key, value)
        object.__setattr__(self, "digest", _digest(self))

    def __repr__(self) -> str:
        bins = f"{self.bins.count} bins" if self.bins else "no bins"
        parts = f"{len(self.pegs)} pegs, {len(self.walls)} walls, {bins}"
        return f"<StaticGeometry of {parts}, digest {self.digest[:12]}>"

    @classmethod
    def box(
        cls, width: float, height: float, *, restitution: float = 0.6, friction: float = 0.2
    ) -> "StaticGeometry":
        """A closed box without pegs, x from -width/2 to width/2 and y from 0 to height."""
        for name, value in (("width", width), ("height", height)):
            if not 0.0 < value < inf:
                raise BoardError(f"{name} is {value!r}: it must be greater than 0", field=name)
        half = 0.5 * width
        corners = ((-half, 0.0), (half, 0.0), (half, height), (-half, height))
        return cls(
            walls=tuple(Wall(*corners[i], *corners[(i + 1) % 4]) for i in range(4)),
            wall_material=Material(restitution, friction),
        )

    @classmethod
    def of_board(cls, board: Board | str) -> "StaticGeometry":
        """The pegs, walls and bins of `board`, which may be a preset's name."""
        board = Board.named(board)
        return cls(
            pegs=board.pegs,
            walls=board.walls,
            peg_material=board.peg_material,
            wall_material=board.wall_material,
            bins=board.bins,
        )

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """x_min, x_max, y_min, y_max in m of all parts."""
        xs = [x for w in self.walls for x in (w.x1, w.x2)]
        ys = [y for w in self.walls for y in (w.y1, w.y2)]
        for peg in self.pegs:
            xs += (peg.x - peg.radius, peg.x + peg.radius)
            ys += (peg.y - peg.radius, peg.y + peg.radius)
        if self.bins:
            xs += (self.bins.edges[0], self.bins.edges[-1])
            ys.append(self.bins.y)
        if not xs:
            return 0.0, 0.0, 0.0, 0.0
        return min(xs), max(xs), min(ys), max(ys)

    def to_dict(self) -> dict[str, Any]:
        """The JSON form of the parts, as in a board's, and the extent."""
        return {
            **surfaces_dict(self.pegs, self.peg_material, self.walls, self.wall_material),
            "bins": self.bins
            and {
                "y": self.bins.y,
                "edges": list(self.bins.edges),
                "multipliers": list(self.bins.multipliers),
            },
            "extent": list(self.extent),
        }

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "StaticGeometry":
        """Read the geometry from the JSON form of `to_dict`."""
        bins = values["bins"]
        return cls(
            pegs=tuple(Peg(**p) for p in values["pegs"]),
            walls=tuple(Wall(**w) for w in values["walls"]),
            peg_material=Material(**values["peg_material"]),
            wall_material=Material(**values["wall_material"]),
            bins=bins and Bins(bins["y"], tuple(bins["edges"]), tuple(bins["multipliers"])),
        )


def _digest(geometry: StaticGeometry) -> str:
    rows: list[float] = [geometry.peg_material.restitution, geometry.peg_material.friction]
    rows += [geometry.wall_material.restitution, geometry.wall_material.friction]
    rows += [float(len(geometry.pegs)), float(len(geometry.walls))]
    for peg in geometry.pegs:
        rows += (peg.x, peg.y, peg.radius)
    for wall in geometry.walls:
        rows += (wall.x1, wall.y1, wall.x2, wall.y2)
    if geometry.bins:
        rows += (geometry.bins.y, *geometry.bins.edges, *geometry.bins.multipliers)
    return hashlib.sha256(b"plinko place" + float_bits(rows).tobytes()).hexdigest()


@lru_cache(maxsize=64)
def static_shapes(geometry: StaticGeometry) -> StaticShapes:
    """The kernels' form of `geometry`, cached for the last 64."""
    pegs, walls = geometry.peg_material, geometry.wall_material
    return lay_out_shapes(
        np.array([(p.x, p.y, p.radius) for p in geometry.pegs], np.float64).reshape(-1, 3),
        np.array([(w.x1, w.y1, w.x2, w.y2) for w in geometry.walls], np.float64).reshape(-1, 4),
        pegs.restitution, pegs.friction, walls.restitution, walls.friction, *geometry.extent,
        geometry.bins.y if geometry.bins else inf,
    )  # fmt: skip
