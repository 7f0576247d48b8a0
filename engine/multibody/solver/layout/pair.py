"""The neighbour list as arrays: pairs that may touch, and the impulses kept for the warm start."""

from typing import NamedTuple

from engine.multibody.solver.layout.array_types import Floats, Ints

# Columns of `NeighbourList.impulse`: those of the last substep, N s.
NORMAL = 0
TANGENT = 1


class NeighbourList(NamedTuple):
    """Pairs that may touch until the next listing: ball a owns the rows starts[a] to starts[a+1].

    A pair belongs to one of its balls; the other is a ball's row, or -1 - item for a fixed one.
    """

    starts: Ints  # (n + 1,)
    other: Ints  # (p,)
    impulse: Floats  # (p, 2): NORMAL, TANGENT
    neighbour_starts: Ints  # (n + 1,)
    neighbours: Ints  # all that may touch a ball, whoever owns the pair; its starts are above
