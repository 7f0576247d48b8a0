"""SIAM 100-Digit Challenge, problem 2: the path of a photon among mirrors, to ten digits or more.

Mirrors of radius 1/3 stand at the integer points. A photon leaves (1/2, 1/10) eastwards with speed
1. How far from the origin is it at t = 10? Each of its 14 reflections multiplies an error.
"""

from dataclasses import dataclass
from math import hypot

from benchmarks.billiards import Billiard, path
from plinko.engine.board.parts import BallSpec, Peg
from plinko.engine.drops.certainty import certainty_of

TRUTH = "0.9952629194433541608903118094267216210294669227341543498032088580729861796228306"
"""Distance from the origin; Bornemann et al., The SIAM 100-Digit Challenge (2004), chapter 2."""

START = ("1/2", "1/10")
TIME = 10.0
MIRRORS = range(-3, 4)
"""Integer x and y of the mirrors in the scene: the photon goes no farther than (-2, 1.4)."""


@dataclass(frozen=True)
class DoublePrecision:
    """Distance at t = 10, its true error, and the engine's own estimate of the error."""

    distance: float
    reflections: int
    error: float
    estimate: float


def in_double_precision() -> DoublePrecision:
    """The exact solver's answer; the estimate is that for the last reflection's position."""
    mirrors = tuple(Peg(float(x), float(y), 0.25) for x in MIRRORS for y in MIRRORS)
    board = Billiard(pegs=mirrors, ball=BallSpec(radius=1.0 / 12.0, restitution=1.0))
    found = path(board, (0.5, 0.1), (1.0, 0.0), TIME)
    distance = hypot(float(found.end[1]), float(found.end[2]))
    errors = certainty_of(found).errors
    return DoublePrecision(
        distance, len(found.events), abs(distance - float(TRUTH)), float(errors[-1])
    )
