"""Scenes of many balls that touch each other, the same for every engine."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from plinko.engine import Arena, ArenaSettings, Board, StaticGeometry
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import Wall

Floats = npt.NDArray[np.float64]

MATERIAL = Material(0.5, 0.2)
DENSITY = 80.0
DT = 1.0 / 60.0


@dataclass(frozen=True)
class Heap:
    """Static geometry and n equal balls at rest, all of one material, with Earth's gravity."""

    name: str
    place: StaticGeometry
    x: Floats
    y: Floats
    radius: float

    def arena(self, *, sleeping: bool) -> Arena:
        """The scene in our engine, with its default substeps."""
        arena = Arena(self.place, ArenaSettings(sleeping=sleeping, dt=DT))
        arena.add_many(
            self.x, self.y, radius=self.radius, density=DENSITY,
            restitution=MATERIAL.restitution, friction=MATERIAL.friction,
        )  # fmt: skip
        return arena


def _rows(n: int, left: float, right: float, top: float, radius: float, up: bool) -> list[Floats]:
    """Centres in rows that do not touch, each shifted a little to break the symmetry."""
    step = 2.4 * radius
    columns = int((right - left) / step)
    k = np.arange(n)
    rng = np.random.default_rng(1)
    room = 0.15 * radius
    x = left + (k % columns + 0.5) * ((right - left) / columns) + rng.uniform(-room, room, n)
    y = (k // columns + 0.5) * step + rng.uniform(-room, room, n)
    return [x, top - y if up else top + y]


def box(n: int = 500, radius: float = 0.08) -> Heap:
    """n balls that fill about half of a closed box, whose area is proportional to n."""
    side = float(np.sqrt(n / 500.0)) * 5.0
    geometry = StaticGeometry.box(
        side, side, restitution=MATERIAL.restitution, friction=MATERIAL.friction
    )
    x, y = _rows(n, -0.5 * side, 0.5 * side, 0.0, radius, up=False)
    return Heap(f"{n} in the box", geometry, x, y, radius)


def board(n: int = 500, radius: float = 0.06) -> Heap:
    """n balls above the 12-row board, half as large as its ball; the bins have a floor."""
    preset = Board.preset("triangle-12")
    mouth = preset.walls[0]
    foot = preset.walls[2]
    rise = -12.0
    walls = (
        *preset.walls,
        Wall(mouth.x1, mouth.y1, mouth.x1, rise),
        Wall(-mouth.x1, mouth.y1, -mouth.x1, rise),
        Wall(-foot.x2, foot.y2, foot.x2, foot.y2),
    )
    geometry = replace(
        StaticGeometry.of_board(preset),
        walls=walls,
        bins=None,
        peg_material=MATERIAL,
        wall_material=MATERIAL,
    )
    x, y = _rows(n, -mouth.x1, mouth.x1, mouth.y1, radius, up=True)
    return Heap(f"{n} on the 12-row board", geometry, x, y, radius)


@dataclass(frozen=True)
class Gas:
    """A heap's balls in motion, without gravity, friction or loss; velocities in m/s."""

    heap: Heap
    vx: Floats
    vy: Floats


def gas(n: int = 500, radius: float = 0.08, speed: float = 2.0) -> Gas:
    """The balls of `box`, elastic, at the same speed in directions from a fixed seed."""
    heap = box(n, radius)
    angle = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, n)
    elastic = replace(heap.place, peg_material=Material(1.0, 0.0), wall_material=Material(1.0, 0.0))
    moving = replace(heap, name=f"{n} elastic balls", place=elastic)
    return Gas(moving, speed * np.cos(angle), speed * np.sin(angle))


def overlap(heap: Heap, x: Floats, y: Floats) -> float:
    """Deepest overlap of balls at these positions, in radii."""
    arena = Arena(heap.place)
    arena.add_many(x, y, radius=heap.radius)
    return arena.diagnostics().penetration_radii


def lost(heap: Heap, x: Floats, y: Floats) -> int:
    """Number of balls outside of the heap's walls."""
    sides = [side for wall in heap.place.walls for side in (wall.x1, wall.x2)]
    floor = max(max(wall.y1, wall.y2) for wall in heap.place.walls)
    return int(np.count_nonzero((x < min(sides)) | (x > max(sides)) | (y > floor)))
