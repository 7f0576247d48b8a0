"""Short programs that call every kernel of each artifact once, for record_types.py.

They use few balls, because the kernels run as Python meanwhile.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from plinko.engine import Arena, Board, StaticGeometry, drop, drop_many, occupancy
from plinko.engine.certified.reach import first_reaches


def exact() -> None:
    """Single drops of the exact solver."""
    done = drop(Board.preset("triangle-8"), seed=0)
    done.to_dict(certainty=True)
    done.states([0.1])


def many() -> None:
    """Batches with and without drag and friction, and their occupancy."""
    drop_many(Board.preset("triangle-8"), [0, 1], threads=1)
    drop_many(_smooth(), [0, 1], threads=1)
    occupancy(_smooth(), [0], left=0.0, top=0.0, cells_per_metre=1.0, shape=(2, 2), threads=1)


def stepped() -> None:
    """A drop of the stepped solver."""
    drop(_smooth(), seed=0, solver="stepped")


def touching() -> None:
    """Balls that touch."""
    arena = Arena(StaticGeometry.box(2.0, 2.0))
    arena.add(1.0, 1.0)
    arena.add(1.0, 1.1)
    for _ in range(3):
        arena.step()
    arena.diagnostics()


def certified() -> None:
    """The screen of the certified solver: a ball that falls from (0, 0) without any surface."""
    state, errors = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.81]), np.zeros(3)
    circles, lines, board = np.zeros((0, 3)), np.zeros((0, 7)), np.ones(6)
    numbers, times = np.zeros(1, np.int64), np.zeros(1)
    first_reaches(state, 0.0, errors, 0.0, -1, circles, lines, board, numbers, times)


def _smooth() -> Board:
    """A board with neither drag nor friction."""
    board = Board.preset("triangle-8")
    return replace(board, drag=0.0, ball=replace(board.ball, friction=0.0))


SAMPLE_CALLS: Final[Mapping[str, Callable[[], None]]] = MappingProxyType(
    {each.__name__: each for each in (exact, many, stepped, touching, certified)}
)
"""The name of each artifact that Python runs, and the function that calls its kernels."""

VECTORS: Final = ("many",)
"""Artifacts with vector instructions for two numbers. Only the lanes profit from them; kernels that
follow one ball at a time do not become faster.
"""
