"""Short programs that call every kernel of each artifact once, for record_types.py.

They use few balls, because the kernels run as Python meanwhile.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from plinko import engine
from plinko.engine import Arena, Board, StaticGeometry, drop
from plinko.engine.certified.reach import first_reaches
from plinko.engine.constants import MAX_TIME
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.lanes.trace import KERNELS, Drops, trace_drops
from plinko.engine.exact.outcome import MAX_EVENTS, new_results


def exact() -> None:
    """Single drops of the exact solver."""
    done = drop(Board.preset("triangle-8"), seed=0)
    done.to_dict(certainty=True)
    done.states([0.1])


def occupancy() -> None:
    """The occupancy of a batch."""
    engine.occupancy(
        _smooth(), [0], left=0.0, top=0.0, cells_per_metre=1.0, shape=(2, 2), threads=1
    )


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
    arena.remove(0)


def certified() -> None:
    """The screen of the certified solver: a ball that falls from (0, 0) without any surface."""
    state, errors = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.81]), np.zeros(3)
    circles, lines, board = np.zeros((0, 3)), np.zeros((0, 7)), np.ones(6)
    numbers, times = np.zeros(1, np.int64), np.zeros(1)
    first_reaches(state, 0.0, errors, 0.0, -1, circles, lines, board, numbers, times)


def lanes() -> None:
    """Batches in lanes, with and without drag and friction; for native libraries only."""
    for board in (Board.preset("triangle-8"), _smooth()):
        drops = Drops(np.array([0.0, 0.01]), board.drop.y, MAX_EVENTS, MAX_TIME)
        trace_drops(arrays_of(board), drops, new_results(2), KERNELS)


def _smooth() -> Board:
    """A board with neither drag nor friction."""
    board = Board.preset("triangle-8")
    return replace(board, drag=0.0, ball=replace(board.ball, friction=0.0))


SAMPLE_CALLS: Final[Mapping[str, Callable[[], None]]] = MappingProxyType(
    {each.__name__: each for each in (exact, occupancy, stepped, touching, certified)}
)
"""The name of each artifact that Python runs, and the function that calls its kernels."""
