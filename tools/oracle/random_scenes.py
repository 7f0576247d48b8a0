"""Random boards by seed: pegs and walls of any size and slope, and any physics."""

import math
import random

from plinko.engine.board.model import Board
from plinko.engine.board.parts import Bins, Peg, Wall
from tools.oracle.scenes import scene

_SIDE = 1.3  # m: distance of the upright side walls from the middle
_SIDES = (Wall(-_SIDE, -1.2, -_SIDE, 2.2), Wall(_SIDE, -1.2, _SIDE, 2.2))
_BINS = Bins(2.0, (-_SIDE, -0.6, 0.0, 0.6, _SIDE), (1.0, 1.0, 1.0, 1.0))


def random_scene(seed: int) -> tuple[Board, float]:
    """A board and a start x in m. On a few boards the ball gets stuck."""
    choice = random.Random(seed)
    pegs = _pegs(choice)
    walls = _walls(choice)
    board = scene(
        pegs=pegs,
        walls=(*walls, *_SIDES),
        restitution=choice.choice([0.0, 0.2, 0.5, 0.7, 0.9]),
        friction=choice.choice([0.0, 0.05, 0.2, 0.5, 1.2]),
        drag=choice.choice([0.0, 0.01, 0.5, 2.0, 5.0]),
        gravity=choice.choice([1.62, 9.81, 24.79]),
        radius=choice.choice([0.05, 0.1, 0.15]),
        bins=_BINS,
        start_y=-0.7,
    )
    return board, choice.uniform(-0.9, 0.9)


def _pegs(choice: random.Random) -> tuple[Peg, ...]:
    """Two to fourteen pegs that do not overlap."""
    pegs: list[Peg] = []
    for _ in range(choice.randint(2, 14)):
        x, y = choice.uniform(-1.0, 1.0), choice.uniform(0.0, 1.8)
        radius = choice.choice([0.001, 0.02, 0.05, 0.1, 0.3])
        if all(math.hypot(x - p.x, y - p.y) > radius + p.radius + 0.01 for p in pegs):
            pegs.append(Peg(x, y, radius))
    return tuple(pegs)


def _walls(choice: random.Random) -> list[Wall]:
    """Up to five walls, some continued at an angle from their end."""
    walls: list[Wall] = []
    for _ in range(choice.randint(0, 5)):
        x, y = choice.uniform(-1.0, 1.0), choice.uniform(0.0, 1.8)
        flat = choice.random() < 0.8
        angle = choice.uniform(-0.7, 0.7) if flat else choice.uniform(0.0, 2.0 * math.pi)
        length = choice.choice([0.05, 0.3, 1.0])
        end = x + length * math.cos(angle), y + length * math.sin(angle)
        walls.append(Wall(x, y, *end))
        if choice.random() < 0.3:
            angle += choice.uniform(-0.6, 0.6)
            walls.append(Wall(*end, end[0] + 0.4 * math.cos(angle), end[1] + 0.4 * math.sin(angle)))
    return walls
