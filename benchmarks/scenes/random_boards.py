"""Random valid boards, and starts that aim at their delicate places."""

import numpy as np

from plinko.engine import Board
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall
from plinko.engine.errors import BoardError

TRIES = 400
"""Most boards to try until one is valid. Most are refused for a gap in which a ball can wedge."""


def random_board(seed: int) -> Board:
    """A valid board from `seed`, with random pegs, slanted bars, material, gravity, drag, scale."""
    rng = np.random.default_rng(seed)
    for _ in range(TRIES):
        try:
            return _attempt(rng)
        except BoardError:  # refused by the validator
            continue
    raise RuntimeError(f"no valid board in {TRIES} attempts from seed {seed}")


def _attempt(rng: np.random.Generator) -> Board:
    scale = 10.0 ** rng.uniform(-2.0, 2.0)
    ball = rng.uniform(0.05, 0.2)
    width = rng.uniform(2.0, 6.0)
    height = rng.uniform(2.0, 6.0)
    pegs = _pegs(rng, width, height, ball)
    half = 0.5 * width
    bottom = height + ball
    walls = [(-half, -1.0, -half, bottom + 0.5), (half, -1.0, half, bottom + 0.5)]
    walls += _bars(rng, width, height) if rng.random() < 0.3 else []
    edges = np.linspace(-half, half, int(rng.integers(2, 12)))
    return Board(
        name="random",
        width=scale * width,
        height=scale * bottom,
        gravity=scale * _spread(rng, 9.81, 3.0),
        drag=0.0 if rng.random() < 0.4 else _spread(rng, 1.0, 2.0),
        ball=BallSpec(scale * ball, _spread(rng, 80.0, 4.0), *_surface(rng)),
        pegs=tuple(Peg(*(scale * value for value in peg)) for peg in pegs),
        peg_material=Material(*_surface(rng)),
        walls=tuple(Wall(*(scale * value for value in wall)) for wall in walls),
        wall_material=Material(*_surface(rng)),
        bins=Bins(scale * bottom, tuple(scale * edges), tuple(1.0 for _ in edges[1:])),
        drop=DropZone(0.0, scale * -0.5, scale * 0.9 * (half - ball)),
    )


def _pegs(
    rng: np.random.Generator, width: float, height: float, ball: float
) -> list[tuple[float, float, float]]:
    """Pegs with gaps of at least a ball between each other and to the walls."""
    found: list[tuple[float, float, float]] = []
    slack = 1.0 + 10.0 ** rng.uniform(-6.0, 0.0)
    for _ in range(int(rng.integers(1, 120))):
        radius = rng.uniform(0.02, 0.3)
        reach = radius + 2.0 * ball * slack
        x = rng.uniform(-0.5 * width + reach, 0.5 * width - reach)
        y = rng.uniform(ball, height)
        if 0.5 * width > reach and all(
            np.hypot(x - px, y - py) > reach + other for px, py, other in found
        ):
            found.append((x, y, radius))
    return found


def _bars(
    rng: np.random.Generator, width: float, height: float
) -> list[tuple[float, float, float, float]]:
    found = []
    for _ in range(int(rng.integers(1, 4))):
        x, y = rng.uniform(-0.3 * width, 0.3 * width), rng.uniform(0.2 * height, 0.9 * height)
        long, turn = rng.uniform(0.05, 0.3) * width, rng.uniform(0.0, np.pi)
        found.append((x, y, x + long * np.cos(turn), y + long * np.sin(turn)))
    return found


def _surface(rng: np.random.Generator) -> tuple[float, float]:
    """Random restitution and friction, sometimes at the ends of their ranges.

    Restitution 1 is rare: a ball that loses no energy bounces until it runs out of events, which
    takes a second.
    """
    extremes = [0.0, 1.0, 0.999999, rng.uniform()]
    restitution = float(rng.choice(extremes, p=[0.25, 0.02, 0.02, 0.71]))
    friction = float(rng.choice([0.0, 10.0, 10.0 ** rng.uniform(-6.0, 1.0), rng.uniform()]))
    return restitution, friction


def _spread(rng: np.random.Generator, middle: float, decades: float) -> float:
    """A random number around `middle`, at most `decades` decades away."""
    return float(middle * 10.0 ** rng.uniform(-decades, decades))


def starts(board: Board, count: int, seed: int) -> list[float]:
    """Starts in the drop zone: half anywhere, half above the middle or the rim of a peg."""
    rng = np.random.default_rng([seed, 1])
    low = board.drop.x - board.drop.jitter
    high = board.drop.x + board.drop.jitter
    found: list[float] = rng.uniform(low, high, count).tolist()
    for i in range(0, count, 2):
        peg = board.pegs[int(rng.integers(len(board.pegs)))] if board.pegs else None
        if peg is None:
            continue
        reach = peg.radius + board.ball.radius
        x = peg.x + reach * float(rng.choice([-1.0, 0.0, 1.0]))
        x += float(rng.integers(-4, 5)) * float(np.spacing(abs(x)))
        if low <= x <= high:
            found[i] = x
    return found
