"""Static geometry: the pegs, walls and bins of an arena, and their form for the kernels."""

import hashlib
import math
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf, sqrt
from typing import Any

import numpy as np
import numpy.typing as npt

from plinko.engine.board import values as validation
from plinko.engine.board.materials import Material
from plinko.engine.board.model import Board
from plinko.engine.board.parts import Bins, Peg, Wall
from plinko.engine.canonical import float_bits
from plinko.engine.errors import BoardError
from plinko.engine.multibody.solver.layout import shape
from plinko.engine.multibody.solver.layout.shape import StaticShapes

_CELLS = 64
"""Most cells along the grid's longer side. With finer cells a long wall is listed in more of them;
with coarser ones a ball has more pegs to test. With 64, a cell of a board has a peg or two."""


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
            "pegs": [{"x": p.x, "y": p.y, "radius": p.radius} for p in self.pegs],
            "peg_material": _material_dict(self.peg_material),
            "walls": [{"x1": w.x1, "y1": w.y1, "x2": w.x2, "y2": w.y2} for w in self.walls],
            "wall_material": _material_dict(self.wall_material),
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
            pegs=tuple(Peg(p["x"], p["y"], p["radius"]) for p in values["pegs"]),
            walls=tuple(Wall(w["x1"], w["y1"], w["x2"], w["y2"]) for w in values["walls"]),
            peg_material=Material(**values["peg_material"]),
            wall_material=Material(**values["wall_material"]),
            bins=bins and Bins(bins["y"], tuple(bins["edges"]), tuple(bins["multipliers"])),
        )


def _material_dict(material: Material) -> dict[str, float]:
    return {"restitution": material.restitution, "friction": material.friction}


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
    items = _items(geometry)
    x0, x1, y0, y1 = geometry.extent
    side = max(x1 - x0, y1 - y0, 1e-9)
    count = min(_CELLS, max(1, math.isqrt(32 * len(items))))
    scale = count / side
    columns = int((x1 - x0) * scale) + 1
    rows = int((y1 - y0) * scale) + 1
    starts, members = _grid(items, x0, y0, scale, columns, rows)
    return StaticShapes(
        items=items,
        peg_count=len(geometry.pegs),
        x0=x0,
        y0=y0,
        cells_per_metre=scale,
        columns=columns,
        rows=rows,
        starts=starts,
        members=members,
        bins_y=geometry.bins.y if geometry.bins else inf,
    )


def _items(geometry: StaticGeometry) -> npt.NDArray[np.float64]:
    items = np.zeros((len(geometry.pegs) + len(geometry.walls), shape.COLUMNS))
    surface = geometry.peg_material
    for row, peg in zip(items, geometry.pegs, strict=False):
        row[:] = peg.x, peg.y, 1.0, 0.0, 0.0, peg.radius, surface.restitution, surface.friction
    surface = geometry.wall_material
    for row, wall in zip(items[len(geometry.pegs) :], geometry.walls, strict=True):
        dx, dy = wall.x2 - wall.x1, wall.y2 - wall.y1
        length = sqrt(dx * dx + dy * dy)
        row[:] = (
            wall.x1, wall.y1, dx / length, dy / length, length, 0.0,
            surface.restitution, surface.friction,
        )  # fmt: skip
    return items


def _grid(
    items: npt.NDArray[np.float64], x0: float, y0: float, scale: float, columns: int, rows: int
) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """The items in each cell: starts, shape (cells + 1,), and members, ascending in each cell."""
    lists: list[list[int]] = [[] for _ in range(columns * rows)]
    size = 1.0 / scale
    for item, (x, y, tx, ty, length, thickness, _, _) in enumerate(items.tolist()):
        ends_x, ends_y = (x, x + length * tx), (y, y + length * ty)
        low = max(int((min(ends_x) - thickness - x0) * scale) - 1, 0)
        high = min(int((max(ends_x) + thickness - x0) * scale) + 1, columns - 1)
        top = max(int((min(ends_y) - thickness - y0) * scale) - 1, 0)
        bottom = min(int((max(ends_y) + thickness - y0) * scale) + 1, rows - 1)
        for row in range(top, bottom + 1):
            for column in range(low, high + 1):
                dx = x0 + (column + 0.5) * size - x
                dy = y0 + (row + 0.5) * size - y
                along = min(max(dx * tx + dy * ty, 0.0), length)
                dx -= along * tx
                dy -= along * ty
                near = thickness + 0.7072 * size * (1.0 + 1e-6)
                if dx * dx + dy * dy <= near * near:
                    lists[row * columns + column].append(item)
    starts = np.cumsum([0, *(len(members) for members in lists)]).astype(np.int32)
    return starts, np.array([i for members in lists for i in members], np.int32)
