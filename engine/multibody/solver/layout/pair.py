"""The neighbour list: pairs that may touch, and their impulses for the warm start."""

from typing import NamedTuple

from plinko.engine.multibody.solver.layout.array_types import Floats, Ints

# Columns of `NeighbourList.impulse`: those of the last substep, N s.
NORMAL = 0
TANGENT = 1


class NeighbourList(NamedTuple):
    """All pairs that may touch before the list is rebuilt.

    One ball of a pair owns it: ball a owns the pairs starts[a] to starts[a + 1] - 1. `other` is the
    row of the other ball, or -1 - item for a fixed shape.
    """

    starts: Ints  # (n + 1,)
    other: Ints  # (p,)
    impulse: Floats  # (p, 2): NORMAL, TANGENT
    neighbour_starts: Ints  # (n + 1,)
    neighbours: Ints  # of each ball, in all its pairs, owned or not; from neighbour_starts[ball] on
