"""Billiards shared by the tests: a lattice, an open patch of it, a box."""

from benchmarks.billiards import Billiard
from plinko.engine.board.parts import BallSpec, Peg, Wall

BALL = BallSpec(radius=0.5, restitution=1.0)
SIDE = 2.3
"""m; spacing of the lattice. Discs and ball have radii of 0.5 m, which leaves gaps of 0.3 m."""

CELL = ((SIDE, 0.0), (0.5 * SIDE, 0.5 * 3.0**0.5 * SIDE))


def lattice(gravity: float = 0.0) -> Billiard:
    """One disc and its triangular lattice."""
    return Billiard(pegs=(Peg(0.0, 0.0, 0.5),), ball=BALL, cell=CELL, gravity=gravity)


def patch(reach: int = 8) -> Billiard:
    """The same lattice as an open board of (2 reach + 1)^2 discs."""
    (ax, ay), (bx, by) = CELL
    steps = range(-reach, reach + 1)
    pegs = tuple(Peg(i * ax + j * bx, i * ay + j * by, 0.5) for i in steps for j in steps)
    return Billiard(pegs=pegs, ball=BALL)


def box(side: float = 2.0) -> Billiard:
    """Four walls around the origin, and nothing else."""
    h = 0.5 * side + BALL.radius
    corners = [(-h, -h), (h, -h), (h, h), (-h, h)]
    ends = zip(corners, [*corners[1:], corners[0]], strict=True)
    return Billiard(walls=tuple(Wall(*a, *b) for a, b in ends), ball=BALL)
