"""The neighbour list: pairs that may touch, and their impulses for the warm start."""

from typing import NamedTuple

from plinko.engine.multibody.solver.layout.array_types import Floats, Ints

# Columns of `NeighbourList.impulse`: those of the last substep, N s.
NORMAL = 0
TANGENT = 1
TORQUE = 2  # of rolling resistance on the owner, N m s


class NeighbourList(NamedTuple):
    """All pairs that may touch before the list is rebuilt.

    One ball of a pair owns it: ball a owns the pairs starts[a] to starts[a + 1] - 1. `other` is the
    row of the other ball, or -1 - item for a fixed shape. Pairs of sleepers are not among them: of
    these, only the impulses are held.
    """

    starts: Ints  # (n + 1,)
    other: Ints  # (p,)
    impulse: Floats  # (p, 3): NORMAL, TANGENT, TORQUE
    neighbour_starts: Ints  # (n + 1,)
    neighbours: Ints  # of each ball, in all its pairs, owned or not; from neighbour_starts[ball] on
    held_starts: Ints  # (n + 1,): as `starts`, for the pairs of sleepers
    held_other: Ints  # (q,)
    held_impulse: Floats  # (q, 3): when they fell asleep
