"""Makes arenas: the sandbox, a pile-up on a Galton board, any board with balls that touch.

A seed (SplitMix64) decides where the balls begin; nothing is random afterwards.
"""

from collections.abc import Mapping
from math import floor, sqrt
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.materials import GRAVITY, REFERENCE_DENSITY, RESTITUTION
from plinko.engine.board.model import Board
from plinko.engine.board.parts import Wall
from plinko.engine.errors import ParameterError
from plinko.engine.multibody.arena import Arena
from plinko.engine.multibody.settings import ArenaSettings
from plinko.engine.multibody.static_geometry import StaticGeometry
from plinko.engine.parameters import number
from plinko.engine.seeding import splitmix64

GRAVITY_PRESETS: Final[Mapping[str, float]] = {**GRAVITY, "none": 0.0}
"""Gravity in m/s^2."""

RESTITUTION_PRESETS: Final[Mapping[str, float]] = {
    row.name: 0.5 * (row.low + row.high) for row in RESTITUTION
}
"""The middle of each measured range of restitution, by its name."""

MAX_SCENE_BALLS: Final = 20_000

_CELL: Final = 2.3
"""Grid spacing of new balls in largest radii: more than 2, so that each can be moved a little."""


def _uniform(seed: int, count: int, low: float, high: float) -> npt.NDArray[np.float64]:
    """`count` uniform numbers in [low, high), by SplitMix64 from `seed`."""
    first = splitmix64(seed)
    draws = [splitmix64((first + i) & (2**64 - 1)) >> 11 for i in range(count)]
    return low + (high - low) * (np.array(draws, np.float64) * 2.0**-53)


def _count(n: object) -> int:
    if isinstance(n, bool) or not isinstance(n, int) or not 0 <= n <= MAX_SCENE_BALLS:
        raise ParameterError(f"n {n!r:.40} is not from 0 to {MAX_SCENE_BALLS}", field="n")
    return n


def sandbox(
    n: int = 50,
    *,
    gravity: float = GRAVITY_PRESETS["Earth"],
    restitution: float = RESTITUTION_PRESETS["Rubber on concrete"],
    seed: int = 0,
    width: float = 6.0,
    height: float = 4.0,
    radii: tuple[float, float] = (0.05, 0.12),
    friction: float = 0.2,
    density: float = REFERENCE_DENSITY,
    speed: float = 1.0,
    **settings: Any,
) -> Arena:
    """A closed box with n balls, whose radii in m are uniformly distributed between the two given.

    gravity: m/s^2. restitution, friction: of balls and walls. speed: each component of a ball's
    initial velocity is uniform in [-speed, speed), m/s. settings: further ArenaSettings. Raises
    ParameterError for an invalid value, or if the balls do not fit.
    """
    n = _count(n)
    low, high = (number(r, "radii", 1e-6, 1e4) for r in radii)
    if low > high:
        raise ParameterError(f"radii is {radii!r}: the smaller must come first", field="radii")
    e = number(restitution, "restitution", 0.0, 1.0)
    geometry = StaticGeometry.box(width, height, restitution=e, friction=friction)
    arena = Arena(geometry, ArenaSettings(gravity=gravity, **settings))
    if n:
        x, y = _lattice(n, width, height, high, seed)
        arena.add_many(
            x,
            y,
            vx=_uniform(seed + 2, n, -speed, speed),
            vy=_uniform(seed + 3, n, -speed, speed),
            radius=_uniform(seed + 4, n, low, high),
            density=density,
            restitution=e,
            friction=friction,
        )
    return arena


def _lattice(
    n: int, width: float, height: float, radius: float, seed: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Centres of n balls of at most `radius` in a box: on a grid, each moved a little at random."""
    cell = _CELL * radius
    if n * cell * cell < 0.5 * width * height:  # spread them over all of the box
        cell = sqrt(0.5 * width * height / n)
    columns, rows = floor(width / cell), floor(height / cell)
    if columns * rows < n:
        raise ParameterError(
            f"n is {n!r}: only {columns * rows} balls with a radius of {radius:g} m fit into "
            f"{width:g} by {height:g} m",
            field="n",
        )
    number_of = np.arange(n)
    room = 0.5 * cell - radius
    x = -0.5 * width + (number_of % columns + 0.5) * (width / columns)
    y = (number_of // columns + 0.5) * (height / rows)
    return x + _uniform(seed, n, -room, room), y + _uniform(seed + 1, n, -room, room)


def galton(n: int = 400, *, seed: int = 0, **settings: Any) -> Arena:
    """Small balls that pile up on the preset `galton`, with a floor and walls between the bins.

    n: at most 1,500. settings: further ArenaSettings.
    """
    n = _count(n)
    board = Board.preset("galton")
    ball = board.ball
    bins, edges = board.bins, board.bins.edges
    depth = 1.2
    top, floor_y = bins.y, bins.y + depth
    spout = 0.35 * (edges[-1] - edges[0])
    cell = _CELL * ball.radius
    columns = floor(spout / cell)
    if n > 1500:
        raise ParameterError(f"n is {n!r}: at most 1500 balls fit into the bins", field="n")
    walls = [Wall(x, top, x, floor_y) for x in edges[1:-1]]
    rise = cell * (n // columns + 4)
    side = [
        Wall(edges[0], -rise, edges[0], floor_y),
        Wall(edges[-1], -rise, edges[-1], floor_y),
        Wall(edges[0], floor_y, edges[-1], floor_y),
    ]
    geometry = StaticGeometry(
        pegs=board.pegs,
        walls=(*side, *walls),
        peg_material=board.peg_material,
        wall_material=board.wall_material,
    )
    arena = Arena(geometry, ArenaSettings(gravity=board.gravity, drag=board.drag, **settings))
    number_of = np.arange(n)
    room = 0.5 * cell - ball.radius
    x = (number_of % columns - 0.5 * (columns - 1)) * cell + _uniform(seed, n, -room, room)
    y = board.drop.y - (number_of // columns) * cell + _uniform(seed + 1, n, -room, room)
    if n:
        arena.add_many(
            x, y, radius=ball.radius, density=ball.density,
            restitution=ball.restitution, friction=ball.friction,
        )  # fmt: skip
    return arena


def on_board(board: Board | str, **settings: Any) -> Arena:
    """An empty arena on a board or preset; a ball that crosses bins.y has landed and is removed."""
    board = Board.named(board)
    return Arena(
        StaticGeometry.of_board(board),
        ArenaSettings(**({"gravity": board.gravity, "drag": board.drag} | settings)),
    )
