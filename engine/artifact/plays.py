"""What is played once with the kernels of each artifact, so that all that Python calls is called.

Balls are few: kernels run as Python meanwhile.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from engine import Arena, Board, Place, drop, drop_many, occupancy
from engine.certified.reach import first_reaches


def exact() -> None:
    """Single drops of the exact solver."""
    done = drop(Board.preset("triangle-8"), seed=0)
    done.to_dict(certainty=True)
    done.states([0.1])


def many() -> None:
    """Many drops side by side, on both kinds of boards, and where they are."""
    drop_many(Board.preset("triangle-8"), [0, 1], threads=1)
    drop_many(_smooth(), [0, 1], threads=1)
    occupancy(_smooth(), [0], left=0.0, top=0.0, cells_per_metre=1.0, shape=(2, 2), threads=1)


def stepped() -> None:
    """Drops of the stepped solver."""
    drop(_smooth(), seed=0, solver="stepped")


def touching() -> None:
    """Balls that touch."""
    arena = Arena(Place.box(2.0, 2.0))
    arena.add(1.0, 1.0)
    arena.add(1.0, 1.1)
    for _ in range(3):
        arena.step()
    arena.diagnostics()


def certified() -> None:
    """What a proof leaves out; a ball that falls from (0, 0) beside nothing."""
    state, errors = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.81]), np.zeros(3)
    circles, lines, board = np.zeros((0, 3)), np.zeros((0, 7)), np.ones(6)
    numbers, times = np.zeros(1, np.int64), np.zeros(1)
    first_reaches(state, 0.0, errors, 0.0, -1, circles, lines, board, numbers, times)


def _smooth() -> Board:
    """A board without drag and friction."""
    board = Board.preset("triangle-8")
    return replace(board, drag=0.0, ball=replace(board.ball, friction=0.0))


PLAYS: Final[Mapping[str, Callable[[], None]]] = MappingProxyType(
    {play.__name__: play for play in (exact, many, stepped, touching, certified)}
)
"""Name of each artifact of this machine's own, and what its kernels do in it."""

VECTORS: Final = ("many",)
"""Artifacts with instructions for two numbers at a time. The lanes are made for them; what follows
one ball after the other takes as long as without.
"""
